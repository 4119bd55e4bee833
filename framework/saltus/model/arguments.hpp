// Layout of the argument z of a model function: time, state, input and parameters.
#pragma once

namespace saltus {

/// z = (t | x | u | p) with 1 + nx + nu + np entries.
struct Arguments {
  int nx = 0;  ///< states
  int nu = 0;  ///< inputs
  int np = 0;  ///< parameters

  /// Index of the time.
  constexpr int t() const { return 0; }
  /// Index of state i.
  constexpr int x(int i = 0) const { return 1 + i; }
  /// Index of input i.
  constexpr int u(int i = 0) const { return 1 + nx + i; }
  /// Index of parameter i.
  constexpr int p(int i = 0) const { return 1 + nx + nu + i; }
  /// Total number of entries.
  constexpr int size() const { return 1 + nx + nu + np; }

  friend bool operator==(const Arguments&, const Arguments&) = default;
};

}  // namespace saltus
