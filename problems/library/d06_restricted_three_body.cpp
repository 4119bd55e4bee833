// A satellite between earth and moon on Arenstorf's orbit, which closes after one period. It passes
// both bodies so closely that errors grow by a factor of 1e4 to 1e5.
//
//   y1'' = y1 + 2 y2' - (1 - mu) (y1 + mu) / r1^3 - mu (y1 - 1 + mu) / r2^3
//   y2'' = y2 - 2 y1' - (1 - mu) y2 / r1^3 - mu y2 / r2^3
//
// Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, sec. II.0.
#include "problems/library/initial_value_problems.hpp"
#include "problems/library/motion.hpp"
#include "problems/library/simulations.hpp"
#include "saltus/integrators/sundials.hpp"

namespace saltus::library {
namespace {

constexpr double closing_error = 1e-8;  // a local error of 1e-13, amplified along the orbit

std::vector<CheckedValue> run() {
  const auto integrator =
      arkode({.order = 8, .tolerance = 1e-13, .absolute_tolerance = 1e-15})->make(arenstorf());
  const VectorXd w = arenstorf_point();
  const VectorXd end = integrate(*integrator, w);
  const int digits[] = {15, 1, 1, 16};  // for references that are zero: decimals
  const char* names[] = {"y1(T)", "y2(T)", "y1'(T)", "y2'(T)"};
  std::vector<CheckedValue> values;
  for (int i = 0; i < 4; ++i)
    values.push_back({names[i], end[i], w[i], closing_error * (1.0 + std::abs(w[i])),
                      w[i] == 0.0 ? 0 : digits[i]});
  return values;
}

std::vector<Motion> motions(const IntegratorChoice& scheme) {
  const IntegratorChoice own =
      arkode({.order = 8, .tolerance = 1e-13, .absolute_tolerance = 1e-15});
  const VectorXd w = arenstorf_point();
  Motion motion =
      simulate_motion(arenstorf(), scheme ? scheme : own, w.head(4), even_times(0.0, w[5], 2000));
  motion.recording.state_names = {"y1", "y2", "y1'", "y2'"};
  motion.plane = {"y1", "y2"};
  return {motion};
}

}  // namespace

SimulationCase restricted_three_body() {
  return {.id = "D06",
          .name = "restricted_three_body",
          .summary = "Arenstorf's periodic orbit of a satellite between the Earth and the Moon.",
          .exercises = "ARKODE (order 8) on a periodic orbit",
          .source = "Arenstorf 1963; Hairer, Norsett and Wanner, sec. II.0",
          .run = run,
          .motions = motions};
}

}  // namespace saltus::library
