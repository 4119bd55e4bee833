// Concepts for the number types that replace double in a formula, and their compile-time errors.
#pragma once

#include <concepts>
#include <type_traits>

namespace saltus {

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
bool branching_on_a_state() {
  static_assert(!used,
                "a formula cannot branch on a state, input or parameter, because its derivatives "
                "and sparsity must hold on both sides: use saltus::select(condition, a, b), min, "
                "max, abs or smooth_step instead, without std::");
  return false;
}
template <bool used>
void index_of_a_scalar() {
  static_assert(!used,
                "a scalar has no entries: a formula is called as f(t, x), f(t, x, u) or "
                "f(t, x, u, p), with the time t first, and only x, u and p have entries");
}
template <bool used>
long double argument_of_standard_function() {
  static_assert(
      !used,
      "use sin(x), not std::sin(x): functions of <cmath> lose derivatives, so call the functions "
      "of saltus without std:: (sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, "
      "tanh, exp, log, sqrt, pow, hypot, abs, min, max)");
  return 0.0L;
}
template <bool used>
double number_without_derivatives() {
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
// (argument_of_standard_function()).
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
  return detail::branching_on_a_state<ActivePair<A, B>>();
}
template <class A, class B>
  requires ActivePair<A, B>
bool operator>(const A&, const B&) {
  return detail::branching_on_a_state<ActivePair<A, B>>();
}
template <class A, class B>
  requires ActivePair<A, B>
bool operator<=(const A&, const B&) {
  return detail::branching_on_a_state<ActivePair<A, B>>();
}
template <class A, class B>
  requires ActivePair<A, B>
bool operator>=(const A&, const B&) {
  return detail::branching_on_a_state<ActivePair<A, B>>();
}
template <class A, class B>
  requires ActivePair<A, B>
bool operator==(const A&, const B&) {
  return detail::branching_on_a_state<ActivePair<A, B>>();
}
template <class A, class B>
  requires ActivePair<A, B>
bool operator!=(const A&, const B&) {
  return detail::branching_on_a_state<ActivePair<A, B>>();
}

}  // namespace saltus
