// A formula as a list of elementary steps: written down while tracers run through it, for tools
// that are to compute the same and do not read C++.
#pragma once

#include <span>
#include <vector>

namespace saltus {

class Tracer;

/// What one elementary step does.
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
  select,  ///< b where a >= 0, else c
};
/// As it is written in C++: "multiply", "sin".
const char* name_of(Operation operation);

/// One elementary step of a formula.
struct FormulaStep {
  Operation operation = Operation::constant;  ///< what it does
  int a = -1, b = -1, c = -1;                 ///< arguments: earlier steps, -1: none
  double value = 0.0;                         ///< of a constant; of an input its number
};

/// y = f(z). Steps refer to earlier ones only; outputs are steps.
struct FormulaSteps {
  int inputs = 0;                  ///< how many numbers the formula takes
  std::vector<FormulaStep> steps;  ///< in the order in which they are carried out
  std::vector<int> outputs;        ///< of the steps: which are results

  /// Appends a step on earlier ones; returns its number.
  int add(Operation operation, int a, int b = -1, int c = -1);
  /// Appends a number; returns its step.
  int add_constant(double value);
  /// Appends an argument of the formula; returns its step.
  int add_input(int number);
  /// Another formula's steps on arguments that are steps of this one; returns its outputs.
  std::vector<int> add(const FormulaSteps& other, std::span<const int> arguments);
  /// Leaves out the steps that no output needs.
  void prune();
  /// z has `inputs` entries; the result one per output.
  std::vector<double> evaluate(std::span<const double> z) const;
};

/// While it lives, the tracers of this thread write their steps into it. One at a time in a thread.
class StepRecorder {
 public:
  StepRecorder();
  ~StepRecorder();
  StepRecorder(const StepRecorder&) = delete;
  StepRecorder& operator=(const StepRecorder&) = delete;

  /// Null: nobody listens.
  static StepRecorder* active();
  /// A formula with these inputs was traced to its end.
  void end(const std::vector<Tracer>& z, const std::vector<Tracer>& y);

  FormulaSteps steps;  ///< what was recorded
  int formulas = 0;    ///< how many were traced to their end
};

}  // namespace saltus
