// Formulas shared by several classes.
#pragma once

#include "tests/corpus/twin.hpp"

namespace saltus::corpus {

/// x' = u, with n states and n inputs
struct Integrators {
  template <class S, class X, class U>
  U operator()(const S&, const X&, const U& u) const {
    return u;
  }
};
/// x' = v, v' = a u
struct DoubleIntegrator {
  double gain = 1.0;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], S(gain * u[0])};
  }
};
/// angle' = rate, rate' = -stiffness sin(angle) - damping rate + u
struct Pendulum {
  double stiffness = 1.0, damping = 0.1;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    using std::sin;
    return {x[1], S(u[0] - stiffness * sin(x[0]) - damping * x[1])};
  }
};
/// weight / 2 |u|^2
struct Effort {
  double weight = 1.0;
  template <class S, class X, class U>
  S operator()(const S&, const X&, const U& u) const {
    S sum = 0.5 * weight * u[0] * u[0];
    for (int i = 1; i < static_cast<int>(u.size()); ++i) sum = sum + 0.5 * weight * u[i] * u[i];
    return sum;
  }
};
/// The state itself.
struct WholeState {
  template <class S, class X>
  X operator()(const S&, const X& x) const {
    return x;
  }
};
/// Entry i of the state.
struct Entry {
  int i = 0;
  template <class S, class X>
  S operator()(const S&, const X& x) const {
    return x[i];
  }
};
/// The time.
struct Time {
  template <class S, class X>
  S operator()(const S& t, const X&) const {
    return t;
  }
};

}  // namespace saltus::corpus
