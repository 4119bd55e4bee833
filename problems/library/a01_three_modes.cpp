// Three nonlinear modes in a given order, with two free switching times and an unbounded continuous
// input.
//
//   min 1/2 (x1(3) - 1)^2 + 1/2 (x2(3) + 1)^2 + 1/2 int_0^3 (x1 - 1)^2 + (x2 + 1)^2 + u^2
//   mode 1   x1' =  x1 + u sin x1    x2' = -x2 - u cos x2
//   mode 2   x1' =  x2 + u sin x2    x2' = -x1 - u cos x1
//   mode 3   x1' = -x1 - u sin x1    x2' =  x2 + u cos x2
//   x(0) = (2, 3)
//
// Guess: states on the straight line from the start to (1, -1), the target of the costs; no input;
// one second per mode. From other guesses, such as the constant start, solvers may end at a local
// minimum without mode 3 (6.2204).
// Source: X. Xu and P. J. Antsaklis, Optimal control of switched systems based on parameterization
// of the switching instants, IEEE TAC 49 (2004) 2-16. Its coarser discretisation gives 5.4399 with
// switches at 0.2262 and 1.0176. The values here come from indirect shooting on the minimum
// principle and from collocation, which agree.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct First {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[0] + u[0] * sin(x[0]), -x[1] - u[0] * cos(x[1])};
  }
};

struct Second {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1] + u[0] * sin(x[1]), -x[0] - u[0] * cos(x[0])};
  }
};

struct Third {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {-x[0] - u[0] * sin(x[0]), x[1] + u[0] * cos(x[1])};
  }
};

OptimalControlProblem problem() {
  const auto running = [](const auto&, const auto& x, const auto& u) {
    const auto a = x[0] - 1.0, b = x[1] + 1.0;
    return 0.5 * (a * a + b * b + u[0] * u[0]);
  };
  const Bounds part = between(0.01, 2.9);  // s, of three seconds

  Phase<2, 1> first{"mode 1", First{}, part}, second{"mode 2", Second{}, part};
  Phase<2, 1> third{"mode 3", Third{}, part};
  for (auto* phase : {&first, &second, &third})
    phase->minimise("running", running)
        .inputs(InputParametrisation::piecewise_linear_continuous)
        .guess_duration(1.0);
  const Vec<double, 2> start{2.0, 3.0}, third_of_way{-1.0 / 3.0, -4.0 / 3.0};
  first.guess_state(Guess::interpolate(start, start + third_of_way));
  second.guess_state(Guess::interpolate(start + third_of_way, start + 2.0 * third_of_way));
  third.guess_state(Guess::interpolate(start + 2.0 * third_of_way, start + 3.0 * third_of_way));
  third.minimise_at_end("final", [](const auto&, const auto& x) {
    const auto a = x[0] - 1.0, b = x[1] + 1.0;
    return 0.5 * (a * a + b * b);
  });

  OptimalControlProblem ocp("three modes");
  ocp.start_at(start).then(first).then(second).then(third);
  ocp.total_time(exactly(3.0));
  return ocp;
}

std::vector<CheckedValue> more(const Solution& s) {
  const VectorXd& end = s.trajectory.final_state();
  // Order h^4, like the error of the cost.
  return {{"x1(3)", end[0], 0.35962100, 1e-6, 8},
          {"x2(3)", end[1], -1.24841296, 1e-6, 9},
          {"dJ/dx1(0)", s.start_multipliers[0], 0.21802723, 1e-6, 8},
          {"dJ/dx2(0)", s.start_multipliers[1], 1.9607058, 1e-6, 8}};
}

}  // namespace

ReferenceCase three_modes() {
  return {
      .id = "A01",
      .name = "three_modes",
      .summary = "Optimal input and switching times of three nonlinear modes in a given order.",
      .states = {"x1", "x2"},
      .inputs = {"u"},
      .exercises = "three modes, two free switching times, a given total time, a continuous input",
      .source = "Xu and Antsaklis, IEEE TAC 49 (2004); computed by indirect shooting",
      .problem = problem,
      .options = {.intervals = {6, 16, 36}, .integrator = runge_kutta8()},
      .optimum = 5.440973502366,
      .digits = 13,
      // Piecewise linear inputs cost an excess of order h^4.
      .tolerance = 1e-6,
      .switching_times = {0.22451846, 1.02002463},
      .more = more};
}

}  // namespace saltus::library
