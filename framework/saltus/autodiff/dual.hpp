// Dual numbers: a formula, written once, also computes its derivatives.
//
// The principle in five lines. Let e be a symbol with e e = 0. A number a + a' e computes like any
// other:
//   (a + a' e) + (b + b' e) = (a + b) + (a' + b') e
//   (a + a' e) (b + b' e)   =  a b    + (a' b + a b') e          the product rule
//   f(a + a' e)             =  f(a)   +  f'(a) a' e              the chain rule, by Taylor
// So the factor of e is a derivative, exact to rounding: seed x with 1 e, evaluate, read the
// factor.
//
// Here one number carries N directions e_1 .. e_N. The value is computed once, and vector
// instructions update the N factors, the tangent. A dual whose value and factors are duals carries
// second derivatives. In Dual<Dual<double, W>, 1>, seed the outer direction with e_j and the inner
// ones with e_1 .. e_W. The tangent of the tangent of y is then (d2y/dx_j dx_1, ..., d2y/dx_j
// dx_W).
//
// Duals cannot be compared (scalar.hpp) and do not convert to double: both would silently lose
// derivatives. Constants convert to duals with a zero tangent.
#pragma once

#include <concepts>

#include "saltus/autodiff/eigen_scalar.hpp"
#include "saltus/autodiff/pack.hpp"
#include "saltus/autodiff/scalar.hpp"

namespace saltus {

/// The factors of e_1 .. e_n if they are duals. If they are doubles, Chunk (pack.hpp) stores them.
template <class T, int n>
struct TangentOf {
  T factors[n];  ///< one derivative per lane

  /// The tangent of a constant.
  static TangentOf zero() {
    TangentOf c;
    for (T& factor : c.factors) factor = T(0.0);
    return c;
  }
  /// Derivative of lane i.
  const T& operator[](int i) const { return factors[i]; }
  /// Sets the derivative of lane i.
  void set(int i, const T& value) { factors[i] = value; }

  TangentOf& operator+=(const TangentOf& b) { return *this = *this + b; }
  TangentOf& operator-=(const TangentOf& b) { return *this = *this - b; }
  [[gnu::always_inline]] friend TangentOf operator+(const TangentOf& a, const TangentOf& b) {
    TangentOf c;
    for (int i = 0; i < n; ++i) c.factors[i] = a.factors[i] + b.factors[i];
    return c;
  }
  [[gnu::always_inline]] friend TangentOf operator-(const TangentOf& a, const TangentOf& b) {
    TangentOf c;
    for (int i = 0; i < n; ++i) c.factors[i] = a.factors[i] - b.factors[i];
    return c;
  }
  [[gnu::always_inline]] friend TangentOf operator-(const TangentOf& a) {
    TangentOf c;
    for (int i = 0; i < n; ++i) c.factors[i] = -a.factors[i];
    return c;
  }
  template <class Factor>  // double or T
  [[gnu::always_inline]] friend TangentOf operator*(const Factor& s, const TangentOf& a) {
    TangentOf c;
    for (int i = 0; i < n; ++i) c.factors[i] = s * a.factors[i];
    return c;
  }
  [[gnu::always_inline]] friend TangentOf combine(const T& s, const TangentOf& a, const T& r,
                                                  const TangentOf& b) {
    TangentOf c;
    for (int i = 0; i < n; ++i) c.factors[i] = s * a.factors[i] + r * b.factors[i];
    return c;
  }
};

namespace detail {
template <class T, int n>
struct TangentType {
  using Type = TangentOf<T, n>;
};
template <int n>
struct TangentType<double, n> {
  using Type = Chunk<n>;
};
}  // namespace detail

// Always inlined: gcc considers nested operators too large, and calls pass everything through
// memory. That costs a quarter of the time of a Hessian.

inline namespace SALTUS_LANES_ABI {  // pack.hpp

/// value + sum_i tangent[i] e_i. T is double or a Dual. Like a double, it is not initialised by its
/// default constructor.
template <class T, int N>
struct Dual {
  using Tangent = typename detail::TangentType<T, N>::Type;

  T value;                                ///< the value
  [[no_unique_address]] Tangent tangent;  ///< the derivatives along all lanes

  Dual() = default;
  /// A constant, with a zero tangent.
  Dual(double constant) : value(constant), tangent(Tangent::zero()) {}  // NOLINT: implicit
  /// A value with its derivatives.
  Dual(const T& v, const Tangent& d) : value(v), tangent(d) {}

  Dual& operator+=(const Dual& b) {
    value += b.value;
    tangent += b.tangent;
    return *this;
  }
  Dual& operator-=(const Dual& b) {
    value -= b.value;
    tangent -= b.tangent;
    return *this;
  }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }
  Dual& operator+=(double b) {
    value += b;
    return *this;
  }
  Dual& operator-=(double b) {
    value -= b;
    return *this;
  }
  Dual& operator*=(double b) { return *this = *this * b; }
  Dual& operator/=(double b) { return *this = *this / b; }

  [[gnu::always_inline]] friend Dual operator+(const Dual& a) { return a; }
  [[gnu::always_inline]] friend Dual operator-(const Dual& a) { return {-a.value, -a.tangent}; }

  [[gnu::always_inline]] friend Dual operator+(const Dual& a, const Dual& b) {
    return {a.value + b.value, a.tangent + b.tangent};
  }
  [[gnu::always_inline]] friend Dual operator+(const Dual& a, double b) {
    return {a.value + b, a.tangent};
  }
  [[gnu::always_inline]] friend Dual operator+(double a, const Dual& b) {
    return {a + b.value, b.tangent};
  }

  [[gnu::always_inline]] friend Dual operator-(const Dual& a, const Dual& b) {
    return {a.value - b.value, a.tangent - b.tangent};
  }
  [[gnu::always_inline]] friend Dual operator-(const Dual& a, double b) {
    return {a.value - b, a.tangent};
  }
  [[gnu::always_inline]] friend Dual operator-(double a, const Dual& b) {
    return {a - b.value, -b.tangent};
  }

  [[gnu::always_inline]] friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, combine(b.value, a.tangent, a.value, b.tangent)};
  }
  [[gnu::always_inline]] friend Dual operator*(const Dual& a, double b) {
    return {a.value * b, b * a.tangent};
  }
  [[gnu::always_inline]] friend Dual operator*(double a, const Dual& b) {
    return {a * b.value, a * b.tangent};
  }

  [[gnu::always_inline]] friend Dual operator/(const Dual& a, const Dual& b) {
    const T quotient = a.value / b.value;
    const T inverse = 1.0 / b.value;
    return {quotient, combine(inverse, a.tangent, -(quotient * inverse), b.tangent)};
  }
  [[gnu::always_inline]] friend Dual operator/(const Dual& a, double b) {
    return {a.value / b, (1.0 / b) * a.tangent};
  }
  [[gnu::always_inline]] friend Dual operator/(double a, const Dual& b) {
    const T quotient = a / b.value;
    return {quotient, -(quotient / b.value) * b.tangent};
  }

  // Declared for a clear compiler error (scalar.hpp).
  template <class Index>
  const Dual& operator[](const Index&) const {
    detail::index_of_a_scalar<(sizeof(Index) > 0)>();
    return *this;
  }
  template <class Index>
  const Dual& operator()(const Index&) const {
    detail::index_of_a_scalar<(sizeof(Index) > 0)>();
    return *this;
  }
  template <std::same_as<double> Number>
  explicit operator Number() const {
    return detail::number_without_derivatives<(sizeof(Number) > 0)>();
  }
  /// Only functions of <cmath> select this conversion, because they have an overload for long
  /// double. As a template it converts to no other type, so `condition ? x[0] : 1.0` stays
  /// unambiguous.
  template <std::same_as<long double> Number>
  operator Number() const {  // NOLINT: implicit
    return detail::argument_of_standard_function<(sizeof(Number) > 0)>();
  }
};

}  // namespace SALTUS_LANES_ABI

template <class T, int N>
inline constexpr bool is_active_scalar<Dual<T, N>> = true;  ///< a dual number carries derivatives

/// The number without derivatives.
inline double primal(double x) { return x; }
/// The innermost value without derivatives.
template <class T, int N>
double primal(const Dual<T, N>& x) {
  return primal(x.value);
}

/// f(x) by the chain rule, given f and df/dx.
template <class T, int N>
Dual<T, N> chain(const Dual<T, N>& x, const T& f, const T& df) {
  return {f, df * x.tangent};
}
/// f(a, b) by the chain rule, given f and both partial derivatives.
template <class T, int N>
Dual<T, N> chain(const Dual<T, N>& a, const Dual<T, N>& b, const T& f, const T& df_da,
                 const T& df_db) {
  return {f, combine(df_da, a.tangent, df_db, b.tangent)};
}

}  // namespace saltus
