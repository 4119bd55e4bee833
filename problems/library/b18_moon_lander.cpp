// Soft landing on the Moon with minimum fuel: free fall, then full thrust.
//
//   max m(tf)   h' = v, v' = -1 + T / m, m' = -T / 2.349   T = 0, then T = 1.227
//   h(0) = 1, v(0) = -0.783, m(0) = 1, h(tf) = v(tf) = 0   in units of lunar gravity
//
// For 0 <= T <= 1.227 the minimum principle permits no other order. The two conditions at the
// ground determine both durations, so nothing is left to optimise: the solver only has to find
// these durations.
// Guess: the constant start, 0.5 for the coast and 0.5 for the burn.
// Source: J. Meditch, On the problem of optimal thrust programming for a lunar soft landing, IEEE
// TAC 9 (1964); data of Becerra, PSOPT examples, and of dymos (0.3953). Closed form: Tsiolkovsky's
// equation and its integral.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double full_thrust = 1.227;
constexpr double exhaust_speed = 2.349;

struct Lander {  // x = (height, speed upwards, mass)
  double thrust;

  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x) const {
    return {x[1], thrust / x[2] - 1.0, S(-thrust / exhaust_speed)};
  }
};

OptimalControlProblem problem() {
  const auto height = [](const auto&, const auto& x) { return x[0]; };
  const auto speed = [](const auto&, const auto& x) { return x[1]; };
  const auto minus_mass = [](const auto&, const auto& x) { return -x[2]; };

  Phase<3, 0> coast{"coast", Lander{0.0}, between(0.0, 2.0)};
  coast.guess_duration(0.5);

  Phase<3, 0> burn{"burn", Lander{full_thrust}, between(0.0, 1.5)};
  burn.reach("ground", height, exactly(0.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("fuel", minus_mass)
      .guess_duration(0.5);

  OptimalControlProblem ocp("moon lander");
  ocp.start_at({1, -0.783, 1}).then(coast).then(burn);
  return ocp;
}

std::vector<CheckedValue> more(const Solution& s) {
  return {{"tf", s.trajectory.end_time(), 1.396808089107, 1e-8, 13},
          {"int T", full_thrust * s.durations[1], 1.420312599049, 1e-8, 13}};
}

}  // namespace

ReferenceCase moon_lander() {
  return {.id = "B18",
          .name = "moon_lander",
          .summary = "Soft landing on the Moon with the least fuel: fall freely, then brake.",
          .states = {"height", "speed upwards", "mass"},
          .exercises = "two free durations, determined by the constraints; no inputs",
          .source = "Meditch, IEEE TAC 9 (1964), data of PSOPT and dymos; closed form",
          .problem = problem,
          .options = {.intervals = {1, 10}, .integrator = runge_kutta8()},
          .optimum = -0.395354363964,
          .digits = 12,
          .tolerance = 1e-9,  // tolerance of the solver
          .switching_times = {0.239259108626},
          .switching_tolerance = 1e-8,  // the constraints determine it
          .more = more};
}

}  // namespace saltus::library
