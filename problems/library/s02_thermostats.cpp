// Three rooms in a row exchange heat and lose it to the outside. Each has a heater that is on or
// off, at most two are on, and each combination lasts at least half an hour.
//
//   T_i' = (q s_i - a (T_i - T_out) - b sum_neighbours (T_i - T_j)),  s_i in {0, 1}
//   min sum_k h (sum_i w/2 (T_i - 21)^2 + e s_i),   17 <= T_i <= 25
//
// a = 0.25 / h, b = 0.4 / h, q = 9 K/h, T_out = 2 deg C, w = 1 / K^2 h, e = 0.6 / h, sample 10 min.
// Source: after the temperature control of A. Bemporad and M. Morari, Control of systems
// integrating logic, dynamics, and constraints (Automatica, 1999), and later problems with
// hysteresis thermostats in several rooms. The numbers are our own.
#include <fmt/format.h>

#include <array>

#include "problems/library/mode_graphs.hpp"

namespace saltus::library {
namespace {

constexpr double sample = 1.0 / 6.0;            // h
constexpr double outside = 2.0, wanted = 21.0;  // deg C
constexpr double loss = 0.25, exchange = 0.4;   // 1/h
constexpr double heating = 9.0;                 // K/h
constexpr double price = 0.6;                   // per hour and heater

struct Rooms {
  std::array<bool, 3> heated;

  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& T) const {
    Vec<S, 3> rate;
    for (int i = 0; i < 3; ++i) {
      rate[i] = (heated[i] ? heating : 0.0) - loss * (T[i] - outside);
      if (i > 0) rate[i] += exchange * (T[i - 1] - T[i]);
      if (i < 2) rate[i] += exchange * (T[i + 1] - T[i]);
    }
    return rate;
  }
};

}  // namespace

ModeGraph thermostats(const VectorXd& start) {
  ModeGraph graph("thermostats");
  for (int choice = 0; choice < 7; ++choice) {  // without 7: all three
    const std::array<bool, 3> heated{(choice & 1) != 0, (choice & 2) != 0, (choice & 4) != 0};
    const double on = heated[0] + heated[1] + heated[2];
    const std::string name = fmt::format("heat {:d}{:d}{:d}", heated[0], heated[1], heated[2]);
    Phase<3, 0> phase{name, Rooms{heated}, exactly(sample)};
    phase
        .track(
            "comfort", [](const auto&, const auto& T) { return T; }, VectorXd::Ones(3), {},
            VectorXd(VectorXd::Constant(3, wanted)))
        .minimise("energy", [on](const auto&, const auto& T) { return price * on + 0.0 * T[0]; });
    for (int i = 0; i < 3; ++i) phase.bound_state(i, between(17.0, 25.0));
    graph.mode(phase).dwell(name, 3);
  }
  graph.all_transitions()
      .minimise_at_end<3>("comfort at the end",
                          [](const auto&, const auto& T) {
                            auto cost = 0.0 * T[0];
                            for (int i = 0; i < 3; ++i)
                              cost += 0.5 * (T[i] - wanted) * (T[i] - wanted);
                            return cost;
                          })
      .costs(CostRule::nodes)  // discrete time, as in the paper
      .start_at(start);
  return graph;
}

}  // namespace saltus::library
