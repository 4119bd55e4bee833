// Determines the inputs that a result depends on and the pairs of inputs that enter nonlinearly.
// The formula runs once on numbers that carry only these two sets.
//
// The sets are structural: x - x still depends on x. abs, min, max and select treat all their
// arguments as nonlinear, so an empty pair set safely means "affine". Only constants have values.
// Products with a constant zero are zero, so zeros of a constant matrix are exact zeros of the
// Jacobian. A formula must therefore not change its constants after tracing.
//
// A tracer also knows its degree as a polynomial in the variables, up to quadratic. Parameters are
// inputs of degree zero. It also knows whether it was written: results computed from an unwritten
// entry are unwritten.
#pragma once

#include <concepts>

#include "saltus/autodiff/index_set.hpp"
#include "saltus/autodiff/math.hpp"

namespace saltus {

class Tracer;
template <>
inline constexpr bool is_active_scalar<Tracer> = true;  ///< a tracer tracks dependence

/// Replaces double in a formula that is traced. Allocates, so use it at set-up only. Its arithmetic
/// is compiled once in tracer.cpp, not with every formula.
class Tracer {
 public:
  Tracer() = default;  // the constant zero
  /// A constant, without dependence.
  Tracer(double constant) : value_(constant) {}  // NOLINT: implicit
  Tracer(const Tracer& other);
  Tracer(Tracer&& other) noexcept;
  Tracer& operator=(const Tracer& other);
  Tracer& operator=(Tracer&& other) noexcept;
  ~Tracer();
  /// An input. `degree` is 1 for a variable, 0 for a parameter.
  static Tracer input(int index, int degree = 1);
  /// The value of an entry before its first write.
  static Tracer unwritten();
  /// Degree of a result that is not a polynomial of degree 0, 1 or 2 in the variables.
  static constexpr int no_degree = 3;

  /// True if it has a value.
  bool is_written() const { return written_; }
  /// True if it depends on no input.
  bool is_constant() const { return written_ && inputs_.empty(); }
  /// True if it is the constant 0.
  bool is_zero() const { return is_constant() && value_ == 0.0; }
  /// The value of a constant.
  double constant() const { return value_; }
  /// Degree as a polynomial in the variables, or no_degree.
  int degree() const { return degree_; }
  /// The inputs this result depends on.
  const IndexSet& inputs() const { return inputs_; }
  /// Calls visit(i, j), i >= j, for each pair whose second derivative may be non-zero.
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
  /// f(a, b) for an f without structure.
  static Tracer nonlinear(const Tracer& a, const Tracer& b);
  /// Either a or b. Depends on all inputs of both and of the condition.
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

  /// Declared for a clear compiler error (scalar.hpp), like the next two.
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
  /// A traced value does not convert to a number.
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

 private:
  static Tracer linear(const Tracer& a, const Tracer& b);
  void interact(const Tracer& a, const Tracer& b);

  double value_ = 0.0;  // valid for constants only
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

// Eigen needs it in every file with vectors of tracers.
#include "saltus/autodiff/traced_vector.hpp"
