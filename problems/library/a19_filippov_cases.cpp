// Four cases of a discontinuous field that acts on a scalar state for 1.5 s.
//
//   crossing            x' = 2 | 0.2           x(0) = -1    crosses at 0.5, x(1.5) = 0.2, slope 0.1
//   entering sliding    x' = 1 | -1            x(0) = -0.5  stays at 0 from 0.5 on, slope 0
//   leaving sliding     x' = 1 + t | -1 + t    x(0) = 0     leaves upwards at 1, x(1.5) = 0.125
//   spontaneous         x' = -1 | 1            x(0) = 0     not unique: has to be reported
//
// The columns give the field for x < 0 | for x > 0 and the derivative dx(1.5)/dx(0).
// Source: nosbench, different_switching_cases; closed forms.
#include "problems/library/hybrid_systems.hpp"
#include "problems/library/motion.hpp"
#include "problems/library/simulations.hpp"

namespace saltus::library {
namespace {

HybridSimulation simulate_case(Ramp below, Ramp above, double start) {
  return simulate_tightly(scalar_filippov(below, above), numbers({start}), numbers({0.0, 1.5}));
}

std::vector<CheckedValue> run() {
  constexpr double tolerance = 1e-12;  // local error; fields are constant or linear in time
  constexpr int exact = 16;            // digits
  const HybridSimulation crossing = simulate_case({2.0, 0.0}, {0.2, 0.0}, -1.0);
  const HybridSimulation entering = simulate_case({1.0, 0.0}, {-1.0, 0.0}, -0.5);
  const HybridSimulation leaving = simulate_case({1.0, 1.0}, {-1.0, 1.0}, 0.0);
  const HybridSimulation spontaneous = simulate_case({-1.0, 0.0}, {1.0, 0.0}, 0.0);
  const bool reported = spontaneous.status == IntegrationStatus::non_unique;
  return {{"crossing: time", event_time(crossing, 0), 0.5, tolerance, exact},
          {"crossing: x(1.5)", crossing.states(0, 1), 0.2, tolerance, exact},
          {"crossing: slope", crossing.derivative(0, 0), 0.1, tolerance, exact},
          {"entering: time", event_time(entering, 0), 0.5, tolerance, exact},
          {"entering: x(1.5)", entering.states(0, 1), 0.0, tolerance, exact},
          {"entering: slope", entering.derivative(0, 0), 0.0, tolerance, exact},
          {"leaving: time", event_time(leaving, 1), 1.0, tolerance, exact},
          {"leaving: x(1.5)", leaving.states(0, 1), 0.125, tolerance, exact},
          {"spontaneous: reported", reported ? 1.0 : 0.0, 1.0, 0.0, exact}};
}

std::vector<Motion> motions(const IntegratorChoice& scheme) {
  const auto motion = [&](const char* name, Ramp below, Ramp above, double start) {
    Motion m = simulate_motion(scalar_filippov(below, above), scheme ? scheme : tight_scheme(),
                               numbers({start}), even_times(0.0, 1.5, 60));
    m.name = name;
    m.recording.state_names = {"x"};
    return m;
  };
  return {motion("crossing", {2.0, 0.0}, {0.2, 0.0}, -1.0),
          motion("entering", {1.0, 0.0}, {-1.0, 0.0}, -0.5),
          motion("leaving", {1.0, 1.0}, {-1.0, 1.0}, 0.0)};
}

}  // namespace

SimulationCase filippov_cases() {
  return {.id = "A19",
          .name = "filippov_cases",
          .summary =
              "Motions of discontinuous fields: crossing, sliding, leaving, and one that is not "
              "unique.",
          .exercises = "crossing, entering and leaving sliding; a motion that is not unique",
          .source = "nosbench different_switching_cases; closed forms",
          .run = run,
          .motions = motions};
}

}  // namespace saltus::library
