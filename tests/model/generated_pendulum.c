// Functions in the form of CasADi's generated code: y = (x1, p0 sin(x0) + u0), with companions.
typedef long long integer;

double sin(double);
double cos(double);

static const integer scalar[] = {1, 1, 1};
static const integer pair[] = {2, 1, 1};
static const integer jacobian[] = {2, 5, 0, 0, 1, 2, 3, 4, 1, 0, 1, 1};  // (1,1) (0,2) (1,3) (1,4)
static const integer hessian[] = {5, 5, 0, 0, 2, 2, 2, 2, 1, 4};         // (1,1) (4,1)

#define ABOUT(name, inputs, outputs, in, out)                                                      \
  integer name##_n_in(void) { return inputs; }                                                     \
  integer name##_n_out(void) { return outputs; }                                                   \
  const integer* name##_sparsity_in(integer i) { return in; }                                      \
  const integer* name##_sparsity_out(integer i) { return out; }                                    \
  int name##_work(integer* arguments, integer* results, integer* integers, integer* reals) {       \
    *arguments = inputs;                                                                           \
    *results = outputs;                                                                            \
    *integers = 0;                                                                                 \
    *reals = 1;                                                                                    \
    return 0;                                                                                      \
  }

#define INPUT (i == 1 || i == 4 ? pair : scalar)
ABOUT(pendulum, 4, 1, INPUT, pair)
ABOUT(pendulum_jacobian, 4, 2, INPUT, i == 0 ? pair : jacobian)
ABOUT(pendulum_hessian, 5, 1, INPUT, hessian)
ABOUT(alone, 4, 1, INPUT, pair)
ABOUT(upper, 4, 1, INPUT, pair)
ABOUT(upper_jacobian, 4, 2, INPUT, i == 0 ? pair : jacobian)
static const integer whole[] = {5, 5, 1};
ABOUT(upper_hessian, 5, 1, INPUT, whole)

int pendulum(const double** arg, double** res, integer* iw, double* w, int memory) {
  if (arg[1][0] > 100.0) return 1;
  res[0][0] = arg[1][1];
  res[0][1] = arg[3][0] * sin(arg[1][0]) + arg[2][0];
  return 0;
}
int pendulum_jacobian(const double** arg, double** res, integer* iw, double* w, int memory) {
  if (pendulum(arg, res, iw, w, memory)) return 1;
  res[1][0] = arg[3][0] * cos(arg[1][0]);
  res[1][1] = 1.0;
  res[1][2] = 1.0;
  res[1][3] = sin(arg[1][0]);
  return 0;
}
int pendulum_hessian(const double** arg, double** res, integer* iw, double* w, int memory) {
  res[0][0] = -arg[4][1] * arg[3][0] * sin(arg[1][0]);
  res[0][1] = arg[4][1] * cos(arg[1][0]);
  return 0;
}
int alone(const double** arg, double** res, integer* iw, double* w, int memory) {
  return pendulum(arg, res, iw, w, memory);
}
int upper(const double** arg, double** res, integer* iw, double* w, int memory) {
  return pendulum(arg, res, iw, w, memory);
}
int upper_jacobian(const double** arg, double** res, integer* iw, double* w, int memory) {
  return pendulum_jacobian(arg, res, iw, w, memory);
}
int upper_hessian(const double** arg, double** res, integer* iw, double* w, int memory) { return 1; }
