// An F-8 Crusader leaves a stall in minimum time. The tail deflection jumps between its two limits
// in four arcs and begins with the positive one.
//
//   x0' = -0.877 x0 + x2 - 0.088 x0 x2 + 0.47 x0^2 - 0.019 x1^2 - x0^2 x2 + 3.846 x0^3
//         - 0.215 w + 0.28 x0^2 w + 0.47 x0 w^2 + 0.63 w^3
//   x1' = x2
//   x2' = -4.208 x0 - 0.396 x2 - 0.47 x0^2 - 3.564 x0^3
//         - 20.967 w + 6.265 x0^2 w + 46 x0 w^2 + 61.4 w^3
//   min T   w = +, -, +, - 0.05236   x(0) = (0.4655, 0, 0), x(T) = 0
//
// Guess: one second per arc, with simulated states. Each arc lasts at least 0.1 s, because an arc
// of zero length removes the switches of its neighbours, and many guesses end there.
// Source: W. Garrard and J. Jordan, Design of nonlinear automatic flight control systems,
// Automatica 13 (1977); Sager, mintOC.de, F-8 aircraft: 3.78086. C. Kaya and J. Noakes,
// Computational method for time-optimal switching control, JOTA 117 (2003), give a local minimum
// with six arcs at 5.74217. Further digits were computed independently.
#include <fmt/format.h>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double largest_deflection = 0.05236;  // rad, 3 degrees

struct Aircraft {  // x = (angle of attack rad, pitch rad, pitch rate rad/s)
  double w;        // tail deflection, rad

  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x) const {
    const S a = x[0], pitch = x[1], rate = x[2];
    const S a2 = a * a, a3 = a2 * a;
    const double w2 = w * w, w3 = w2 * w;
    return {-0.877 * a + rate - 0.088 * a * rate + 0.47 * a2 - 0.019 * pitch * pitch - a2 * rate +
                3.846 * a3 - 0.215 * w + 0.28 * w * a2 + 0.47 * w2 * a + 0.63 * w3,
            rate,
            -4.208 * a - 0.396 * rate - 0.47 * a2 - 3.564 * a3 - 20.967 * w + 6.265 * w * a2 +
                46.0 * w2 * a + 61.4 * w3};
  }
};

OptimalControlProblem problem() {
  const auto state = [](const auto&, const auto& x) { return x; };
  const auto clock = [](const auto& t, const auto&) { return t; };

  OptimalControlProblem ocp("F-8 aircraft");
  ocp.start_at({0.4655, 0, 0});
  for (int arc = 0; arc < 4; ++arc) {
    const double w = arc % 2 == 0 ? largest_deflection : -largest_deflection;
    Phase<3, 0> phase{fmt::format("arc {}", arc + 1), Aircraft{w}, between(0.1, 3.0)};
    phase.guess_state(Guess::simulate()).guess_duration(1.0);
    if (arc == 3) phase.reach("level", state, exactly(0.0)).minimise_at_end("time", clock);
    ocp.then(phase);
  }
  return ocp;
}

std::vector<CheckedValue> more(const Solution& s) {
  return {{"last arc", s.durations[3], 0.69137475765, 1e-4, 11}};
}

}  // namespace

ReferenceCase f8_aircraft() {
  return {.id = "A09",
          .name = "f8_aircraft",
          .summary =
              "Minimum-time recovery of an F-8 Crusader from a stall, with the tail at its limits.",
          .states = {"angle of attack [rad]", "pitch [rad]", "pitch rate [rad/s]"},
          .exercises = "minimum time, four arcs without inputs, nonlinear dynamics",
          .source = "mintOC and PSOPT; more digits computed independently",
          .problem = problem,
          .options = {.intervals = {8, 3, 8, 5}, .integrator = runge_kutta8({.steps = 3})},
          .optimum = 3.7808557746787,
          .digits = 14,
          .tolerance = 1e-9,  // tolerance of the solver
          .switching_times = {1.13483594302, 1.48144618919, 3.08948101703},
          .more = more};
}

}  // namespace saltus::library
