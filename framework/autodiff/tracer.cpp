#include "saltus/autodiff/tracer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus {

Tracer::Tracer(const Tracer& other) = default;
Tracer::Tracer(Tracer&& other) noexcept = default;
Tracer& Tracer::operator=(const Tracer& other) = default;
Tracer& Tracer::operator=(Tracer&& other) noexcept = default;
Tracer::~Tracer() = default;

Tracer Tracer::input(int index, int degree) {
  Tracer x;
  x.inputs_.insert(index);
  x.degree_ = degree;
  return x;
}

Tracer Tracer::unwritten() {
  Tracer x;
  x.written_ = false;
  return x;
}

Tracer Tracer::nonlinear(const Tracer& a) {
  Tracer result = a;
  result.interact(a, a);
  if (result.degree_ > 0) result.degree_ = no_degree;
  return result;
}

Tracer Tracer::nonlinear(const Tracer& a, const Tracer& b) { return nonlinear(linear(a, b)); }

Tracer Tracer::select(const Tracer& condition, const Tracer& a, const Tracer& b) {
  if (condition.is_constant()) return condition.value_ >= 0.0 ? a : b;
  return nonlinear(condition, linear(a, b));
}

Tracer Tracer::linear(const Tracer& a, const Tracer& b) {
  Tracer result = a;
  result.inputs_.insert(b.inputs_);
  result.pairs_.insert(b.pairs_);
  result.degree_ = std::max(a.degree_, b.degree_);
  result.written_ = a.written_ && b.written_;
  return result;
}

void Tracer::interact(const Tracer& a, const Tracer& b) {
  a.inputs_.for_each([&](int i) {
    b.inputs_.for_each([&](int j) {
      const int high = i > j ? i : j;
      const int low = i > j ? j : i;
      pairs_.insert(high * (high + 1) / 2 + low);
    });
  });
}

Tracer& Tracer::operator+=(const Tracer& b) { return *this = *this + b; }
Tracer& Tracer::operator-=(const Tracer& b) { return *this = *this - b; }
Tracer& Tracer::operator*=(const Tracer& b) { return *this = *this * b; }
Tracer& Tracer::operator/=(const Tracer& b) { return *this = *this / b; }

Tracer operator+(const Tracer& a) { return a; }
Tracer operator-(const Tracer& a) { return a.is_constant() ? Tracer(-a.value_) : a; }

Tracer operator+(const Tracer& a, const Tracer& b) {
  if (a.is_constant() && b.is_constant()) return a.value_ + b.value_;
  return Tracer::linear(a, b);
}

Tracer operator-(const Tracer& a, const Tracer& b) {
  if (a.is_constant() && b.is_constant()) return a.value_ - b.value_;
  return Tracer::linear(a, b);
}

Tracer operator*(const Tracer& a, const Tracer& b) {
  if (a.is_zero() || b.is_zero()) return 0.0;
  if (a.is_constant() && b.is_constant()) return a.value_ * b.value_;
  Tracer result = Tracer::linear(a, b);
  result.interact(a, b);
  result.degree_ = std::min(a.degree_ + b.degree_, Tracer::no_degree);
  return result;
}

Tracer operator/(const Tracer& a, const Tracer& b) {
  if (b.is_constant()) return a.is_constant() ? Tracer(a.value_ / b.value_) : a;
  return a * Tracer::nonlinear(b);
}

namespace {

template <class F>
Tracer trace(F f, const Tracer& x) {
  return x.is_constant() ? Tracer(f(x.constant())) : Tracer::nonlinear(x);
}
template <class F>
Tracer trace(F f, const Tracer& a, const Tracer& b) {
  if (a.is_constant() && b.is_constant()) return f(a.constant(), b.constant());
  return Tracer::nonlinear(a, b);
}

}  // namespace

// The lambdas pick the double overload, which has no address of its own among the templates.
Tracer sin(const Tracer& x) {
  return trace([](double v) { return std::sin(v); }, x);
}
Tracer cos(const Tracer& x) {
  return trace([](double v) { return std::cos(v); }, x);
}
Tracer tan(const Tracer& x) {
  return trace([](double v) { return std::tan(v); }, x);
}
Tracer asin(const Tracer& x) {
  return trace([](double v) { return std::asin(v); }, x);
}
Tracer acos(const Tracer& x) {
  return trace([](double v) { return std::acos(v); }, x);
}
Tracer atan(const Tracer& x) {
  return trace([](double v) { return std::atan(v); }, x);
}
Tracer sinh(const Tracer& x) {
  return trace([](double v) { return std::sinh(v); }, x);
}
Tracer cosh(const Tracer& x) {
  return trace([](double v) { return std::cosh(v); }, x);
}
Tracer tanh(const Tracer& x) {
  return trace([](double v) { return std::tanh(v); }, x);
}
Tracer exp(const Tracer& x) {
  return trace([](double v) { return std::exp(v); }, x);
}
Tracer log(const Tracer& x) {
  return trace([](double v) { return std::log(v); }, x);
}
Tracer sqrt(const Tracer& x) {
  return trace([](double v) { return std::sqrt(v); }, x);
}
Tracer abs(const Tracer& x) {
  return trace([](double v) { return std::abs(v); }, x);
}
Tracer min(const Tracer& a, const Tracer& b) {
  return trace([](double v, double w) { return min(v, w); }, a, b);
}
Tracer max(const Tracer& a, const Tracer& b) {
  return trace([](double v, double w) { return max(v, w); }, a, b);
}
Tracer atan2(const Tracer& a, const Tracer& b) {
  return trace([](double v, double w) { return std::atan2(v, w); }, a, b);
}
Tracer hypot(const Tracer& a, const Tracer& b) {
  return trace([](double v, double w) { return std::hypot(v, w); }, a, b);
}
Tracer pow(const Tracer& a, const Tracer& b) {
  if (b.is_constant() && b.constant() == 0.0) return 1.0;
  if (b.is_constant() && b.constant() == 1.0) return a;
  return trace([](double v, double w) { return std::pow(v, w); }, a, b);
}
Tracer pow(const Tracer& a, double exponent) { return pow(a, Tracer(exponent)); }

namespace {

// The input that a number is, or -1.
int input_of(const Tracer& x) {
  int input = -1, count = 0, pairs = 0;
  x.inputs().for_each([&](int i) {
    input = i;
    ++count;
  });
  x.for_each_pair([&](int, int) { ++pairs; });
  return count == 1 && pairs == 0 ? input : -1;
}

int first_of_inputs(const Tracer* entries, long count) {
  for (long i = 0; i < count; ++i) {
    const int input = input_of(entries[i]);
    if (input < 0 || input != input_of(entries[0]) + i) return -1;
  }
  return count > 0 ? input_of(entries[0]) : -1;
}

}  // namespace

namespace detail {

void TracedBounds::refuse(long row, long col) const {
  throw IndexError{row, col, rows, cols, first_of_inputs(first, rows * cols)};
}

void TracedBounds::refuse(long index) const {
  throw IndexError{index, 0, rows * cols, 1, first_of_inputs(first, rows * cols)};
}

void mark_unwritten(Tracer* entries, int count) {
  std::fill_n(entries, count, Tracer::unwritten());
}

namespace {
thread_local bool written_beyond = false;
}

bool was_written_beyond() { return std::exchange(written_beyond, false); }

void note_written(const Tracer* beyond, int count) {
  for (int i = 0; i < count; ++i) written_beyond = written_beyond || beyond[i].is_written();
}

}  // namespace detail
}  // namespace saltus
