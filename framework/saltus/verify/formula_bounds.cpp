#include "saltus/verify/formula_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace saltus {
namespace {

// ---- intervals ----------------------------------------------------------------------------------

constexpr double none = std::numeric_limits<double>::infinity();

Interval checked(double lower, double upper) {
  return lower <= upper ? Interval{lower, upper} : Interval::entire();  // NaN gives the whole line
}
Interval operator+(const Interval& a, const Interval& b) {
  return checked(a.lower + b.lower, a.upper + b.upper);
}
Interval operator-(const Interval& a) { return {-a.upper, -a.lower}; }
Interval operator-(const Interval& a, const Interval& b) { return a + -b; }
Interval operator*(const Interval& a, const Interval& b) {
  const double p = a.lower * b.lower, q = a.lower * b.upper, r = a.upper * b.lower,
               s = a.upper * b.upper;
  if (std::isnan(p + q + r + s)) {
    const bool is_zero = (a.lower == 0.0 && a.upper == 0.0) || (b.lower == 0.0 && b.upper == 0.0);
    if (is_zero) return 0.0;
    return Interval::entire();
  }
  return {std::min({p, q, r, s}), std::max({p, q, r, s})};
}
bool contains_zero(const Interval& a) { return a.lower <= 0.0 && a.upper >= 0.0; }
Interval operator/(const Interval& a, const Interval& b) {
  if (contains_zero(b)) return Interval::entire();
  return a * Interval{1.0 / b.upper, 1.0 / b.lower};
}
Interval square(const Interval& a) {
  const double l = a.lower * a.lower, u = a.upper * a.upper;
  return checked(contains_zero(a) ? 0.0 : std::min(l, u), std::max(l, u));
}
double square(double a) { return a * a; }
Interval hull(const Interval& a, const Interval& b) {
  return {std::min(a.lower, b.lower), std::max(a.upper, b.upper)};
}

// The same functions for numbers, so that formulas are written once.
double sin(double a) { return std::sin(a); }
double cos(double a) { return std::cos(a); }
double exp(double a) { return std::exp(a); }
double log(double a) { return std::log(a); }
double sqrt(double a) { return std::sqrt(a); }
double atan(double a) { return std::atan(a); }
double asin(double a) { return std::asin(a); }
double tanh(double a) { return std::tanh(a); }
double sinh(double a) { return std::sinh(a); }
double cosh(double a) { return std::cosh(a); }
double tan(double a) { return std::tan(a); }
double abs(double a) { return std::abs(a); }

// cos over [lower, upper] has an extremum at every multiple of pi inside.
Interval cos(const Interval& a) {
  using std::numbers::pi;
  constexpr double far = 1e12;  // beyond it, rounding errors exceed a period
  if (!(a.upper - a.lower < 2.0 * pi) || std::abs(a.lower) > far) return {-1.0, 1.0};
  double lower = std::min(std::cos(a.lower), std::cos(a.upper));
  double upper = std::max(std::cos(a.lower), std::cos(a.upper));
  const double first = std::ceil(a.lower / pi), last = std::floor(a.upper / pi);
  for (double k = first; k <= last; k += 1.0) {
    if (std::fmod(k, 2.0) == 0.0)
      upper = 1.0;
    else
      lower = -1.0;
  }
  return checked(lower, upper);
}
Interval sin(const Interval& a) { return cos(a - 0.5 * std::numbers::pi); }
template <class F>
Interval increasing(const Interval& a, double lowest, double highest, F f) {
  if (!(a.lower >= lowest && a.upper <= highest)) return Interval::entire();
  return checked(f(a.lower), f(a.upper));
}
Interval exp(const Interval& a) {
  return increasing(a, -none, none, [](double x) { return std::exp(x); });
}
Interval log(const Interval& a) {
  return increasing(a, 0.0, none, [](double x) { return std::log(x); });
}
Interval sqrt(const Interval& a) {
  return increasing(a, 0.0, none, [](double x) { return std::sqrt(x); });
}
Interval atan(const Interval& a) {
  return increasing(a, -none, none, [](double x) { return std::atan(x); });
}
Interval asin(const Interval& a) {
  return increasing(a, -1.0, 1.0, [](double x) { return std::asin(x); });
}
Interval tanh(const Interval& a) {
  return increasing(a, -none, none, [](double x) { return std::tanh(x); });
}
Interval sinh(const Interval& a) {
  return increasing(a, -none, none, [](double x) { return std::sinh(x); });
}
Interval cosh(const Interval& a) {
  const double l = std::cosh(a.lower), u = std::cosh(a.upper);
  return checked(contains_zero(a) ? 1.0 : std::min(l, u), std::max(l, u));
}
Interval tan(const Interval& a) {
  using std::numbers::pi;
  if (std::floor(a.lower / pi + 0.5) != std::floor(a.upper / pi + 0.5)) return Interval::entire();
  return increasing(a, -none, none, [](double x) { return std::tan(x); });
}
Interval abs(const Interval& a) {
  const double l = std::abs(a.lower), u = std::abs(a.upper);
  return checked(contains_zero(a) ? 0.0 : std::min(l, u), std::max(l, u));
}
Interval pow(const Interval& a, double exponent) {
  const double rounded = std::round(exponent);
  if (exponent == rounded && exponent >= 0.0) {
    const double l = std::pow(a.lower, exponent), u = std::pow(a.upper, exponent);
    const bool even = std::fmod(rounded, 2.0) == 0.0;
    if (exponent == 0.0) return 1.0;
    if (!even) return checked(l, u);
    return checked(contains_zero(a) ? 0.0 : std::min(l, u), std::max(l, u));
  }
  if (exponent == rounded) return Interval(1.0) / pow(a, -exponent);
  if (!(a.lower >= 0.0) || (exponent < 0.0 && a.lower == 0.0)) return Interval::entire();
  const double l = std::pow(a.lower, exponent), u = std::pow(a.upper, exponent);
  return checked(std::min(l, u), std::max(l, u));
}
double pow(double a, double exponent) { return std::pow(a, exponent); }

bool is_number(const Interval& a) { return a.lower == a.upper; }
bool is_number(double) { return true; }
double number(const Interval& a) { return a.lower; }
double number(double a) { return a; }

// True if a is on one side of zero everywhere.
bool is_above(const Interval& a) { return a.lower >= 0.0; }
bool is_below(const Interval& a) { return a.upper < 0.0; }
bool is_above(double a) { return a >= 0.0; }
bool is_below(double a) { return !(a >= 0.0); }

double unknown(double) { return 0.0; }  // a number is always on one side
Interval unknown(const Interval&) { return Interval::entire(); }
double hull(double a, double) { return a; }

// ---- jets ---------------------------------------------------------------------------------------

template <class T>
using Jet = TimeJet<T>;

template <class T>
Jet<T> add(const Jet<T>& a, const Jet<T>& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
template <class T>
Jet<T> negate(const Jet<T>& a) {
  return {-a.value, -a.first, -a.second};
}
template <class T>
Jet<T> multiply(const Jet<T>& a, const Jet<T>& b) {
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + T(2.0) * (a.first * b.first) + a.value * b.second};
}
// f(a) with f, f' and f'' over a.
template <class T>
Jet<T> chain(const Jet<T>& a, const T& f, const T& f1, const T& f2) {
  return {f, f1 * a.first, f2 * square(a.first) + f1 * a.second};
}
template <class T>
Jet<T> squared(const Jet<T>& a) {
  return {square(a.value), T(2.0) * (a.value * a.first),
          T(2.0) * (square(a.first) + a.value * a.second)};
}
template <class T>
Jet<T> inverse(const Jet<T>& a) {
  const T r = T(1.0) / a.value;
  return chain<T>(a, r, -square(r), T(2.0) * (r * square(r)));
}
template <class T>
Jet<T> root(const Jet<T>& a) {
  const T r = sqrt(a.value), half = T(0.5) / r;
  return chain<T>(a, r, half, -(half / (T(2.0) * a.value)));
}
// b if a >= 0, else c. At a kink the second derivative is unknown, at a jump the first one too.
template <class T>
Jet<T> choose(const T& a, const Jet<T>& b, const Jet<T>& c, bool is_continuous) {
  if (is_above(a)) return b;
  if (is_below(a)) return c;
  return {hull(b.value, c.value), is_continuous ? hull(b.first, c.first) : unknown(b.first),
          unknown(b.second)};
}
template <class T>
Jet<T> power(const Jet<T>& a, const Jet<T>& b) {
  if (is_number(b.value)) {
    const double n = number(b.value);
    if (n == 0.0) return {T(1.0), T(0.0), T(0.0)};
    if (n == 1.0) return a;
    if (n == 2.0) return squared(a);
    return chain<T>(a, pow(a.value, n), T(n) * pow(a.value, n - 1.0),
                    T(n * (n - 1.0)) * pow(a.value, n - 2.0));
  }
  const T l = log(a.value), r = T(1.0) / a.value;
  const Jet<T> product = multiply(b, chain<T>(a, l, r, -square(r)));
  const T e = exp(product.value);
  return chain<T>(product, e, e, e);
}
template <class T>
T angle(const T& y, const T& x);
template <>
double angle(const double& y, const double& x) {
  return std::atan2(y, x);
}
template <>
Interval angle(const Interval& y, const Interval& x) {
  if (x.lower <= 0.0 && contains_zero(y)) {
    if (contains_zero(x) || y.lower < 0.0) return {-std::numbers::pi, std::numbers::pi};
  }
  const double p = std::atan2(y.lower, x.lower), q = std::atan2(y.lower, x.upper),
               r = std::atan2(y.upper, x.lower), s = std::atan2(y.upper, x.upper);
  return checked(std::min({p, q, r, s}), std::max({p, q, r, s}));
}
// d atan2(y, x) = (x dy - y dx) / (x^2 + y^2); its derivative by the quotient rule.
template <class T>
Jet<T> angle_of(const Jet<T>& y, const Jet<T>& x) {
  const T radius = square(x.value) + square(y.value);
  const T turn = x.value * y.first - y.value * x.first;
  const T first = turn / radius;
  const T grows = T(2.0) * (x.value * x.first + y.value * y.first);
  const T turns = x.value * y.second - y.value * x.second;
  return {angle<T>(y.value, x.value), first, (turns - first * grows) / radius};
}

template <class T>
Jet<T> apply(const FormulaStep& step, const std::vector<Jet<T>>& values) {
  const auto& a = values[std::max(step.a, 0)];
  const auto& b = values[std::max(step.b, 0)];
  const auto& c = values[std::max(step.c, 0)];
  switch (step.operation) {
    case Operation::input:
    case Operation::constant:
      break;
    case Operation::add:
      return add(a, b);
    case Operation::subtract:
      return add(a, negate(b));
    case Operation::multiply:
      return step.a == step.b ? squared(a) : multiply(a, b);
    case Operation::divide:
      return multiply(a, inverse(b));
    case Operation::negate:
      return negate(a);
    case Operation::sin: {
      const T s = sin(a.value);
      return chain<T>(a, s, cos(a.value), -s);
    }
    case Operation::cos: {
      const T c0 = cos(a.value);
      return chain<T>(a, c0, -sin(a.value), -c0);
    }
    case Operation::tan: {
      const T t = tan(a.value), slope = T(1.0) + square(t);
      return chain<T>(a, t, slope, T(2.0) * (t * slope));
    }
    case Operation::asin:
    case Operation::acos: {
      const T r = T(1.0) / (T(1.0) - square(a.value));
      const T slope = sqrt(r);
      const Jet<T> arc = chain<T>(a, asin(a.value), slope, a.value * (r * slope));
      if (step.operation == Operation::asin) return arc;
      return add(negate(arc), {T(0.5 * std::numbers::pi), T(0.0), T(0.0)});
    }
    case Operation::atan: {
      const T slope = T(1.0) / (T(1.0) + square(a.value));
      return chain<T>(a, atan(a.value), slope, -(T(2.0) * (a.value * square(slope))));
    }
    case Operation::sinh: {
      const T s = sinh(a.value);
      return chain<T>(a, s, cosh(a.value), s);
    }
    case Operation::cosh: {
      const T c0 = cosh(a.value);
      return chain<T>(a, c0, sinh(a.value), c0);
    }
    case Operation::tanh: {
      const T t = tanh(a.value), slope = T(1.0) - square(t);
      return chain<T>(a, t, slope, -(T(2.0) * (t * slope)));
    }
    case Operation::exp: {
      const T e = exp(a.value);
      return chain<T>(a, e, e, e);
    }
    case Operation::log: {
      const T r = T(1.0) / a.value;
      return chain<T>(a, log(a.value), r, -square(r));
    }
    case Operation::sqrt:
      return root(a);
    case Operation::abs: {
      Jet<T> result = choose<T>(a.value, a, negate(a), true);
      result.value = abs(a.value);
      return result;
    }
    case Operation::min: {
      Jet<T> result = choose<T>(b.value - a.value, a, b, true);
      return result;
    }
    case Operation::max: {
      Jet<T> result = choose<T>(a.value - b.value, a, b, true);
      return result;
    }
    case Operation::atan2:
      return angle_of(a, b);
    case Operation::hypot:
      return root(add(squared(a), squared(b)));
    case Operation::pow:
      return power(a, b);
    case Operation::select:
      return choose<T>(a.value, b, c, false);
  }
  return {};
}

template <class T>
void run(const FormulaSteps& formula, const std::vector<Jet<T>>& arguments,
         std::vector<Jet<T>>& values) {
  for (std::size_t i = 0; i < formula.steps.size(); ++i) {
    const FormulaStep& step = formula.steps[i];
    values[i] = step.operation == Operation::input ? arguments[static_cast<std::size_t>(step.value)]
                : step.operation == Operation::constant ? Jet<T>{T(step.value), T(0.0), T(0.0)}
                                                        : apply<T>(step, values);
  }
}

}  // namespace

FormulaBounds::FormulaBounds(FormulaSteps steps)
    : steps_(std::move(steps)), boxes_(steps_.steps.size()), numbers_(steps_.steps.size()) {}

void FormulaBounds::evaluate(const std::vector<TimeJet<Interval>>& arguments) {
  run(steps_, arguments, boxes_);
}
void FormulaBounds::evaluate(const std::vector<TimeJet<double>>& arguments) {
  run(steps_, arguments, numbers_);
}

}  // namespace saltus
