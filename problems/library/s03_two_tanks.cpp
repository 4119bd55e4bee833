// Two tanks: one pump fills the first tank, another pumps from the first into the second one, which
// leaks and supplies a plant. Each pump is on or off; the valve in the outlet is continuous.
//
//   h1' = (q1 s1 - q2 s2) / A - c h1,   h2' = (q2 s2 - v) / A - c h2,   s1, s2 in {0, 1}
//   min sum_k h (10 (h1 - 0.3)^2 / 2 + 40 (h2 - 0.4)^2 / 2 + 4 (v - 0.6)^2 / 2 + e (s1 + s2))
//   0.05 <= h1 <= 0.6, 0.05 <= h2 <= 0.6 (m),   0 <= v <= 1 (10^-4 m^3/s)
//
// A = 0.0154 m^2, q1 = q2 = 10^-4 m^3/s, c = 0.0008 / s, e = 0.05, sample 30 s; weights are per s,
// times 1/30. A pump runs for at least one minute.
// Source: levels, section and flow of the two-tank benchmark in the literature on mixed logical
// dynamical systems; the other numbers are our own.
#include <fmt/format.h>

#include "problems/library/mode_graphs.hpp"

namespace saltus::library {
namespace {

constexpr double sample = 30.0;     // s
constexpr double section = 0.0154;  // m^2
constexpr double flow = 1e-4;       // m^3/s
constexpr double leak = 0.0008;     // 1/s

struct Tanks {
  double fills, lifts;  // 0 or 1

  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& h, const Vec<S, 1>& v) const {
    return {flow / section * (fills - lifts) - leak * h[0],
            flow / section * (lifts - v[0]) - leak * h[1]};
  }
};

}  // namespace

ModeGraph two_tanks(const VectorXd& start) {
  ModeGraph graph("two tanks");
  for (int choice = 0; choice < 4; ++choice) {
    const double fills = choice & 1, lifts = choice >> 1, running = fills + lifts;
    const std::string name = fmt::format("pumps {:.0f}{:.0f}", fills, lifts);
    Phase<2, 1> phase{name, Tanks{fills, lifts}, exactly(sample)};
    phase.bound_input(0, between(0.0, 1.0))
        .bound_state(0, between(0.05, 0.6))
        .bound_state(1, between(0.05, 0.6))
        .track(
            "levels", [](const auto&, const auto& h) { return h; },
            Vec<double, 2>(10.0, 40.0) / sample, {}, VectorXd(Vec<double, 2>(0.3, 0.4)))
        .track(
            "demand", [](const auto&, const auto&, const auto& v) { return v; },
            Vec<double, 1>(4.0 / sample), {}, VectorXd(Vec<double, 1>(0.6)))
        .minimise(
            "energy",
            [running](const auto&, const auto& h) { return 0.05 / sample * running + 0.0 * h[0]; })
        .nominal(VectorXd::Constant(2, 0.1), VectorXd::Ones(1));
    graph.mode(phase);
    if (choice > 0) graph.dwell(name, 2);
  }
  graph.all_transitions()
      .minimise_at_end<2>("levels at the end",
                          [](const auto&, const auto& h) {
                            const auto a = h[0] - 0.3, b = h[1] - 0.4;
                            return 50.0 * a * a + 200.0 * b * b;
                          })
      .costs(CostRule::nodes)  // discrete time, as in the literature
      .start_at(start);
  return graph;
}

}  // namespace saltus::library
