// Elementary functions for double and dual numbers. tracer.hpp has those for tracers.
//
// Inside a formula, call them unqualified (sin(x[0])) or as saltus::sin. Where a derivative does
// not exist or is infinite, these functions return a finite one. Otherwise one NaN or infinity at a
// start, at rest or at a contact point would make the whole solve fail:
//   abs at 0           derivative 0
//   min, max of equals the mean of both derivatives, so that max(x, -x) agrees with abs(x)
//   sqrt, norm, hypot at 0; asin, acos at +-1; x^c at 0 with c < 1
//                      derivative 0 instead of infinity, so that norm() is flat at rest
//   atan2(0, 0)        value 0, derivatives 0; also within 1e-150 of the origin
//   x^y with x <= 0    the derivative with respect to y is 0 (it is undefined for x < 0)
// Outside the domain of a function, the value is NaN as in <cmath>.
#pragma once

#include <cmath>
#include <concepts>

#include "saltus/autodiff/dual.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

using std::acos;
using std::asin;
using std::atan;
using std::atan2;
using std::cos;
using std::cosh;
using std::exp;
using std::hypot;
using std::log;
using std::pow;
using std::sin;
using std::sinh;
using std::sqrt;
using std::tan;
using std::tanh;

/// Absolute value of a double.
inline double abs(double x) { return std::abs(x); }  // never the integer overload of <cstdlib>
/// The smaller one, or a if they are equal.
inline double min(double a, double b) { return b < a ? b : a; }
/// The larger one, or a if they are equal.
inline double max(double a, double b) { return a < b ? b : a; }

namespace detail {
/// numerator / x, or 0 if x is 0. Replaces infinite derivatives.
template <class T>
T divide_or_zero(const T& numerator, const T& x) {
  return primal(x) == 0.0 ? T(0.0) : T(numerator / x);
}
}  // namespace detail

template <class T, int N>
Dual<T, N> sin(const Dual<T, N>& x) {
  return chain(x, T(sin(x.value)), T(cos(x.value)));
}
template <class T, int N>
Dual<T, N> cos(const Dual<T, N>& x) {
  return chain(x, T(cos(x.value)), T(-sin(x.value)));
}
template <class T, int N>
Dual<T, N> tan(const Dual<T, N>& x) {
  const T f = tan(x.value);
  return chain(x, f, T(1.0 + f * f));
}
template <class T, int N>
Dual<T, N> asin(const Dual<T, N>& x) {
  const T root = sqrt(T(1.0 - x.value * x.value));
  return chain(x, T(asin(x.value)), detail::divide_or_zero(T(1.0), root));
}
template <class T, int N>
Dual<T, N> acos(const Dual<T, N>& x) {
  const T root = sqrt(T(1.0 - x.value * x.value));
  return chain(x, T(acos(x.value)), detail::divide_or_zero(T(-1.0), root));
}
template <class T, int N>
Dual<T, N> atan(const Dual<T, N>& x) {
  return chain(x, T(atan(x.value)), T(1.0 / (1.0 + x.value * x.value)));
}
template <class T, int N>
Dual<T, N> sinh(const Dual<T, N>& x) {
  return chain(x, T(sinh(x.value)), T(cosh(x.value)));
}
template <class T, int N>
Dual<T, N> cosh(const Dual<T, N>& x) {
  return chain(x, T(cosh(x.value)), T(sinh(x.value)));
}
template <class T, int N>
Dual<T, N> tanh(const Dual<T, N>& x) {
  const T f = tanh(x.value);
  return chain(x, f, T(1.0 - f * f));
}
template <class T, int N>
Dual<T, N> exp(const Dual<T, N>& x) {
  const T f = exp(x.value);
  return chain(x, f, f);
}
template <class T, int N>
Dual<T, N> log(const Dual<T, N>& x) {
  return chain(x, T(log(x.value)), T(1.0 / x.value));
}
template <class T, int N>
Dual<T, N> sqrt(const Dual<T, N>& x) {
  const T f = sqrt(x.value);
  return chain(x, f, detail::divide_or_zero(T(0.5), f));
}
template <class T, int N>
Dual<T, N> abs(const Dual<T, N>& x) {
  const double sign = primal(x) > 0.0 ? 1.0 : (primal(x) < 0.0 ? -1.0 : 0.0);
  return {abs(x.value), sign * x.tangent};
}

template <class T, int N>
Dual<T, N> min(const Dual<T, N>& a, const Dual<T, N>& b) {
  if (primal(a) < primal(b)) return a;
  if (primal(b) < primal(a)) return b;
  return 0.5 * (a + b);
}
template <class T, int N>
Dual<T, N> max(const Dual<T, N>& a, const Dual<T, N>& b) {
  if (primal(a) > primal(b)) return a;
  if (primal(b) > primal(a)) return b;
  return 0.5 * (a + b);
}
template <class T, int N>
Dual<T, N> atan2(const Dual<T, N>& y, const Dual<T, N>& x) {
  // Divides twice: the square of a length overflows or underflows long before the length does.
  // Below 1e-150, second derivatives would not be finite.
  const T length = hypot(x.value, y.value);
  const auto over_square = [&](const T& v) {
    return primal(length) < 1e-150 ? T(0.0) : T(T(v / length) / length);
  };
  return chain(y, x, T(atan2(y.value, x.value)), over_square(x.value), over_square(T(-y.value)));
}
template <class T, int N>
Dual<T, N> hypot(const Dual<T, N>& a, const Dual<T, N>& b) {
  const T f = hypot(a.value, b.value);
  return chain(a, b, f, detail::divide_or_zero(a.value, f), detail::divide_or_zero(b.value, f));
}

template <class T, int N>
Dual<T, N> pow(const Dual<T, N>& x, double exponent) {
  const T f = pow(x.value, exponent);
  if (exponent == 0.0 || (primal(x) == 0.0 && exponent < 1.0)) return chain(x, f, T(0.0));
  return chain(x, f, T(exponent * pow(x.value, exponent - 1.0)));
}
template <class T, int N>
Dual<T, N> pow(const Dual<T, N>& x, const Dual<T, N>& exponent) {
  // x is not positive: the exponent counts as a constant, also in mixed derivatives.
  if (!(primal(x) > 0.0)) return pow(x, primal(exponent));
  const T f = pow(x.value, exponent.value);
  return chain(x, exponent, f, T(exponent.value * pow(x.value, T(exponent.value - 1.0))),
               T(f * log(x.value)));
}

// Overloads for one constant argument. ActiveScalar includes the tracer.
template <ActiveScalar S>
S min(const S& a, double b) {
  return min(a, S(b));
}
template <ActiveScalar S>
S min(double a, const S& b) {
  return min(S(a), b);
}
template <ActiveScalar S>
S max(const S& a, double b) {
  return max(a, S(b));
}
template <ActiveScalar S>
S max(double a, const S& b) {
  return max(S(a), b);
}
template <ActiveScalar S>
S atan2(const S& y, double x) {
  return atan2(y, S(x));
}
template <ActiveScalar S>
S atan2(double y, const S& x) {
  return atan2(S(y), x);
}
template <ActiveScalar S>
S hypot(const S& a, double b) {
  return hypot(a, S(b));
}
template <ActiveScalar S>
S hypot(double a, const S& b) {
  return hypot(S(a), b);
}
template <ActiveScalar S>
S pow(double base, const S& exponent) {
  return pow(S(base), exponent);
}
template <ActiveScalar S, std::integral Integer>
S pow(const S& x, Integer exponent) {
  return pow(x, static_cast<double>(exponent));
}

/// x^2.
template <Scalar S>
S square(const S& x) {
  return x * x;
}
/// x^3.
template <Scalar S>
S cube(const S& x) {
  return x * x * x;
}

/// Euclidean length of a vector, with derivative zero at zero. Eigen's v.norm() gives the same.
/// v.normalized() branches on the length and does not compile.
template <class Derived>
typename Derived::Scalar norm(const Eigen::MatrixBase<Derived>& v) {
  using S = typename Derived::Scalar;
  const S sum_of_squares = v.squaredNorm();
  return sqrt(sum_of_squares);
}

// Switches in a formula: exact (select) or smooth over a width (smooth_*).

/// `a` if condition >= 0, else `b` (also if the condition is NaN). The derivative is that of the
/// chosen branch. The sparsity includes both branches and the condition.
template <Scalar C, Scalar A, Scalar B>
CommonScalar<C, A, B> select(const C& condition, const A& a, const B& b) {
  using S = CommonScalar<C, A, B>;
  if constexpr (requires { S::select(S(condition), S(a), S(b)); }) {
    return S::select(S(condition), S(a), S(b));  // the tracer has no values
  } else {
    return primal(condition) >= 0.0 ? S(a) : S(b);
  }
}

/// Rises from 0 to 1 around x = 0: (1 + tanh(x / width)) / 2. Within 1e-4 of 0 or 1 for |x| >= 4.6
/// widths. The width has the unit of x and must be positive.
template <Scalar S>
CommonScalar<S> smooth_step(const S& x, double width) {
  return 0.5 * (1.0 + tanh(x / width));
}

/// sqrt(x^2 + width^2). Exceeds |x| by at most `width`, reached at x = 0.
template <Scalar S>
CommonScalar<S> smooth_abs(const S& x, double width) {
  return sqrt(x * x + width * width);
}

/// Exceeds max(a, b) by at most width / 2, reached at a = b.
template <Scalar A, Scalar B>
CommonScalar<A, B> smooth_max(const A& a, const B& b, double width) {
  using S = CommonScalar<A, B>;
  return 0.5 * (a + b + smooth_abs(S(a - b), width));
}

/// Below min(a, b) by at most width / 2, reached at a = b.
template <Scalar A, Scalar B>
CommonScalar<A, B> smooth_min(const A& a, const B& b, double width) {
  using S = CommonScalar<A, B>;
  return 0.5 * (a + b - smooth_abs(S(a - b), width));
}

}  // namespace saltus
