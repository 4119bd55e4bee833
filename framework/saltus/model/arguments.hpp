// Where time, state, input and parameters stand in the argument z of a model function.
#pragma once

namespace saltus {

/// z = (t | x | u | p) with 1 + nx + nu + np entries.
struct Arguments {
  int nx = 0;  ///< states
  int nu = 0;  ///< inputs
  int np = 0;  ///< parameters

  /// Place of the time.
  constexpr int t() const { return 0; }
  /// Place of state i.
  constexpr int x(int i = 0) const { return 1 + i; }
  /// Place of input i.
  constexpr int u(int i = 0) const { return 1 + nx + i; }
  /// Place of parameter i.
  constexpr int p(int i = 0) const { return 1 + nx + nu + i; }
  /// How many numbers in all.
  constexpr int size() const { return 1 + nx + nu + np; }

  friend bool operator==(const Arguments&, const Arguments&) = default;
};

}  // namespace saltus
