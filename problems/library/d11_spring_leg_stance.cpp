// A spring as the leg of a runner: vertical stance between touchdown and lift-off.
//
//   y'' = -g + w^2 (l0 - y) while y < l0, -g above   w^2 = k / m, m = 80 kg, k = 20 kN/m
//
// From touchdown at -1 m/s the stance lasts (2 / w) (pi - atan(w |v| / g)), the leg is compressed
// by (g + sqrt(g^2 + w^2 v^2)) / w^2, and lift-off is at +1 m/s: no energy is lost.
// Source: Blickhan, The spring-mass model for running and hopping, 1989; closed form.
#include "problems/library/hybrid_systems.hpp"
#include "problems/library/motion.hpp"
#include "problems/library/simulations.hpp"

namespace saltus::library {
namespace {

std::vector<CheckedValue> run() {
  constexpr double tolerance = 1e-12, v = 1.0;  // m/s at touchdown, downwards
  const SpringLeg leg;
  // The flight begins 50 ms before touchdown.
  const double fall = 0.05, g = leg.gravity, w = leg.frequency();
  const VectorXd start = numbers({fall * (v - 0.5 * g * fall), -v + g * fall});
  const double lowest = fall + (std::numbers::pi - std::atan(w * v / g)) / w;
  const HybridSimulation sim = simulate_tightly(leg.problem(), start, numbers({0.0, lowest, 0.4}));
  const bool both = sim.events.size() == 2;
  return {{"time of touchdown", event_time(sim, 0), fall, tolerance, 16},
          {"stance", event_time(sim, 1) - event_time(sim, 0), 0.268933880738875, tolerance, 15},
          {"speed at touchdown", both ? sim.events[0].before[1] : std::nan(""), -v, tolerance, 16},
          {"largest compression", -sim.states(0, 1), 0.113669682251102, tolerance, 15},
          {"speed at lift-off", both ? sim.events[1].after[1] : std::nan(""), v, tolerance, 16}};
}

std::vector<Motion> motions(const IntegratorChoice& scheme) {
  const SpringLeg leg;
  const double fall = 0.05, v = 1.0;  // s, m/s
  Motion motion =
      simulate_motion(leg.problem(), scheme ? scheme : tight_scheme(),
                      numbers({fall * (v - 0.5 * leg.gravity * fall), -v + leg.gravity * fall}),
                      even_times(0.0, 0.4, 200));
  motion.recording.state_names = {"height over the rest length [m]", "speed [m/s]"};
  return {motion};
}

}  // namespace

SimulationCase spring_leg_stance() {
  return {.id = "D11",
          .name = "spring_leg_stance",
          .summary = "A runner's leg as a spring: stance between touchdown and lift-off.",
          .exercises = "two events without jumps, and the trajectory between them",
          .source = "Blickhan 1989; closed form",
          .run = run,
          .motions = motions};
}

}  // namespace saltus::library
