// Small problems around an event, and what their programs say about it.
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

/// x' = u for one second, from 1; event "impact" at the given time.
OptimalControlProblem with_impact(const Phase<1, 1>& phase, double impact);

/// Times at which rows of the term have a finite bound, in order.
std::vector<double> active_times(MultipleShooting& shooting, const std::string& term);

/// Bounds of input 0 of a phase, interval by interval, as pairs of start time and bounds. Empty
/// slots are left out.
struct InputBounds {
  double from, to;
  Bounds bounds;
};

std::vector<InputBounds> input_bounds(MultipleShooting& shooting, int phase = 0);

/// The cost of the program at the point where every state is x and every input u.
double cost_at(MultipleShooting& shooting, double x, double u);

}  // namespace saltus::testing_support
