// Which inputs a result depends on, and which pairs of inputs act on it nonlinearly: found by
// running the formula once on numbers that carry no value but these two sets.
//
// The sets are structural. x - x still depends on x, and abs, min, max and select count everything
// that enters them as nonlinear, so that "no pair" safely means "affine". Only constants are known:
// a constant zero annihilates in products, so that the zeros of a constant matrix are exact zeros
// of the Jacobian. A formula must therefore keep its constants once it has been traced.
//
// Beside the sets a number knows its degree as a polynomial in the inputs that count as variables,
// up to quadratic; parameters are inputs of degree zero. And it knows whether it was written at
// all: an entry of a vector that was not is no number, nor is what is computed from it.
#pragma once

#include <concepts>

#include "saltus/autodiff/index_set.hpp"
#include "saltus/autodiff/math.hpp"

namespace saltus {

class Tracer;
template <>
inline constexpr bool is_active_scalar<Tracer> = true;  ///< a tracer follows dependence

/// Stands in for a double in a formula. Allocates freely: set-up only. Its arithmetic is compiled
/// once, in tracer.cpp, and not with every formula.
class Tracer {
 public:
  Tracer() = default;  // the constant zero
  /// A constant: depends on nothing.
  Tracer(double constant) : value_(constant) {}  // NOLINT: implicit
  Tracer(const Tracer& other);
  Tracer(Tracer&& other) noexcept;
  Tracer& operator=(const Tracer& other);
  Tracer& operator=(Tracer&& other) noexcept;
  ~Tracer();
  /// `degree` 1: a variable, 0: a parameter.
  static Tracer input(int index, int degree = 1);
  /// What stands in a vector that nobody has written to yet.
  static Tracer unwritten();
  /// What is not a polynomial of degree 0, 1 or 2 in the variables.
  static constexpr int no_degree = 3;

  /// Whether it was ever given a value.
  bool is_written() const { return written_; }
  /// Whether it depends on nothing.
  bool is_constant() const { return written_ && inputs_.empty(); }
  /// Whether it is the constant 0.
  bool is_zero() const { return is_constant() && value_ == 0.0; }
  /// Its value, if it is a constant.
  double constant() const { return value_; }
  /// As a polynomial in the variables; no_degree where it is none.
  int degree() const { return degree_; }
  /// The inputs this result depends on.
  const IndexSet& inputs() const { return inputs_; }
  /// Calls visit(i, j), i >= j, for every pair whose second derivative can be non-zero.
  template <class Visit>
  void for_each_pair(Visit&& visit) const {
    pairs_.for_each([&](int index) {
      int i = 0;  // index = i (i + 1) / 2 + j
      while ((i + 1) * (i + 2) / 2 <= index) ++i;
      visit(i, index - i * (i + 1) / 2);
    });
  }

  /// f(a) for a nonlinear f.
  static Tracer nonlinear(const Tracer& a);
  /// f(a, b) for an f without any structure.
  static Tracer nonlinear(const Tracer& a, const Tracer& b);
  /// One of both, so it depends on all that either depends on.
  static Tracer select(const Tracer& condition, const Tracer& a, const Tracer& b);

  Tracer& operator+=(const Tracer& b);
  Tracer& operator-=(const Tracer& b);
  Tracer& operator*=(const Tracer& b);
  Tracer& operator/=(const Tracer& b);

  friend Tracer operator+(const Tracer& a);
  friend Tracer operator-(const Tracer& a);
  friend Tracer operator+(const Tracer& a, const Tracer& b);
  friend Tracer operator-(const Tracer& a, const Tracer& b);
  friend Tracer operator*(const Tracer& a, const Tracer& b);
  friend Tracer operator/(const Tracer& a, const Tracer& b);
  friend Tracer operator+(const Tracer& a, double b) { return a + Tracer(b); }
  friend Tracer operator+(double a, const Tracer& b) { return Tracer(a) + b; }
  friend Tracer operator-(const Tracer& a, double b) { return a - Tracer(b); }
  friend Tracer operator-(double a, const Tracer& b) { return Tracer(a) - b; }
  friend Tracer operator*(const Tracer& a, double b) { return a * Tracer(b); }
  friend Tracer operator*(double a, const Tracer& b) { return Tracer(a) * b; }
  friend Tracer operator/(const Tracer& a, double b) { return a / Tracer(b); }
  friend Tracer operator/(double a, const Tracer& b) { return Tracer(a) / b; }

  /// Declared so that the compiler says what to write (scalar.hpp), as the next two.
  template <class Index>
  const Tracer& operator[](const Index&) const {
    detail::index_of_a_scalar<(sizeof(Index) > 0)>();
    return *this;
  }
  /// A scalar has no entries.
  template <class Index>
  const Tracer& operator()(const Index&) const {
    detail::index_of_a_scalar<(sizeof(Index) > 0)>();
    return *this;
  }
  /// A value that depends on a state is no number.
  template <std::same_as<double> Number>
  explicit operator Number() const {
    return detail::number_without_derivatives<(sizeof(Number) > 0)>();
  }
  /// Selected by functions of <cmath> alone, which have an overload for long double. As a template
  /// it converts to no other type, so that `condition ? x[0] : 1.0` has one meaning.
  template <std::same_as<long double> Number>
  operator Number() const {  // NOLINT: implicit
    return detail::argument_of_standard_function<(sizeof(Number) > 0)>();
  }

 private:
  static Tracer linear(const Tracer& a, const Tracer& b);
  void interact(const Tracer& a, const Tracer& b);

  double value_ = 0.0;  // meaningful for constants only
  int degree_ = 0;
  bool written_ = true;
  IndexSet inputs_;
  IndexSet pairs_;
};

Tracer sin(const Tracer& x);
Tracer cos(const Tracer& x);
Tracer tan(const Tracer& x);
Tracer asin(const Tracer& x);
Tracer acos(const Tracer& x);
Tracer atan(const Tracer& x);
Tracer sinh(const Tracer& x);
Tracer cosh(const Tracer& x);
Tracer tanh(const Tracer& x);
Tracer exp(const Tracer& x);
Tracer log(const Tracer& x);
Tracer sqrt(const Tracer& x);
Tracer abs(const Tracer& x);
Tracer min(const Tracer& a, const Tracer& b);
Tracer max(const Tracer& a, const Tracer& b);
Tracer atan2(const Tracer& a, const Tracer& b);
Tracer hypot(const Tracer& a, const Tracer& b);
Tracer pow(const Tracer& a, const Tracer& b);
Tracer pow(const Tracer& a, double exponent);

}  // namespace saltus

// Eigen must know it wherever there are vectors of tracers.
#include "saltus/autodiff/traced_vector.hpp"
