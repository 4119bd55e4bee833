// Two linear modes with quadratic costs and one free switching time.
//
//   min 1/2 (x1(2) - 4)^2 + 1/2 (x2(2) - 2)^2 + 1/2 int_0^2 (x2 - 2)^2 + u^2
//   mode 1   x' = [0.6 1.2; -0.8 3.4] x + [1; 1] u
//   mode 2   x' = [4 3; -1 0] x + [2; -1] u
//   x(0) = (0, 2)
//
// Guess: the constant start, no input, one second per mode.
// Source: X. Xu and P. J. Antsaklis, Optimal control of switched systems based on parameterization
// of the switching instants, IEEE TAC 49 (2004) 2-16: 9.7667, switch at 0.1897. Further digits were
// computed independently by collocation.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Linear {  // x' = A x + b u
  Mat<double, 2, 2> A;
  Vec<double, 2> b;

  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {A(0, 0) * x[0] + A(0, 1) * x[1] + b[0] * u[0],
            A(1, 0) * x[0] + A(1, 1) * x[1] + b[1] * u[0]};
  }
};

OptimalControlProblem problem() {
  const auto second_state = [](const auto&, const auto& x) { return x[1]; };
  const auto input = [](const auto&, const auto&, const auto& u) { return u; };
  const auto state = [](const auto&, const auto& x) { return x; };
  const Linear mode1{(Mat<double, 2, 2>() << 0.6, 1.2, -0.8, 3.4).finished(), {1.0, 1.0}};
  const Linear mode2{(Mat<double, 2, 2>() << 4.0, 3.0, -1.0, 0.0).finished(), {2.0, -1.0}};
  const Vec<double, 1> one{1.0};
  const Bounds part = between(0.01, 1.99);  // s, of two seconds

  Phase<2, 1> first{"mode 1", mode1, part}, second{"mode 2", mode2, part};
  for (auto* phase : {&first, &second})
    phase->track("x2", second_state, one, Window{}, Reference(Vec<double, 1>{2.0}))
        .track("input", input, one)
        .inputs(InputParametrisation::piecewise_linear_continuous)
        .guess_duration(1.0);
  second.track_at_end("final", state, Vec<double, 2>{1.0, 1.0},
                      Reference(Vec<double, 2>{4.0, 2.0}));

  OptimalControlProblem ocp("linear-quadratic switch");
  ocp.start_at({0, 2}).then(first).then(second);
  ocp.total_time(exactly(2.0));
  return ocp;
}

std::vector<CheckedValue> more(const Solution& s) {
  const VectorXd& end = s.trajectory.final_state();
  // Half a unit of the last digit, plus the excess of order h^4.
  return {{"x1(2)", end[0], 4.1865221, 1e-7, 8}, {"x2(2)", end[1], 2.3470228, 1e-7, 8}};
}

}  // namespace

ReferenceCase linear_quadratic_switch() {
  return {.id = "A02",
          .name = "linear_quadratic_switch",
          .summary = "Optimal switching time between two linear modes with quadratic costs.",
          .states = {"x1", "x2"},
          .inputs = {"u"},
          .exercises = "linear-quadratic except for one free switching time",
          .source = "Xu and Antsaklis, IEEE TAC 49 (2004); more digits computed independently",
          .problem = problem,
          .options = {.intervals = {8, 40}, .integrator = runge_kutta8()},
          .optimum = 9.7665488,
          .digits = 8,
          // Piecewise linear inputs cost an excess of order h^4.
          .tolerance = 1e-6,
          .switching_times = {0.1896711},
          .more = more};
}

}  // namespace saltus::library
