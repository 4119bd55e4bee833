// A ball is dropped from 1 m and loses a fifth of its speed at every impact.
//
//   h' = v, v' = -g; where h falls to 0: v+ = -e v-   h(0) = 1, v(0) = 0, e = 0.8, g = 9.81
//
// The impacts occur at t1 = sqrt(2 h0 / g) and then after flights of 2 e^k t1. They accumulate at
// t1 (1 + e) / (1 - e) = 4.0637 s, and the model has no solution beyond. A simulation to 5 s must
// stop there and report it. The sensitivities are those of the closed form.
#include <fmt/format.h>

#include "problems/library/hybrid_systems.hpp"
#include "problems/library/motion.hpp"
#include "problems/library/simulations.hpp"

namespace saltus::library {
namespace {

const VectorXd start = numbers({1.0, 0.0}), parameters = numbers({9.81, 0.8});

std::vector<CheckedValue> run() {
  std::vector<CheckedValue> values;
  const HybridSimulation sim =
      simulate_tightly(bouncing_ball(), start, numbers({0.0, 1.0, 2.0, 3.0}), parameters);
  const std::vector<double> impacts{0.451523640985731, 1.1739614665629,  1.75191172702464,
                                    2.21427193539402,  2.58416010208954, 2.88007063544594};
  for (std::size_t i = 0; i < impacts.size(); ++i)
    values.push_back({fmt::format("t{}", i + 1), event_time(sim, i), impacts[i], 1e-12, 15});
  Mat<double, 2, 3> states;
  states << 0.468004452526036, 0.260741728327057, 0.0687074609657657,  //
      -1.83699554747396, -0.165869135836471, -0.0153541333847448;
  for (int k = 0; k < 3; ++k) {  // ten times the local error
    values.push_back({fmt::format("h({})", k + 1), sim.states(0, k + 1), states(0, k), 1e-11, 15});
    values.push_back({fmt::format("v({})", k + 1), sim.states(1, k + 1), states(1, k), 1e-11, 15});
  }

  const HybridSimulation second =
      simulate_tightly(bouncing_ball(), start, numbers({0.0, 1.0}), parameters);
  const std::vector<std::string> by{"h0", "v0", "g", "e"};
  Mat<double, 2, 4> slopes;
  slopes << 1.38650222626302, 0.187257446225684, -0.0936287231128422, 2.42944691807002,  //
      3.98650222626302, 1.0, -0.593628723112842, 4.42944691807002;
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 4; ++k)
      values.push_back({fmt::format("d{}(1)/d{}", i == 0 ? "h" : "v", by[k]),
                        second.derivative(i, k), slopes(i, k), 1e-9, 15});

  const HybridSimulation zeno =
      simulate_tightly(bouncing_ball(), start, numbers({0.0, 5.0}), parameters);
  const bool reported = zeno.status == IntegrationStatus::accumulation &&
                        zeno.message.find("t = 4.0637") != std::string::npos;
  values.push_back({"accumulation at 4.0637 s: reported", reported ? 1.0 : 0.0, 1.0, 0.0, 16});
  return values;
}

std::vector<Motion> motions(const IntegratorChoice& scheme) {
  Motion motion = simulate_motion(bouncing_ball(), scheme ? scheme : tight_scheme(), start,
                                  even_times(0.0, 3.0, 600), parameters);
  motion.recording.state_names = {"height [m]", "speed [m/s]"};
  return {motion};
}

}  // namespace

SimulationCase bouncing_ball_simulation() {
  return {.id = "D07",
          .name = "bouncing_ball",
          .summary = "A ball that loses a fifth of its speed at every impact.",
          .exercises = "impacts: times, sensitivities, accumulation",
          .source = "closed form",
          .run = run,
          .motions = motions};
}

}  // namespace saltus::library
