// Two tanks, one above the other. The inflow w brings the lower tank to a level of 3 and holds it
// there.
//
//   min int_0^10 2 (x2 - 3)^2   x1' = 1 + w - sqrt(x1), x2' = sqrt(x1) - sqrt(x2), 0 <= w <= 1
//   x(0) = (2, 2)
//
// The optimum has full inflow first and a singular arc with w = sqrt(3) - 1 at the end. It appears
// to enter the arc by chattering; entering it without overshoot costs 4.4e-5 more (4.731349). The
// inflow of the second phase is piecewise constant and reproduces a few of the switches. Plans with
// other switching times have the same cost to 1e-6, so only the cost is a reference.
// Guess: both levels at 3, no inflow, five time units per phase.
// Source: Sager, mintOC.de, double tank; the relaxed optimum was computed independently.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Tanks {  // x = (upper level, lower level), w = inflow
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& w) const {
    const S out_of_upper = sqrt(x[0]), out_of_lower = sqrt(x[1]);
    return {1.0 + w[0] - out_of_upper, out_of_upper - out_of_lower};
  }
};

OptimalControlProblem problem() {
  const auto lower_level = [](const auto&, const auto& x) { return x[1]; };
  const Vec<double, 2> desired{3.0, 3.0};
  const Bounds part = between(0.5, 9.5);  // ten time units in total

  Phase<2, 1> fill{"fill", Tanks{}, part}, hold{"hold", Tanks{}, part};
  fill.bound_input(0, exactly(1.0));
  hold.bound_input(0, between(0.0, 1.0));
  OptimalControlProblem ocp("double tank");
  ocp.start_at({2, 2});
  for (auto* phase : {&fill, &hold}) {
    phase
        ->track("lower level", lower_level, Vec<double, 1>{4.0}, Window{},
                Reference(Vec<double, 1>{3.0}))
        .bound_state(0, at_least(0.1))  // the square roots need positive levels
        .bound_state(1, at_least(0.1))
        .guess_state(Guess::constant(desired))
        .guess_duration(5.0);
    ocp.then(*phase);
  }
  ocp.total_time(exactly(10.0));
  return ocp;
}

std::vector<CheckedValue> more(const Solution& s) {
  // With 3 in the lower tank, the upper one is at 3 too. The chattering is below 1e-4.
  return {{"w at the end", s.trajectory.input(9.9)[0], 0.7320508, 1e-3, 7},
          {"x2(10)", s.trajectory.final_state()[1], 3.0, 1e-3, 7}};
}

}  // namespace

ReferenceCase double_tank() {
  return {.id = "A11",
          .name = "double_tank",
          .summary = "Two tanks in series: the inflow keeps the lower one at its level.",
          .states = {"upper level", "lower level"},
          .inputs = {"inflow"},
          .exercises = "bang, then singular, with chattering in between",
          .source = "mintOC, relaxed; computed independently to six digits",
          .problem = problem,
          .options = {.intervals = {6, 30}, .integrator = runge_kutta8()},
          .optimum = 4.731305,
          .digits = 6,
          .tolerance = 1e-5,  // pieces of 0.15 s chatter more slowly than the optimum
          .more = more};
}

}  // namespace saltus::library
