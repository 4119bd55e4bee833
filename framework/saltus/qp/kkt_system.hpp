// Interface between the interior-point method and the linear algebra of a problem structure.
#pragma once

#include <concepts>

namespace saltus::qp {

/// A quadratic program in flat arrays of double. The order of the entries and the padding are up to
/// the implementation:
///
///     min 1/2 v'Hv + g'v   subject to   E v = e   and   G v >= beta,
///
/// There is one "side" per finite lower or upper bound of a row; upper sides enter with reversed
/// sign. Sides from first_soft() on are soft: beta may be violated by t >= 0 at the cost l1 t +
/// l2/2 t^2. Padding lanes have active() = 0, beta = 0 and zero rows of G; padding entries of v and
/// y stay zero. Arrays may be padded to `lanes` doubles and are 64-byte aligned.
template <class T>
concept KktSystem = requires(T system, const double* in, double* out) {
  { system.variables() } -> std::convertible_to<int>;   // entries of v, padding included
  { system.equalities() } -> std::convertible_to<int>;  // entries of y
  { system.sides() } -> std::convertible_to<int>;
  { system.first_soft() } -> std::convertible_to<int>;
  { system.active() } -> std::convertible_to<const double*>;  // 1 or 0 per side
  { system.beta() } -> std::convertible_to<const double*>;
  { system.l1() } -> std::convertible_to<const double*>;  // per side, read from first_soft() on
  { system.l2() } -> std::convertible_to<const double*>;
  // Computes H v + g + E'y - G'lambda, E v - e, and G v at (v, y, lambda).
  system.evaluate(in, in, in, out, out, out);
  // The same without g and e: H v + E'y - G'lambda, E v, G v.
  system.apply(in, in, in, out, out, out);
  // Returns 1/2 v'Hv + g'v.
  { system.cost(in) } -> std::convertible_to<double>;
  // States whether H is convex where E v = e. If not, factor() and solve() add shift I to H; no
  // other function does.
  system.expect_convex(bool());
  system.set_shift(double());
  // Prepares solve() for the weights of the sides. Returns false if the factorisation broke down.
  // If convexity is not expected, also returns false if H + shift I + G'WG is not convex where E v
  // = 0.
  { system.factor(in) } -> std::convertible_to<bool>;
  // Solves (H + shift I + G'WG) dv + E'dy = -rv, E dv = -ry. Arguments: rv, ry, dv, dy.
  system.solve(in, in, out, out);
  // Computes out = G in, and out += G' in.
  system.multiply(in, out);
  system.add_transposed(in, out);
  // Computes the Euclidean norm of the row of G of every side.
  system.row_sizes(out);
};

}  // namespace saltus::qp
