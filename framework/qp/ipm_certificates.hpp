// Proofs that a quadratic program has no solution, looked for when the iterates run away.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "saltus/qp/ipm_iterate.hpp"

namespace saltus::qp {

/// Work space of the two checks, and the multipliers that came nearest to a proof that there is no
/// feasible point.
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
        best_y(equalities),
        best_lambda(sides) {}
  AlignedArray zero_v, zero_y, zero_lambda, lambda, cost_gradient, gradient, direction;
  AlignedArray equality, side;
  AlignedArray best_y, best_lambda;
  double best_radius = 0.0;  ///< within this multiple of the iterate's size they leave no point
};

/// No point within this multiple of the iterate's size satisfies the rows: taken as infeasible.
inline constexpr double certified_radius = 1e5;
/// The same once every attempt to find an optimum has broken down.
inline constexpr double certified_radius_at_end = 1e3;

/// Whether these multipliers may pass is_infeasible() at all: what the residuals of the iterate,
/// with slacks s, tell of lambda'beta - y'e seen from there. As a rule it is far below zero.
template <class System>
bool may_prove(System& system, const Residuals& r, const AlignedArray& s, const Iterate& of) {
  constexpr double doubt = 1e-3;  // residuals may be those that steps let expect
  Lanes value{}, size{};
  const auto add = [&](const Lanes& term) {
    value += term;
    size += magnitude(term);
  };
  // The last vector of hard sides is whole: soft ones begin a vector of their own.
  for (int i = 0; i < system.first_soft(); i += lanes)
    add(-larger(load(&of.lambda[i]), Lanes{}) * load(system.active() + i) *
        (load(&r.side[i]) + load(&s[i])));
  for (int i = 0; i < system.equalities(); i += lanes) add(load(&of.y[i]) * load(&r.equality[i]));
  return !(sum(value) <= -doubt * sum(size));
}

/// Farkas: multipliers lambda >= 0 and y with E'y - G'lambda = 0 and lambda'beta - y'e > 0. What
/// is left of the first is weighed against the second over a ball of certified_radius about the
/// iterate v. Soft sides can be missed, so they prove nothing. Negative multipliers are left out.
template <class System>
bool is_infeasible(System& system, const AlignedArray& v, const AlignedArray& y,
                   const AlignedArray& lambda, CertificateSpace& w) {
  for (int i = 0; i < system.sides(); ++i)
    w.lambda[i] = i < system.first_soft() ? std::fmax(lambda[i], 0.0) * system.active()[i] : 0.0;
  system.evaluate(v.data(), w.zero_y.data(), w.zero_lambda.data(), w.cost_gradient.data(),
                  w.equality.data(), w.side.data());
  system.evaluate(v.data(), y.data(), w.lambda.data(), w.gradient.data(), w.equality.data(),
                  w.side.data());
  // Seen from v: lambda'(beta - G v) + y'(E v - e) > (E'y - G'lambda)'d for all d of the ball.
  double value = 0.0, rest = 0.0, size = 1.0, multipliers = 0.0;
  for (int i = 0; i < system.first_soft(); ++i) {
    value += w.lambda[i] * (system.beta()[i] - w.side[i]);
    multipliers += w.lambda[i];
  }
  for (int i = 0; i < system.equalities(); ++i) {
    value += y[i] * w.equality[i];
    multipliers += std::fabs(y[i]);
  }
  for (int i = 0; i < system.variables(); ++i) {
    rest += std::fabs(w.gradient[i] - w.cost_gradient[i]);
    size = std::fmax(size, std::fabs(v[i]));
  }
  // Where the rows hold up to rounding there is nothing to prove.
  constexpr double held = 1e-9;
  if (!(value > held * multipliers)) return false;
  const double radius = value / (size * std::fmax(rest, std::numeric_limits<double>::min()));
  if (radius > w.best_radius) {
    w.best_radius = radius;
    std::copy_n(y.data(), system.equalities(), w.best_y.data());
    std::copy_n(w.lambda.data(), system.sides(), w.best_lambda.data());
  }
  return radius > certified_radius;
}

/// Whether d = v / |v| is a direction with H d = 0, E d = 0, G d >= 0 (hard sides) and g'd < 0,
/// each within a millionth. Only asked where |v| has run away.
template <class System>
bool is_unbounded(System& system, const AlignedArray& v, CertificateSpace& w) {
  constexpr double millionth = 1e-6, far = 1e6;
  double size = 0.0;
  for (int i = 0; i < system.variables(); ++i) size = std::fmax(size, std::fabs(v[i]));
  if (!(size >= far)) return false;
  for (int i = 0; i < system.variables(); ++i) w.direction[i] = v[i] / size;
  system.evaluate(w.zero_v.data(), w.zero_y.data(), w.zero_lambda.data(), w.cost_gradient.data(),
                  w.equality.data(), w.side.data());
  system.apply(w.direction.data(), w.zero_y.data(), w.zero_lambda.data(), w.gradient.data(),
               w.equality.data(), w.side.data());
  double descent = 0.0, scale = 0.0, curvature = 0.0;
  for (int i = 0; i < system.variables(); ++i) {
    descent += w.cost_gradient[i] * w.direction[i];
    scale = std::fmax(scale, std::fabs(w.cost_gradient[i]));
    curvature = std::fmax(curvature, std::fabs(w.gradient[i]));
  }
  if (!(descent < -millionth * scale) || !(curvature <= millionth * scale)) return false;
  for (int i = 0; i < system.equalities(); ++i)
    if (!(std::fabs(w.equality[i]) <= millionth)) return false;
  for (int i = 0; i < system.first_soft(); ++i)
    if (!(w.side[i] * system.active()[i] >= -millionth)) return false;
  return true;
}

}  // namespace saltus::qp
