// The saltation matrix, the effect of an event on first-order variations, at the first impact of
// the ball.
//
//   Xi = R_x + (f+ - R_x f- - R_t) g_x / (g_t + g_x f-),   here [-e 0; -(1 + e) g / v-  -e]
//
// Free fall on both sides of the impact is a known linear map of the start. Xi is the derivative
// over a short interval that contains the impact, without these maps.
// Source: Aizerman and Gantmacher 1958; closed form with the numbers of D07.
#include <Eigen/LU>

#include "problems/library/hybrid_systems.hpp"
#include "problems/library/motion.hpp"
#include "problems/library/simulations.hpp"

namespace saltus::library {
namespace {

Mat<double, 2, 2> free_fall(double time) {
  Mat<double, 2, 2> map;
  map << 1.0, time, 0.0, 1.0;
  return map;
}

std::vector<CheckedValue> run() {
  constexpr double g = 9.81, e = 0.8, half = 1e-3;  // s, from the impact to either end
  const double impact = std::sqrt(2.0 / g), from = impact - half;
  const HybridSimulation sim =
      simulate_tightly(bouncing_ball(), numbers({1.0 - 0.5 * g * from * from, -g * from}),
                       numbers({from, impact + half}), numbers({g, e}));
  const Mat<double, 2, 2> xi =
      free_fall(half).inverse() * sim.derivative.leftCols(2) * free_fall(half).inverse();
  constexpr double tolerance = 1e-10;  // 100 times the local error
  return {{"Xi11", xi(0, 0), -e, tolerance, 16},
          {"Xi12", xi(0, 1), 0.0, tolerance, 16},
          {"Xi21", xi(1, 0), 3.98650222626302, tolerance, 15},
          {"Xi22", xi(1, 1), -e, tolerance, 16}};
}

std::vector<Motion> motions(const IntegratorChoice& scheme) {
  Motion motion =
      simulate_motion(bouncing_ball(), scheme ? scheme : tight_scheme(), numbers({1.0, 0.0}),
                      even_times(0.0, 1.0, 200), numbers({9.81, 0.8}));
  motion.recording.state_names = {"height [m]", "speed [m/s]"};
  return {motion};
}

}  // namespace

SimulationCase saltation_matrix() {
  return {.id = "D09",
          .name = "saltation_matrix",
          .summary = "First-order variations through an event: the first impact of a ball.",
          .exercises = "first-order variations through a jump",
          .source = "Aizerman and Gantmacher 1958; closed form",
          .run = run,
          .motions = motions};
}

}  // namespace saltus::library
