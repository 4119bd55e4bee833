// Which inputs a result depends on, and which pairs of inputs act on it nonlinearly: found by
// running the formula once on numbers that carry no value but these two sets.
//
// The sets are structural. x - x still depends on x, and abs, min, max and select count everything
// that enters them as nonlinear, so that "no pair" safely means "affine". Only constants are known:
// a constant zero annihilates in products, so that the zeros of a constant matrix are exact zeros
// of the Jacobian. A formula must therefore keep its constants once it has been traced.
//
// Beside the sets a number knows its degree as a polynomial in the inputs that count as variables,
// up to quadratic; parameters are inputs of degree zero.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "saltus/autodiff/math.hpp"

namespace saltus {

/// A set of small non-negative integers that allocates only when it is not empty.
class IndexSet {
 public:
  void insert(int i) {
    grow(i / 64 + 1);
    words_[i / 64] |= std::uint64_t{1} << (i % 64);
  }
  void insert(const IndexSet& other) {
    grow(static_cast<int>(other.words_.size()));
    for (std::size_t w = 0; w < other.words_.size(); ++w) words_[w] |= other.words_[w];
  }
  bool contains(int i) const {
    return i / 64 < static_cast<int>(words_.size()) && ((words_[i / 64] >> (i % 64)) & 1u) != 0;
  }
  bool empty() const { return words_.empty(); }
  /// Calls visit(i) in ascending order.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t w = 0; w < words_.size(); ++w)
      for (std::uint64_t rest = words_[w]; rest != 0; rest &= rest - 1)
        visit(static_cast<int>(64 * w) + std::countr_zero(rest));
  }

 private:
  void grow(int words) {
    if (words > static_cast<int>(words_.size())) words_.resize(words, 0);
  }
  std::vector<std::uint64_t> words_;
};

/// Stands in for a double in a formula. Allocates freely: set-up only.
class Tracer {
 public:
  Tracer() = default;                            // the constant zero
  Tracer(double constant) : value_(constant) {}  // NOLINT: implicit
  /// `degree` 1: a variable, 0: a parameter.
  static Tracer input(int index, int degree = 1) {
    Tracer x;
    x.inputs_.insert(index);
    x.degree_ = degree;
    return x;
  }
  /// What is not a polynomial of degree 0, 1 or 2 in the variables.
  static constexpr int no_degree = 3;

  bool is_constant() const { return inputs_.empty(); }
  bool is_zero() const { return is_constant() && value_ == 0.0; }
  double constant() const { return value_; }
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
  static Tracer nonlinear(const Tracer& a) {
    Tracer result = a;
    result.interact(a, a);
    if (result.degree_ > 0) result.degree_ = no_degree;
    return result;
  }
  /// f(a, b) for an f without any structure.
  static Tracer nonlinear(const Tracer& a, const Tracer& b) { return nonlinear(linear(a, b)); }
  static Tracer select(const Tracer& condition, const Tracer& a, const Tracer& b) {
    if (condition.is_constant()) return condition.value_ >= 0.0 ? a : b;
    return nonlinear(condition, linear(a, b));
  }

  Tracer& operator+=(const Tracer& b) { return *this = *this + b; }
  Tracer& operator-=(const Tracer& b) { return *this = *this - b; }
  Tracer& operator*=(const Tracer& b) { return *this = *this * b; }
  Tracer& operator/=(const Tracer& b) { return *this = *this / b; }

  friend Tracer operator+(const Tracer& a) { return a; }
  friend Tracer operator-(const Tracer& a) { return a.is_constant() ? Tracer(-a.value_) : a; }
  friend Tracer operator+(const Tracer& a, const Tracer& b) {
    if (a.is_constant() && b.is_constant()) return a.value_ + b.value_;
    return linear(a, b);
  }
  friend Tracer operator-(const Tracer& a, const Tracer& b) {
    if (a.is_constant() && b.is_constant()) return a.value_ - b.value_;
    return linear(a, b);
  }
  friend Tracer operator*(const Tracer& a, const Tracer& b) {
    if (a.is_zero() || b.is_zero()) return 0.0;
    if (a.is_constant() && b.is_constant()) return a.value_ * b.value_;
    Tracer result = linear(a, b);
    result.interact(a, b);
    result.degree_ = std::min(a.degree_ + b.degree_, no_degree);
    return result;
  }
  friend Tracer operator/(const Tracer& a, const Tracer& b) {
    if (b.is_constant()) return a.is_constant() ? Tracer(a.value_ / b.value_) : a;
    return a * nonlinear(b);
  }

 private:
  static Tracer linear(const Tracer& a, const Tracer& b) {
    Tracer result = a;
    result.inputs_.insert(b.inputs_);
    result.pairs_.insert(b.pairs_);
    result.degree_ = std::max(a.degree_, b.degree_);
    return result;
  }
  void interact(const Tracer& a, const Tracer& b) {
    a.inputs_.for_each([&](int i) {
      b.inputs_.for_each([&](int j) {
        const int high = i > j ? i : j;
        const int low = i > j ? j : i;
        pairs_.insert(high * (high + 1) / 2 + low);
      });
    });
  }

  double value_ = 0.0;  // meaningful for constants only
  int degree_ = 0;
  IndexSet inputs_;
  IndexSet pairs_;
};

template <>
inline constexpr bool is_active_scalar<Tracer> = true;

namespace detail {
template <class F>
Tracer trace(F f, const Tracer& x) {
  return x.is_constant() ? Tracer(f(x.constant())) : Tracer::nonlinear(x);
}
template <class F>
Tracer trace(F f, const Tracer& a, const Tracer& b) {
  if (a.is_constant() && b.is_constant()) return f(a.constant(), b.constant());
  return Tracer::nonlinear(a, b);
}
}  // namespace detail

// The lambdas pick the double overload, which has no address of its own among the templates.
inline Tracer sin(const Tracer& x) {
  return detail::trace([](double v) { return std::sin(v); }, x);
}
inline Tracer cos(const Tracer& x) {
  return detail::trace([](double v) { return std::cos(v); }, x);
}
inline Tracer tan(const Tracer& x) {
  return detail::trace([](double v) { return std::tan(v); }, x);
}
inline Tracer asin(const Tracer& x) {
  return detail::trace([](double v) { return std::asin(v); }, x);
}
inline Tracer acos(const Tracer& x) {
  return detail::trace([](double v) { return std::acos(v); }, x);
}
inline Tracer atan(const Tracer& x) {
  return detail::trace([](double v) { return std::atan(v); }, x);
}
inline Tracer sinh(const Tracer& x) {
  return detail::trace([](double v) { return std::sinh(v); }, x);
}
inline Tracer cosh(const Tracer& x) {
  return detail::trace([](double v) { return std::cosh(v); }, x);
}
inline Tracer tanh(const Tracer& x) {
  return detail::trace([](double v) { return std::tanh(v); }, x);
}
inline Tracer exp(const Tracer& x) {
  return detail::trace([](double v) { return std::exp(v); }, x);
}
inline Tracer log(const Tracer& x) {
  return detail::trace([](double v) { return std::log(v); }, x);
}
inline Tracer sqrt(const Tracer& x) {
  return detail::trace([](double v) { return std::sqrt(v); }, x);
}
inline Tracer abs(const Tracer& x) {
  return detail::trace([](double v) { return std::abs(v); }, x);
}
inline Tracer min(const Tracer& a, const Tracer& b) {
  return detail::trace([](double v, double w) { return min(v, w); }, a, b);
}
inline Tracer max(const Tracer& a, const Tracer& b) {
  return detail::trace([](double v, double w) { return max(v, w); }, a, b);
}
inline Tracer atan2(const Tracer& a, const Tracer& b) {
  return detail::trace([](double v, double w) { return std::atan2(v, w); }, a, b);
}
inline Tracer hypot(const Tracer& a, const Tracer& b) {
  return detail::trace([](double v, double w) { return std::hypot(v, w); }, a, b);
}
inline Tracer pow(const Tracer& a, const Tracer& b) {
  if (b.is_constant() && b.constant() == 0.0) return 1.0;
  if (b.is_constant() && b.constant() == 1.0) return a;
  return detail::trace([](double v, double w) { return std::pow(v, w); }, a, b);
}
inline Tracer pow(const Tracer& a, double exponent) { return pow(a, Tracer(exponent)); }

}  // namespace saltus
