// The interface of all integrators: one shooting interval, its end state and running costs, and
// their derivatives with respect to everything that enters the interval.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/model/algebraic.hpp"
#include "saltus/model/arguments.hpp"
#include "saltus/model/function.hpp"
#include "saltus/model/switching_system.hpp"

namespace saltus {

/// The input over one interval of length h, s = (t - t0) / h in [0, 1].
enum class InputShape {
  constant,  ///< u(s) = c0; nu coefficients
  linear     ///< u(s) = c0 + s (c1 - c0); 2 nu coefficients (c0 | c1)
};

/// What is integrated over an interval: x' = f(t, x, u(t), p) and q' = L(t, x, u(t), p), q(0) = 0.
struct IntervalProblem {
  IntervalProblem();
  IntervalProblem(const IntervalProblem& other);
  IntervalProblem(IntervalProblem&& other) noexcept;
  IntervalProblem& operator=(const IntervalProblem& other);
  IntervalProblem& operator=(IntervalProblem&& other) noexcept;
  ~IntervalProblem();

  Arguments arguments;                      ///< sizes; both functions take z = (t | x | u | p)
  Function dynamics;                        ///< nx outputs
  Function running_cost;                    ///< nq outputs; empty when nothing is accumulated
  InputShape shape = InputShape::constant;  ///< how the input runs over the interval
  /// Which parameters are differentiated (size np; empty means none).
  std::vector<bool> differentiate_parameter;
  /// Whether derivatives with respect to start time and length are wanted.
  bool differentiate_time = false;
  /// Typical magnitudes of the states (nx; empty means ones): they scale absolute tolerances.
  VectorXd nominal_state = {};
  /// Modes and state-triggered events; empty: `dynamics` everywhere. Otherwise `dynamics` are
  /// those of the first mode, and the mode at the start follows from the state.
  SwitchingSystem switching = {};
  /// Of a differential-algebraic phase, from which z is eliminated in all functions above: what
  /// integrators may take that know z themselves. Empty: an ordinary one.
  AlgebraicPart algebraic = {};

  /// The same problem with functions of its own (Function::separate()). Handles on one function
  /// stay so; a function that cannot be separated is shared.
  IntervalProblem separate() const;

  /// How many running costs.
  int nq() const { return running_cost ? running_cost.outputs() : 0; }
  /// How many numbers stand for the input of an interval.
  int coefficients() const {
    return shape == InputShape::constant ? arguments.nu : 2 * arguments.nu;
  }
};

/// Order of the interval's own argument: w = (x0 | c | p | t0 | h).
struct IntervalArguments {
  int nx = 0;  ///< states
  int nc = 0;  ///< number of input coefficients
  int np = 0;  ///< parameters

  /// Place of state i at the start.
  constexpr int x(int i = 0) const { return i; }
  /// Place of coefficient i of the input.
  constexpr int c(int i = 0) const { return nx + i; }
  /// Place of parameter i.
  constexpr int p(int i = 0) const { return nx + nc + i; }
  /// Place of the time of the start.
  constexpr int t0() const { return nx + nc + np; }
  /// Place of the length.
  constexpr int h() const { return nx + nc + np + 1; }
  /// How many numbers in all.
  constexpr int size() const { return nx + nc + np + 2; }
};

/// Outcome of one integration. Failures are results, not exceptions: a solver may try elsewhere.
enum class IntegrationStatus {
  success,
  not_finite,       ///< the right-hand side or the state became NaN or infinite
  too_many_steps,   ///< the step limit was reached before the end of the interval
  step_too_small,   ///< error control or the nonlinear solver failed repeatedly
  library_failure,  ///< any other code of the underlying library
  // Of intervals with events; see framework/design/events.md.
  grazing,          ///< a guard is touched without being crossed: no derivative exists
  ambiguous_start,  ///< on a guard whose rate of change is zero: no mode is distinguished
  non_unique,       ///< on a surface that both fields push away from
  beyond_guard,     ///< no mode fits the state, or a reset leads behind or onto a guard
  accumulation,     ///< events without end in finite time (Zeno), or more than the limit
  sliding_input,    ///< sliding on a guard that reads an input which is not constant
  backward,         ///< negative length: a reset cannot be undone
};
/// In words, for messages.
const char* describe(IntegrationStatus status);

/// Integrates one interval, for one thread at a time. Objects own their working memory, including
/// that of the functions: no allocation after construction for the fixed-step schemes. Length h = 0
/// is allowed and is the identity with q = 0 (its derivative with respect to h is f and L at the
/// start).
class Integrator {
 public:
  /// Keeps the problem, with separate() functions; a scheme makes integrators.
  explicit Integrator(const IntervalProblem& problem);
  virtual ~Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  /// What it integrates.
  const IntervalProblem& problem() const { return problem_; }
  /// Sizes of what it takes.
  IntervalArguments arguments() const { return interval_arguments_; }
  /// States at the end, then running costs.
  int outputs() const { return problem_.arguments.nx + problem_.nq(); }

  /// end = (x(t0 + h) | q(t0 + h)), nx + nq entries.
  virtual IntegrationStatus value(const double* w, double* end) = 0;

  /// Also fills d end / d w, (nx + nq) x arguments().size(), already sized by the caller. Columns
  /// of parameters or times that are not differentiated are zero.
  virtual IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) = 0;

  /// Whether hessian() is available for this problem (sensitivities of second order).
  virtual bool has_hessian() const { return false; }

  /// Fills the symmetric matrix sum_i weights[i] d2 end_i / dw2 (both triangles). With
  /// Curvature::gauss_newton the curvature of the dynamics is dropped and the running costs
  /// contribute their own Gauss-Newton matrix along first-order sensitivities.
  virtual IntegrationStatus hessian(const double* w, const double* weights, MatrixXd& hessian,
                                    Curvature curvature);

  /// Both of the above: what finds the Hessian often has the Jacobian already.
  virtual IntegrationStatus derivatives(const double* w, const double* weights, double* end,
                                        MatrixXd& derivative, MatrixXd& hessian,
                                        Curvature curvature);

  /// Whether each call evaluates the running costs along the interval. If not, their coefficients
  /// are kept between calls, and all of them must be evaluated.
  virtual bool follows_running_costs() const { return true; }

  /// A sentence on the most recent call that failed, with time, mode and event where there are
  /// any; empty if none failed or the status says all there is to say.
  virtual std::string failure() const { return {}; }

 private:
  IntervalProblem problem_;
  IntervalArguments interval_arguments_;
};

/// A choice of method and tolerances: makes one Integrator per phase. Value semantics.
class IntegratorScheme {
 public:
  virtual ~IntegratorScheme() = default;
  /// Throws DefinitionError when the method does not fit the problem (for example the exact
  /// zero-order hold and nonlinear dynamics), naming the reason.
  virtual std::unique_ptr<Integrator> make(const IntervalProblem& problem) const = 0;
  /// For results and messages, e.g. "CVODES BDF, tolerance 1e-09".
  virtual std::string name() const = 0;
};
/// What a user chooses; may be shared by all phases.
using IntegratorChoice = std::shared_ptr<const IntegratorScheme>;

}  // namespace saltus
