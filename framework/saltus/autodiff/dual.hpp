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
// Duals cannot be compared (see below) and do not convert to double: both would silently lose
// derivatives. Constants convert to duals with a zero tangent.
#pragma once

#include <concepts>
#include <type_traits>

#include "saltus/core/types.hpp"

namespace saltus {

// Concepts for the number types that replace double in a formula, and their compile-time errors.

/// True for number types that carry derivatives or dependencies. Each type specialises it.
template <class S>
inline constexpr bool is_active_scalar = false;

/// A number type that replaces double in a user's formula: a dual number or a tracer.
template <class S>
concept ActiveScalar = is_active_scalar<S>;

/// Any number type of a formula.
template <class S>
concept Scalar = ActiveScalar<S> || std::is_arithmetic_v<S>;

/// Two scalars of which at least one is active. The operators and functions of Saltus apply to
/// these.
template <class A, class B>
concept ActivePair = (ActiveScalar<A> && (std::same_as<A, B> || std::is_arithmetic_v<B>)) ||
                     (ActiveScalar<B> && std::is_arithmetic_v<A>);

namespace detail {
template <class... Ts>
struct CommonScalar {
  using Type = double;
};
template <class T, class... Ts>
struct CommonScalar<T, Ts...> {
  using Rest = typename CommonScalar<Ts...>::Type;
  using Type = std::conditional_t<ActiveScalar<T>, T, Rest>;
};

// Each function is instantiated once for all scalars, so that the compiler reports one error
// instead of one per scalar.
template <bool used>
bool advise_branching() {
  static_assert(!used,
                "a formula cannot branch on a state, input or parameter, because its derivatives "
                "and sparsity must hold on both sides: use saltus::select(condition, a, b), min, "
                "max, abs or smooth_step instead, without std::");
  return false;
}
template <bool used>
void advise_scalar_index() {
  static_assert(!used,
                "a scalar has no entries: a formula is called as f(t, x), f(t, x, u) or "
                "f(t, x, u, p), with the time t first, and only x, u and p have entries");
}
template <bool used>
long double advise_standard_function() {
  static_assert(
      !used,
      "use sin(x), not std::sin(x): functions of <cmath> lose derivatives, so call the functions "
      "of saltus without std:: (sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, "
      "tanh, exp, log, sqrt, pow, hypot, abs, min, max)");
  return 0.0L;
}
template <bool used>
double advise_double_conversion() {
  static_assert(
      !used,
      "a number with derivatives does not convert to double: declare variables and results of a "
      "formula with its scalar type, S and Vec<S, n> instead of double and Vec<double, n>");
  return 0.0;
}
}  // namespace detail

/// The active type among Ts, or double if there is none.
template <class... Ts>
using CommonScalar = typename detail::CommonScalar<Ts...>::Type;

/// An active scalar and a number of any arithmetic type, as in 2 * x.
template <class A, class B>
concept ScalarAndNumber = (ActiveScalar<A> && (std::is_arithmetic_v<B> || std::is_enum_v<B>)) ||
                          (ActiveScalar<B> && (std::is_arithmetic_v<A> || std::is_enum_v<A>));

namespace detail {
template <class A>
decltype(auto) operand(const A& a) {
  if constexpr (ActiveScalar<A>) {
    return (a);
  } else {
    return static_cast<double>(a);
  }
}
}  // namespace detail

// Operators for numbers that are not doubles. Each scalar type defines those for doubles itself.
// These match better than built-in operators, which would convert the scalar to long double
// (advise_standard_function()).
template <class A, class B>
  requires ScalarAndNumber<A, B>
CommonScalar<A, B> operator+(const A& a, const B& b) {
  return detail::operand(a) + detail::operand(b);
}
template <class A, class B>
  requires ScalarAndNumber<A, B>
CommonScalar<A, B> operator-(const A& a, const B& b) {
  return detail::operand(a) - detail::operand(b);
}
template <class A, class B>
  requires ScalarAndNumber<A, B>
CommonScalar<A, B> operator*(const A& a, const B& b) {
  return detail::operand(a) * detail::operand(b);
}
template <class A, class B>
  requires ScalarAndNumber<A, B>
CommonScalar<A, B> operator/(const A& a, const B& b) {
  return detail::operand(a) / detail::operand(b);
}

// Comparisons are declared so that the compiler reports the advice above instead of a missing
// operator.
template <class A, class B>
  requires ActivePair<A, B>
bool operator<(const A&, const B&) {
  return detail::advise_branching<ActivePair<A, B>>();
}
template <class A, class B>
  requires ActivePair<A, B>
bool operator>(const A&, const B&) {
  return detail::advise_branching<ActivePair<A, B>>();
}
template <class A, class B>
  requires ActivePair<A, B>
bool operator<=(const A&, const B&) {
  return detail::advise_branching<ActivePair<A, B>>();
}
template <class A, class B>
  requires ActivePair<A, B>
bool operator>=(const A&, const B&) {
  return detail::advise_branching<ActivePair<A, B>>();
}
template <class A, class B>
  requires ActivePair<A, B>
bool operator==(const A&, const B&) {
  return detail::advise_branching<ActivePair<A, B>>();
}
template <class A, class B>
  requires ActivePair<A, B>
bool operator!=(const A&, const B&) {
  return detail::advise_branching<ActivePair<A, B>>();
}

}  // namespace saltus

// Memory layout of the tangent of a dual number: packs of doubles for vector instructions.
//
// The width follows the target: 8 doubles with AVX-512, 4 with AVX, otherwise 2. A pack wider than
// the registers is slow and changes the calling convention. The width is therefore part of the
// names that depend on it (SALTUS_LANES_ABI). A program and an installed library may thus use
// different -march options: each keeps its own instances of the templates.
//
// Packs have the alignment of a double. Eigen aligns the heap to 16 bytes only
// (EIGEN_MAX_ALIGN_BYTES=16). A dynamic matrix of duals with naturally aligned packs would crash.

/// Name of an inline namespace.
#if defined(__AVX512F__)
#define SALTUS_LANES_ABI lanes_8
#elif defined(__AVX__)
#define SALTUS_LANES_ABI lanes_4
#else
#define SALTUS_LANES_ABI lanes_2
#endif

namespace saltus {
inline namespace SALTUS_LANES_ABI {

#if defined(__AVX512F__)
inline constexpr int native_lanes = 8;
#elif defined(__AVX__)
inline constexpr int native_lanes = 4;
#else
inline constexpr int native_lanes = 2;
#endif

/// A vector of `lanes` doubles with element-wise + - * and double * Pack. Each width is a separate
/// specialisation because types that depend on a template parameter lose vector attributes.
template <int lanes>
struct Pack;
template <>
struct Pack<1> {
  using Lanes = double;
};
template <>
struct Pack<2> {
  using Lanes [[gnu::vector_size(16), gnu::aligned(8)]] = double;
};
template <>
struct Pack<4> {
  using Lanes [[gnu::vector_size(32), gnu::aligned(8)]] = double;
};
template <>
struct Pack<8> {
  using Lanes [[gnu::vector_size(64), gnu::aligned(8)]] = double;
};

/// The widest pack of the target that n doubles fill.
constexpr int lanes_for(int n) {
  int lanes = 1;
  while (lanes < n && lanes < native_lanes) lanes *= 2;
  return lanes;
}

/// n doubles stored in whole packs. Surplus lanes are computed and never read.
template <int n>
class Chunk {
 public:
  static constexpr int lanes = lanes_for(n);
  static constexpr int packs = (n + lanes - 1) / lanes;

  static Chunk zero() {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = Lanes{};
    return c;
  }
  /// Loads packs * lanes doubles.
  static Chunk load(const double* values) {
    // Vector types may alias their elements. A memcpy would use smaller pieces than the next read.
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = reinterpret_cast<const Lanes*>(values)[k];
    return c;
  }
  static Chunk unit(int lane) {
    Chunk c = zero();
    c.set(lane, 1.0);
    return c;
  }

  double operator[](int i) const {
    if constexpr (lanes == 1) {
      return packs_[i];
    } else {
      return packs_[i / lanes][i % lanes];
    }
  }
  void set(int i, double value) {
    if constexpr (lanes == 1) {
      packs_[i] = value;
    } else {
      packs_[i / lanes][i % lanes] = value;
    }
  }

  Chunk& operator+=(const Chunk& b) {
    for (int k = 0; k < packs; ++k) packs_[k] += b.packs_[k];
    return *this;
  }
  Chunk& operator-=(const Chunk& b) {
    for (int k = 0; k < packs; ++k) packs_[k] -= b.packs_[k];
    return *this;
  }
  [[gnu::always_inline]] friend Chunk operator+(const Chunk& a, const Chunk& b) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = a.packs_[k] + b.packs_[k];
    return c;
  }
  [[gnu::always_inline]] friend Chunk operator-(const Chunk& a, const Chunk& b) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = a.packs_[k] - b.packs_[k];
    return c;
  }
  [[gnu::always_inline]] friend Chunk operator-(const Chunk& a) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = -a.packs_[k];
    return c;
  }
  [[gnu::always_inline]] friend Chunk operator*(double s, const Chunk& a) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = s * a.packs_[k];
    return c;
  }
  /// s a + r b in one pass, for the product and chain rules of two arguments.
  [[gnu::always_inline]] friend Chunk combine(double s, const Chunk& a, double r, const Chunk& b) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = s * a.packs_[k] + r * b.packs_[k];
    return c;
  }

 private:
  using Lanes = typename Pack<lanes>::Lanes;
  Lanes packs_[packs];
};

/// An empty tangent, for a number without derivatives.
template <>
class Chunk<0> {
 public:
  static Chunk zero() { return {}; }
  Chunk& operator+=(const Chunk&) { return *this; }
  Chunk& operator-=(const Chunk&) { return *this; }
  friend Chunk operator+(const Chunk&, const Chunk&) { return {}; }
  friend Chunk operator-(const Chunk&, const Chunk&) { return {}; }
  friend Chunk operator-(const Chunk&) { return {}; }
  friend Chunk operator*(double, const Chunk&) { return {}; }
  friend Chunk combine(double, const Chunk&, double, const Chunk&) { return {}; }
};

}  // namespace SALTUS_LANES_ABI
}  // namespace saltus

// Lets Eigen vectors and matrices hold active scalars and mix with matrices of doubles.

// types.hpp must precede all other Eigen headers.
// Formulas may contain cross products and inverses. All of <Eigen/Geometry> takes a twentieth of
// the time to compile a first program; include it for rotations.
#include <Eigen/LU>
#if EIGEN_VERSION_AT_LEAST(3, 4, 90)
#include <Eigen/Geometry>
#else
#include <Eigen/src/Geometry/OrthoMethods.h>
#endif

namespace Eigen {

template <saltus::ActiveScalar S>
struct NumTraits<S> : NumTraits<double> {
  using Real = S;
  using NonInteger = S;
  using Nested = S;
  using Literal = double;  // `2.0 * v` multiplies by a double, not by a dual constant
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = !std::is_trivially_default_constructible_v<S>,
    ReadCost = 1,
    AddCost = 1,
    MulCost = 1
  };
};

template <saltus::ActiveScalar S, class Operation>
struct ScalarBinaryOpTraits<S, double, Operation> {
  using ReturnType = S;
};
template <saltus::ActiveScalar S, class Operation>
struct ScalarBinaryOpTraits<double, S, Operation> {
  using ReturnType = S;
};

namespace internal {

// Computes products coefficient by coefficient for every size. For 8 rows or more, Eigen would use
// its numerical kernels, which compare scalars, convert one factor or allocate.
template <class Lhs, class Rhs>
  requires(saltus::ActiveScalar<typename traits<typename remove_all<Lhs>::type>::Scalar> ||
           saltus::ActiveScalar<typename traits<typename remove_all<Rhs>::type>::Scalar>)
struct product_type<Lhs, Rhs> {
  enum {
    rows = int(traits<typename remove_all<Lhs>::type>::RowsAtCompileTime) == 1 ? 1 : int(Small),
    depth = int(traits<typename remove_all<Lhs>::type>::ColsAtCompileTime) == 1 ? 1 : int(Small),
    cols = int(traits<typename remove_all<Rhs>::type>::ColsAtCompileTime) == 1 ? 1 : int(Small),
    ret = product_type_selector<rows, cols, depth>::ret,
    value = ret
  };
};

}  // namespace internal
}  // namespace Eigen

namespace saltus {

/// The factors of e_1 .. e_n if they are duals. If they are doubles, a Chunk stores them.
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

inline namespace SALTUS_LANES_ABI {  // see above

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

  // Declared for a clear compiler error (see above).
  template <class Index>
  const Dual& operator[](const Index&) const {
    detail::advise_scalar_index<(sizeof(Index) > 0)>();
    return *this;
  }
  template <class Index>
  const Dual& operator()(const Index&) const {
    detail::advise_scalar_index<(sizeof(Index) > 0)>();
    return *this;
  }
  template <std::same_as<double> Number>
  explicit operator Number() const {
    return detail::advise_double_conversion<(sizeof(Number) > 0)>();
  }
  /// Only functions of <cmath> select this conversion, because they have an overload for long
  /// double. As a template it converts to no other type, so `condition ? x[0] : 1.0` stays
  /// unambiguous.
  template <std::same_as<long double> Number>
  operator Number() const {  // NOLINT: implicit
    return detail::advise_standard_function<(sizeof(Number) > 0)>();
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
