// A formula as a list of elementary steps, recorded while tracers run through it. Tools that do not
// read C++ use the list to evaluate the same formula.
#pragma once

#include <span>
#include <vector>

namespace saltus {

class Tracer;

/// The elementary operations.
enum class Operation {
  input,
  constant,
  add,
  subtract,
  multiply,
  divide,
  negate,
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  sinh,
  cosh,
  tanh,
  exp,
  log,
  sqrt,
  abs,
  min,
  max,
  atan2,
  hypot,
  pow,
  select,  ///< b if a >= 0, else c
};
/// Name as written in C++: "multiply", "sin".
const char* name_of(Operation operation);

/// One elementary step of a formula.
struct FormulaStep {
  Operation operation = Operation::constant;  ///< the operation
  int a = -1, b = -1, c = -1;                 ///< arguments: indices of earlier steps, or -1
  double value = 0.0;                         ///< value of a constant; index of an input
};

/// y = f(z). Each step uses earlier steps only.
struct FormulaSteps {
  int inputs = 0;                  ///< number of inputs
  std::vector<FormulaStep> steps;  ///< steps in order of evaluation
  std::vector<int> outputs;        ///< indices of the steps that are results

  /// Appends a step with earlier steps as arguments. Returns its index.
  int add(Operation operation, int a, int b = -1, int c = -1);
  /// Appends a constant. Returns the index of its step.
  int add_constant(double value);
  /// Appends an input of the formula. Returns the index of its step.
  int add_input(int number);
  /// Appends another formula, applied to steps of this one. Returns the indices of its outputs.
  std::vector<int> add(const FormulaSteps& other, std::span<const int> arguments);
  /// Removes the steps that no output needs.
  void prune();
  /// Degree of an output as a polynomial in the flagged inputs, with the other inputs fixed: 0, 1
  /// or 2, or 3 for everything else. Never too small.
  int degree(int output, const std::vector<char>& variable) const;
  /// Evaluates the formula. z has `inputs` entries; the result has one entry per output.
  std::vector<double> evaluate(std::span<const double> z) const;
};

/// During its lifetime, tracers of this thread record their steps in it. A recorder that is created
/// meanwhile interrupts the recording until its own end.
class StepRecorder {
 public:
  StepRecorder();
  ~StepRecorder();
  StepRecorder(const StepRecorder&) = delete;
  StepRecorder& operator=(const StepRecorder&) = delete;

  /// The recorder of this thread, or null.
  static StepRecorder* active();
  /// The steps of a formula with results y, without those that no result needs.
  FormulaSteps end(int inputs, const std::vector<Tracer>& y);

  FormulaSteps steps;  ///< the recorded steps

 private:
  StepRecorder* outer_;
};

}  // namespace saltus
