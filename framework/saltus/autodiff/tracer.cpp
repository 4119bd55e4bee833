#include "saltus/autodiff/tracer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "saltus/autodiff/formula_steps.hpp"

namespace saltus {
namespace {

// While a StepRecorder is active, the value of a non-constant tracer is the index of its step.
// Nothing else reads the value of a non-constant.
int step_of(const Tracer& x) {
  FormulaSteps& steps = StepRecorder::active()->steps;
  return x.is_constant() ? steps.add_constant(x.constant()) : static_cast<int>(x.constant());
}

template <class... Arguments>
double recorded(Operation operation, const Arguments&... arguments) {
  StepRecorder* const recorder = StepRecorder::active();
  if (recorder == nullptr) return 0.0;
  // Braces guarantee the order of evaluation.
  const int steps[] = {step_of(arguments)..., -1, -1};
  return recorder->steps.add(operation, steps[0], steps[1], steps[2]);
}

// The operation that nonlinear() records. The argument list of nonlinear() contains only the
// structure.
thread_local Operation applied = Operation::constant;

}  // namespace

FormulaSteps StepRecorder::end(int inputs, const std::vector<Tracer>& y) {
  steps.inputs = inputs;
  steps.outputs.clear();
  for (const Tracer& output : y) steps.outputs.push_back(step_of(output));
  steps.prune();
  return std::move(steps);
}

Tracer::Tracer(const Tracer& other) = default;
Tracer::Tracer(Tracer&& other) noexcept = default;
Tracer& Tracer::operator=(const Tracer& other) = default;
Tracer& Tracer::operator=(Tracer&& other) noexcept = default;
Tracer::~Tracer() = default;

Tracer Tracer::input(int index) {
  Tracer x;
  x.inputs_.insert(index);
  if (StepRecorder* recorder = StepRecorder::active()) x.value_ = recorder->steps.add_input(index);
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
  result.value_ = recorded(applied, a);
  return result;
}

Tracer Tracer::nonlinear(const Tracer& a, const Tracer& b) {
  Tracer result = nonlinear(linear(a, b));
  result.value_ = recorded(applied, a, b);
  return result;
}

Tracer Tracer::select(const Tracer& condition, const Tracer& a, const Tracer& b) {
  if (condition.is_constant()) return condition.value_ >= 0.0 ? a : b;
  Tracer result = nonlinear(condition, linear(a, b));
  result.value_ = recorded(Operation::select, condition, a, b);
  return result;
}

Tracer Tracer::linear(const Tracer& a, const Tracer& b) {
  Tracer result = a;
  result.inputs_.insert(b.inputs_);
  result.pairs_.insert(b.pairs_);
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
Tracer operator-(const Tracer& a) {
  Tracer result = a;
  result.value_ = a.is_constant() ? -a.value_ : recorded(Operation::negate, a);
  return result;
}

Tracer operator+(const Tracer& a, const Tracer& b) {
  if (a.is_constant() && b.is_constant()) return a.value_ + b.value_;
  Tracer result = Tracer::linear(a, b);
  result.value_ = recorded(Operation::add, a, b);
  return result;
}

Tracer operator-(const Tracer& a, const Tracer& b) {
  if (a.is_constant() && b.is_constant()) return a.value_ - b.value_;
  Tracer result = Tracer::linear(a, b);
  result.value_ = recorded(Operation::subtract, a, b);
  return result;
}

Tracer operator*(const Tracer& a, const Tracer& b) {
  if (a.is_zero() || b.is_zero()) return 0.0;
  if (a.is_constant() && b.is_constant()) return a.value_ * b.value_;
  Tracer result = Tracer::linear(a, b);
  result.interact(a, b);
  result.value_ = recorded(Operation::multiply, a, b);
  return result;
}

Tracer operator/(const Tracer& a, const Tracer& b) {
  if (a.is_constant() && b.is_constant()) return a.value_ / b.value_;
  if (a.is_zero()) return 0.0;
  Tracer result = b.is_constant() ? a : a * Tracer::nonlinear(b);
  result.value_ = recorded(Operation::divide, a, b);
  return result;
}

namespace {

template <class F>
Tracer trace(F f, Operation operation, const Tracer& x) {
  if (x.is_constant()) return f(x.constant());
  applied = operation;
  return Tracer::nonlinear(x);
}
template <class F>
Tracer trace(F f, Operation operation, const Tracer& a, const Tracer& b) {
  if (a.is_constant() && b.is_constant()) return f(a.constant(), b.constant());
  applied = operation;
  return Tracer::nonlinear(a, b);
}

}  // namespace

// The lambdas select the double overload, whose address is ambiguous among the templates.
Tracer sin(const Tracer& x) {
  return trace([](double v) { return std::sin(v); }, Operation::sin, x);
}
Tracer cos(const Tracer& x) {
  return trace([](double v) { return std::cos(v); }, Operation::cos, x);
}
Tracer tan(const Tracer& x) {
  return trace([](double v) { return std::tan(v); }, Operation::tan, x);
}
Tracer asin(const Tracer& x) {
  return trace([](double v) { return std::asin(v); }, Operation::asin, x);
}
Tracer acos(const Tracer& x) {
  return trace([](double v) { return std::acos(v); }, Operation::acos, x);
}
Tracer atan(const Tracer& x) {
  return trace([](double v) { return std::atan(v); }, Operation::atan, x);
}
Tracer sinh(const Tracer& x) {
  return trace([](double v) { return std::sinh(v); }, Operation::sinh, x);
}
Tracer cosh(const Tracer& x) {
  return trace([](double v) { return std::cosh(v); }, Operation::cosh, x);
}
Tracer tanh(const Tracer& x) {
  return trace([](double v) { return std::tanh(v); }, Operation::tanh, x);
}
Tracer exp(const Tracer& x) {
  return trace([](double v) { return std::exp(v); }, Operation::exp, x);
}
Tracer log(const Tracer& x) {
  return trace([](double v) { return std::log(v); }, Operation::log, x);
}
Tracer sqrt(const Tracer& x) {
  return trace([](double v) { return std::sqrt(v); }, Operation::sqrt, x);
}
Tracer abs(const Tracer& x) {
  return trace([](double v) { return std::abs(v); }, Operation::abs, x);
}
Tracer min(const Tracer& a, const Tracer& b) {
  return trace([](double v, double w) { return min(v, w); }, Operation::min, a, b);
}
Tracer max(const Tracer& a, const Tracer& b) {
  return trace([](double v, double w) { return max(v, w); }, Operation::max, a, b);
}
Tracer atan2(const Tracer& a, const Tracer& b) {
  return trace([](double v, double w) { return std::atan2(v, w); }, Operation::atan2, a, b);
}
Tracer hypot(const Tracer& a, const Tracer& b) {
  return trace([](double v, double w) { return std::hypot(v, w); }, Operation::hypot, a, b);
}
Tracer pow(const Tracer& a, const Tracer& b) {
  if (b.is_constant() && b.constant() == 0.0) return 1.0;
  if (b.is_constant() && b.constant() == 1.0) return a;
  return trace([](double v, double w) { return std::pow(v, w); }, Operation::pow, a, b);
}
Tracer pow(const Tracer& a, double exponent) { return pow(a, Tracer(exponent)); }

namespace {

// Index of the input that a tracer represents, or -1.
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

void detect_writes(const Tracer* beyond, int count) {
  for (int i = 0; i < count; ++i) written_beyond = written_beyond || beyond[i].is_written();
}

}  // namespace detail
}  // namespace saltus
