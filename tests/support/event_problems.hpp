// Small problems with an event, and functions that read their programs.
#pragma once

#include <string>
#include <vector>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::testing_support {

struct Velocity {  // x' = u
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return u;
  }
};

inline constexpr auto state = [](const auto&, const auto& x) { return x; };
inline constexpr auto input = [](const auto&, const auto&, const auto& u) { return u; };
inline constexpr auto one = [](const auto& t, const auto&) { return 0.0 * t + 1.0; };

inline const ShootingOptions ten{.intervals_per_phase = 10, .integrator = runge_kutta4()};

/// x' = u for one second from x = 1, with the event "impact" at the given time.
OptimalControlProblem with_impact(const Phase<1, 1>& phase, double impact);

/// Times in ascending order at which rows of the term have a finite bound.
std::vector<double> active_times(MultipleShooting& shooting, const std::string& term);

/// Bounds of input 0 of a phase as pairs of start time and bounds, one for each interval. Empty
/// slots are left out.
struct InputBounds {
  double from, to;
  Bounds bounds;
};

std::vector<InputBounds> input_bounds(MultipleShooting& shooting, int phase = 0);

/// Cost of the program at the point with every state equal to x and every input equal to u.
double cost_at(MultipleShooting& shooting, double x, double u);

}  // namespace saltus::testing_support
