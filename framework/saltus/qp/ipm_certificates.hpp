// Certificates that a quadratic program has no solution, checked when the iterates diverge.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "saltus/qp/ipm_iterate.hpp"

namespace saltus::qp {

/// Work space of the two checks, and the multipliers that came closest to proving infeasibility.
/// `lambda` holds the multipliers of the last check.
struct CertificateSpace {
  CertificateSpace(int variables, int equalities, int sides)
      : zero_v(variables),
        zero_y(equalities),
        zero_lambda(sides),
        lambda(sides),
        cost_gradient(variables),
        gradient(variables),
        direction(variables),
        equality(equalities),
        side(sides),
        row_size(sides),
        best_y(equalities),
        best_lambda(sides) {}
  AlignedArray zero_v, zero_y, zero_lambda, lambda, cost_gradient, gradient, direction;
  AlignedArray equality, side, row_size;
  AlignedArray best_y, best_lambda;
  double best_multiple = 0.0;  ///< radius of the proof, as a multiple of the expected size of v
};

/// The program counts as infeasible if no point within this radius around the iterate satisfies the
/// rows. The radius must be at least the first value, and at least the second one times the size
/// that v has or that a single row requires.
inline constexpr double certified_radius = 1e8, certified_multiple = 1e5;
/// Replaces certified_multiple after every attempt to find an optimum has broken down. The size of
/// v then includes the size of the sides.
inline constexpr double certified_multiple_at_end = 1e3;

/// Cheap test whether these multipliers can pass is_infeasible(). It estimates lambda'beta - y'e
/// from the residuals of the iterate with slacks s. The estimate is usually far below zero.
template <class System>
bool could_be_certificate(System& system, const Residuals& r, const AlignedArray& s,
                          const Iterate& of) {
  constexpr double doubt = 1e-3;  // the residuals may be extrapolated instead of evaluated
  Lanes value{}, size{};
  const auto add = [&](const Lanes& term) {
    value += term;
    size += magnitude(term);
  };
  // The last vector contains hard sides only: soft sides start at a new vector.
  for (int i = 0; i < system.first_soft(); i += lanes)
    add(-larger(load(&of.lambda[i]), Lanes{}) * load(system.active() + i) *
        (load(&r.side[i]) + load(&s[i])));
  for (int i = 0; i < system.equalities(); i += lanes) add(load(&of.y[i]) * load(&r.equality[i]));
  return !(sum(value) <= -doubt * sum(size));
}

/// Farkas certificate: multipliers lambda >= 0 and y with E'y - G'lambda = 0 and lambda'beta - y'e
/// > 0. The remainder of the first equation is compared with the second over a ball around the
/// iterate v. Soft sides can be violated and prove nothing. Negative multipliers are set to zero.
template <class System>
bool is_infeasible(System& system, const AlignedArray& v, const AlignedArray& y,
                   const AlignedArray& lambda, CertificateSpace& w) {
  for (int i = 0; i < system.sides(); ++i)
    w.lambda[i] = i < system.first_soft() ? std::fmax(lambda[i], 0.0) * system.active()[i] : 0.0;
  // H v + g is left out: small differences would be lost in it.
  system.apply(w.zero_v.data(), y.data(), w.lambda.data(), w.gradient.data(), w.equality.data(),
               w.side.data());
  system.evaluate(v.data(), w.zero_y.data(), w.zero_lambda.data(), w.cost_gradient.data(),
                  w.equality.data(), w.side.data());
  system.row_sizes(w.row_size.data());
  // Relative to v: lambda'(beta - G v) + y'(E v - e) > (E'y - G'lambda)'d for all d in the ball.
  double value = 0.0, rest = 0.0, size = 1.0, multipliers = 0.0, sides = 0.0;
  for (int i = 0; i < system.first_soft(); ++i) {
    const double missing = system.beta()[i] - w.side[i];
    value += w.lambda[i] * missing;
    multipliers += w.lambda[i];
    if (system.active()[i] == 0.0 || !(w.row_size[i] > 0.0)) continue;
    size = std::fmax(size, missing / w.row_size[i]);
    sides = std::fmax(sides, std::fabs(system.beta()[i]) / w.row_size[i]);
  }
  for (int i = 0; i < system.equalities(); ++i) {
    value += y[i] * w.equality[i];
    multipliers += std::fabs(y[i]);
    size = std::fmax(size, std::fabs(w.equality[i]));
  }
  for (int i = 0; i < system.variables(); ++i) {
    rest += std::fabs(w.gradient[i]);
    size = std::fmax(size, std::fabs(v[i]));
  }
  // Rows that hold up to rounding cannot prove infeasibility.
  constexpr double held = 1e-9;
  if (!(value > held * size * multipliers)) return false;
  // If the sides are large, v may be large as well.
  const double expected = std::fmax(size, sides);
  const double multiple = value / (expected * std::fmax(rest, std::numeric_limits<double>::min()));
  if (multiple > w.best_multiple) {
    w.best_multiple = multiple;
    std::copy_n(y.data(), system.equalities(), w.best_y.data());
    std::copy_n(w.lambda.data(), system.sides(), w.best_lambda.data());
  }
  const double radius = std::fmax(certified_radius, certified_multiple * size);
  return value > radius * rest;
}

/// True if d = v / |v| satisfies E d = 0, G d >= 0 (hard sides) and either H d = 0 and g'd < 0, or
/// d'H d < 0. The tolerance lets the cost fall at least until v has size 1 / nearly_zero.
/// Checked only if |v| has diverged.
template <class System>
bool is_unbounded(System& system, const AlignedArray& v, CertificateSpace& w) {
  constexpr double nearly_zero = 1e-9, downhill = 1e-6, far = 1e6, bent = 1e-3;
  double size = 0.0;
  for (int i = 0; i < system.variables(); ++i) size = std::fmax(size, std::fabs(v[i]));
  if (!(size >= far)) return false;
  for (int i = 0; i < system.variables(); ++i) w.direction[i] = v[i] / size;
  system.evaluate(w.zero_v.data(), w.zero_y.data(), w.zero_lambda.data(), w.cost_gradient.data(),
                  w.equality.data(), w.side.data());
  system.apply(w.direction.data(), w.zero_y.data(), w.zero_lambda.data(), w.gradient.data(),
               w.equality.data(), w.side.data());
  double descent = 0.0, scale = 0.0, bend = 0.0, bends = 0.0;
  for (int i = 0; i < system.variables(); ++i) {
    descent += w.cost_gradient[i] * w.direction[i];
    scale = std::fmax(scale, std::fabs(w.cost_gradient[i]));
    bend += w.gradient[i] * w.direction[i];
    bends += std::fabs(w.gradient[i] * w.direction[i]);
  }
  const bool is_straight = descent < -downhill * scale && bend <= -nearly_zero * descent;
  if (!is_straight && !(bend < -bent * bends)) return false;
  for (int i = 0; i < system.equalities(); ++i)
    if (!(std::fabs(w.equality[i]) <= nearly_zero)) return false;
  for (int i = 0; i < system.first_soft(); ++i)
    if (!(w.side[i] * system.active()[i] >= -nearly_zero)) return false;
  return true;
}

}  // namespace saltus::qp
