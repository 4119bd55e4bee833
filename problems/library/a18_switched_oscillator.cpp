// An oscillator changes its sense of rotation on the unit circle, at a time that is known exactly.
//
//   x' = [1 -w; w 1] x where |x| < 1, [1 w; -w 1] x where |x| > 1, w = 2 pi, x(0) = (1/e, 0)
//
// |x| = exp(t - 1) crosses 1 at t = 1, after one turn; then x(t) = exp(t - 1) (cos w(t - 1), -sin
// w(t - 1)). The end is t = pi/2.
// Source: nosnoc, examples/oscilator_integrator_order; closed form.
#include "problems/library/hybrid_systems.hpp"
#include "problems/library/motion.hpp"
#include "problems/library/simulations.hpp"

namespace saltus::library {
namespace {

std::vector<CheckedValue> run() {
  constexpr double tolerance = 1e-10;  // 100 times the local error
  const HybridSimulation sim = simulate_tightly(oscillator(), numbers({std::exp(-1.0), 0.0}),
                                                numbers({0.0, std::numbers::pi / 2}));
  return {{"time of the switch", event_time(sim, 0), 1.0, tolerance, 16},
          {"x1(pi/2)", sim.states(0, 1), -1.59746037745070, tolerance, 15},
          {"x2(pi/2)", sim.states(1, 1), 0.76149362060601, tolerance, 14}};
}

std::vector<Motion> motions(const IntegratorChoice& scheme) {
  Motion motion =
      simulate_motion(oscillator(), scheme ? scheme : tight_scheme(),
                      numbers({std::exp(-1.0), 0.0}), even_times(0.0, std::numbers::pi / 2, 400));
  motion.recording.state_names = motion.plane = {"x1", "x2"};
  return {motion};
}

}  // namespace

SimulationCase switched_oscillator() {
  return {.id = "A18",
          .name = "switched_oscillator",
          .summary = "An oscillator whose sense of rotation changes on the unit circle.",
          .exercises = "a crossing located on a curved surface",
          .source = "nosnoc examples/oscilator_integrator_order; closed form",
          .run = run,
          .motions = motions};
}

}  // namespace saltus::library
