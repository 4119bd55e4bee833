// A mass on a line, as a cart or as a ball under gravity, with goals that many tests share: x =
// (position m, speed m/s), u = acceleration by the input in m/s^2.
#pragma once

#include "saltus/core/types.hpp"

namespace saltus::testing_support {

inline constexpr double gravity = 9.81;  // m/s^2

struct Cart {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0]};
  }
};

struct Ball {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - gravity};
  }
};

inline constexpr auto position = [](const auto&, const auto& x) { return x[0]; };
inline constexpr auto height = position;
inline constexpr auto speed = [](const auto&, const auto& x) { return x[1]; };
inline constexpr auto effort = [](const auto&, const auto&, const auto& u) {
  return 0.5 * u[0] * u[0];
};

}  // namespace saltus::testing_support
