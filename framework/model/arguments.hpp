// Where time, state, input and parameters stand in the argument z of a model function.
#pragma once

namespace saltus {

/// z = (t | x | u | p) with 1 + nx + nu + np entries.
struct Arguments {
  int nx = 0;
  int nu = 0;
  int np = 0;

  constexpr int t() const { return 0; }
  constexpr int x(int i = 0) const { return 1 + i; }
  constexpr int u(int i = 0) const { return 1 + nx + i; }
  constexpr int p(int i = 0) const { return 1 + nx + nu + i; }
  constexpr int size() const { return 1 + nx + nu + np; }

  friend bool operator==(const Arguments&, const Arguments&) = default;
};

}  // namespace saltus
