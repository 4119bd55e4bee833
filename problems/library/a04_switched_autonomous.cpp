// A linear system without input switches once. The switching time is free.
//
//   min int_0^1 x'x   x' = A1 x until tau, then x' = A2 x   x(0) = (1, 1)
//   A1 = [-1 0; 1 2], A2 = [1 1; 1 -2]
//
// Guess: the constant start, half a second per mode.
// Source: M. Egerstedt, Y. Wardi and H. Axelsson, Transition-time optimization for switched-mode
// dynamical systems, IEEE TAC 51 (2006) 110-115. The optimum is from B. Stellato, S. Ober-Bloebaum
// and P. Goulart, SwitchTimeOpt.jl (2017); more digits come from matrix exponentials.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Linear {
  Mat<double, 2, 2> A;

  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x) const {
    return {A(0, 0) * x[0] + A(0, 1) * x[1], A(1, 0) * x[0] + A(1, 1) * x[1]};
  }
};

OptimalControlProblem problem() {
  const auto energy = [](const auto&, const auto& x) { return x[0] * x[0] + x[1] * x[1]; };
  const Linear mode1{(Mat<double, 2, 2>() << -1.0, 0.0, 1.0, 2.0).finished()};
  const Linear mode2{(Mat<double, 2, 2>() << 1.0, 1.0, 1.0, -2.0).finished()};
  const Bounds part = between(0.0, 1.0);  // s, of one second

  Phase<2, 0> first{"mode 1", mode1, part}, second{"mode 2", mode2, part};
  for (auto* phase : {&first, &second}) phase->minimise("energy", energy).guess_duration(0.5);
  OptimalControlProblem ocp("switched autonomous");
  ocp.start_at({1, 1}).then(first).then(second);
  ocp.total_time(exactly(1.0));
  return ocp;
}

std::vector<CheckedValue> more(const Solution& s) {
  // J is quadratic in the start: the multipliers must satisfy x0' dJ/dx0 = 2 J.
  return {{"x0' dJ/dx0", s.start_multipliers.sum(), 2.0 * 5.2545429449232242, 1e-8, 17}};
}

}  // namespace

ReferenceCase switched_autonomous() {
  return {.id = "A04",
          .name = "switched_autonomous",
          .summary = "Optimal switching time of a linear system without inputs.",
          .states = {"x1", "x2"},
          .exercises = "phases without inputs, one free switching time",
          .source = "Egerstedt, Wardi and Axelsson, IEEE TAC 51 (2006); matrix exponentials",
          .problem = problem,
          .options = {.intervals_per_phase = 5, .integrator = runge_kutta8()},
          .optimum = 5.2545429449232242,
          .digits = 17,
          .tolerance = 1e-9,  // tolerance of the solver; steps of order eight are accurate to 1e-11
          .switching_times = {0.26486609904077944},
          .switching_tolerance = 1e-7,  // square root of the solver's error in the cost
          .more = more};
}

}  // namespace saltus::library
