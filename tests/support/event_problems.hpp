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
inline OptimalControlProblem with_impact(const Phase<1, 1>& phase, double impact) {
  OptimalControlProblem ocp("event test");
  ocp.schedule(Schedule({"before", "after"}, {{"impact", impact}})).start_at({1}).then(phase);
  return ocp;
}

/// Times at which rows of the term have a finite bound, in order.
inline std::vector<double> active_times(MultipleShooting& shooting, const std::string& term) {
  std::vector<double> times;
  const NonlinearProgram& nlp = shooting.nlp();
  for (int r = 0; r < nlp.rows(); ++r) {
    const std::string text = nlp.describe_row(r);
    if (text.find("term '" + term + "'") == std::string::npos) continue;
    if (std::isinf(nlp.row_lower()[r]) && std::isinf(nlp.row_upper()[r])) continue;
    times.push_back(std::stod(text.substr(text.find("t = ") + 4)));
  }
  return times;
}

/// Bounds of input 0 of a phase, interval by interval, as pairs of start time and bounds. Empty
/// slots are left out.
struct InputBounds {
  double from, to;
  Bounds bounds;
};
inline std::vector<InputBounds> input_bounds(MultipleShooting& shooting, int phase = 0) {
  std::vector<InputBounds> result;
  for (int k = 0; k < shooting.grid().intervals(phase); ++k) {
    if (shooting.grid().interval(phase, k).is_empty()) continue;
    const int v = shooting.layout().input(phase, k);
    result.push_back({shooting.grid().node_offset(phase, k),
                      shooting.grid().node_offset(phase, k + 1),
                      {shooting.nlp().lower()[v], shooting.nlp().upper()[v]}});
  }
  return result;
}

/// The cost of the program at the point where every state is x and every input u.
inline double cost_at(MultipleShooting& shooting, double x, double u) {
  NlpPoint point = shooting.initial_guess();
  const Grid& grid = shooting.grid();
  for (int j = 0; j < grid.phases(); ++j)
    for (int k = 0; k <= grid.intervals(j); ++k) {
      point.w[shooting.layout().state(j, k)] = x;
      if (k < grid.intervals(j)) point.w[shooting.layout().input(j, k)] = u;
    }
  double cost = 0.0;
  EXPECT_TRUE(shooting.nlp().objective(point.w.data(), cost));
  return cost;
}

}  // namespace saltus::testing_support
