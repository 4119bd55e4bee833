// The stiff oscillator of van der Pol: slow motion for hundreds of seconds, then a jump within a
// millisecond.
//
//   y1' = y2, y2' = 1e3 (1 - y1^2) y2 - y1             y(0) = (2, 0), at t = 2000
//   y1' = y2, y2' = ((1 - y1^2) y2 - y1) / 1e-6        y(0) = (2, 0), at t = 2
//
// The second form is the first one in the time t / 1000.
// Source: Hairer and Wanner, Solving Ordinary Differential Equations II, sec. IV.10; test set for
// initial value problem solvers (1.706167732170483, -8.928097010247975e-4).
#include "problems/library/initial_value_problems.hpp"
#include "problems/library/motion.hpp"
#include "problems/library/simulations.hpp"
#include "saltus/integrators/sundials.hpp"

namespace saltus::library {
namespace {

// Global error of CVODES with a local tolerance of 1e-12: measured 4e-10 after three jumps.
constexpr double relative = 1e-9;

std::vector<CheckedValue> run() {
  const auto scheme = cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-14});
  const auto at = [&](const IntervalProblem& problem, double time) {
    return integrate(*scheme->make(problem), (VectorXd(4) << 2.0, 0.0, 0.0, time).finished());
  };
  const VectorXd slow = at(van_der_pol(1.0, 1e3), 2000.0);
  const VectorXd fast = at(van_der_pol(1e6, 1e6), 2.0);
  const auto check = [](const char* name, double value, double reference) {
    return CheckedValue{name, value, reference, relative * std::abs(reference), 14};
  };
  return {check("y1(2000)", slow[0], 1.70616773217042),
          check("y2(2000)", slow[1], -8.92809701024858e-4),
          check("y1(2), short form", fast[0], 1.70616773217041),
          check("y2(2), short form", fast[1], -0.892809701024870)};
}

std::vector<Motion> motions(const IntegratorChoice& scheme) {
  const IntegratorChoice own = cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-14});
  // A jump lasts a thousandth of the time, so it is sampled every tenth of a second.
  VectorXd times(4002);
  times << even_times(0.0, 800.0, 1000), even_times(801.0, 820.0, 2000),
      even_times(821.0, 2000.0, 999);
  Motion motion = simulate_motion(van_der_pol(1.0, 1e3), scheme ? scheme : own,
                                  (VectorXd(2) << 2.0, 0.0).finished(), times);
  motion.recording.state_names = {"y1", "y2"};
  return {motion};
}

}  // namespace

SimulationCase van_der_pol_stiff() {
  return {.id = "D01",
          .name = "van_der_pol_stiff",
          .summary = "Van der Pol's oscillator in its stiff regime.",
          .exercises = "CVODES (BDF) on a stiff oscillator, two scalings",
          .source = "IVP test set; Hairer and Wanner; recomputed independently",
          .run = run,
          .motions = motions};
}

}  // namespace saltus::library
