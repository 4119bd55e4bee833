#include "saltus/autodiff/formula_steps.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "saltus/autodiff/apply_operation.hpp"

namespace saltus {
namespace {

thread_local StepRecorder* listening = nullptr;

constexpr std::array names{"input", "constant", "add",   "subtract", "multiply", "divide", "negate",
                           "sin",   "cos",      "tan",   "asin",     "acos",     "atan",   "sinh",
                           "cosh",  "tanh",     "exp",   "log",      "sqrt",     "abs",    "min",
                           "max",   "atan2",    "hypot", "pow",      "select"};
static_assert(names.size() == static_cast<std::size_t>(Operation::select) + 1);

}  // namespace

const char* name_of(Operation operation) { return names[static_cast<std::size_t>(operation)]; }

int FormulaSteps::add(Operation operation, int a, int b, int c) {
  steps.push_back({operation, a, b, c});
  return static_cast<int>(steps.size()) - 1;
}

int FormulaSteps::add_constant(double value) {
  steps.push_back({.operation = Operation::constant, .value = value});
  return static_cast<int>(steps.size()) - 1;
}

int FormulaSteps::add_input(int number) {
  steps.push_back({.operation = Operation::input, .value = static_cast<double>(number)});
  return static_cast<int>(steps.size()) - 1;
}

std::vector<int> FormulaSteps::add(const FormulaSteps& other, std::span<const int> arguments) {
  std::vector<int> here(other.steps.size());
  const auto moved = [&](int step) { return step < 0 ? -1 : here[step]; };
  for (std::size_t i = 0; i < other.steps.size(); ++i) {
    const FormulaStep& s = other.steps[i];
    if (s.operation == Operation::input) {
      here[i] = arguments[static_cast<std::size_t>(s.value)];
      continue;
    }
    steps.push_back({s.operation, moved(s.a), moved(s.b), moved(s.c), s.value});
    here[i] = static_cast<int>(steps.size()) - 1;
  }
  std::vector<int> results;
  results.reserve(other.outputs.size());
  for (const int output : other.outputs) results.push_back(here[output]);
  return results;
}

void FormulaSteps::prune() {
  std::vector<char> needed(steps.size(), 0);
  for (const int output : outputs) needed[output] = 1;
  for (std::size_t i = steps.size(); i-- > 0;)
    if (needed[i])
      for (const int argument : {steps[i].a, steps[i].b, steps[i].c})
        if (argument >= 0) needed[argument] = 1;
  std::vector<int> to(steps.size(), -1);
  std::vector<FormulaStep> kept;
  const auto moved = [&](int step) { return step < 0 ? -1 : to[step]; };
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (!needed[i]) continue;
    const FormulaStep& s = steps[i];
    to[i] = static_cast<int>(kept.size());
    kept.push_back({s.operation, moved(s.a), moved(s.b), moved(s.c), s.value});
  }
  steps = std::move(kept);
  for (int& output : outputs) output = to[output];
}

int FormulaSteps::degree(int output, const std::vector<char>& variable) const {
  constexpr int no_degree = 3;
  const int last = outputs[output];
  std::vector<int> degrees(last + 1, 0);
  const auto at = [&](int step) { return step < 0 ? 0 : degrees[step]; };
  for (int i = 0; i <= last; ++i) {
    const FormulaStep& s = steps[i];
    const int a = at(s.a), b = at(s.b), highest = std::max({a, b, at(s.c)});
    const int nonlinear = highest > 0 ? no_degree : 0;
    switch (s.operation) {
      case Operation::input:
        degrees[i] = variable[static_cast<std::size_t>(s.value)] != 0 ? 1 : 0;
        break;
      case Operation::constant:
        break;
      case Operation::add:
      case Operation::subtract:
      case Operation::negate:
        degrees[i] = highest;
        break;
      case Operation::multiply:
        degrees[i] = std::min(a + b, no_degree);
        break;
      case Operation::divide:
        degrees[i] = b > 0 ? no_degree : a;
        break;
      default:
        degrees[i] = nonlinear;
    }
  }
  return degrees[last];
}

std::vector<double> FormulaSteps::evaluate(std::span<const double> z) const {
  std::vector<double> values(steps.size());
  const auto at = [&](int step) { return step < 0 ? 0.0 : values[step]; };
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const FormulaStep& s = steps[i];
    values[i] = s.operation == Operation::input ? z[static_cast<std::size_t>(s.value)]
                : s.operation == Operation::constant
                    ? s.value
                    : detail::apply(s.operation, at(s.a), at(s.b), at(s.c));
  }
  std::vector<double> results;
  results.reserve(outputs.size());
  for (const int output : outputs) results.push_back(values[output]);
  return results;
}

StepRecorder::StepRecorder() : outer_(std::exchange(listening, this)) {}
StepRecorder::~StepRecorder() { listening = outer_; }
StepRecorder* StepRecorder::active() { return listening; }

}  // namespace saltus
