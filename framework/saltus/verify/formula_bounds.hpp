// Bounds of a formula and of its first two time derivatives over a piece of time, by interval
// arithmetic on its elementary steps: what no number of samples can promise.
//
// The arguments are given as jets (value, first, second derivative) over the piece. Rounding of the
// interval arithmetic itself is not counted: it is ten orders below every tolerance.
#pragma once

#include <limits>
#include <vector>

#include "saltus/autodiff/formula_steps.hpp"

namespace saltus {

/// All numbers from lower to upper.
struct Interval {
  double lower = 0.0;
  double upper = 0.0;

  Interval() = default;
  Interval(double value) : lower(value), upper(value) {}  // NOLINT(google-explicit-constructor)
  Interval(double from, double to) : lower(from), upper(to) {}
  /// Nothing is known.
  static Interval entire() {
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  }
};

/// A quantity over a piece of time with its time derivatives.
template <class T>
struct TimeJet {
  T value, first, second;
};

/// Evaluates a formula on jets of intervals, or of numbers. Keeps its memory.
class FormulaBounds {
 public:
  explicit FormulaBounds(FormulaSteps steps);

  int outputs() const { return static_cast<int>(steps_.outputs.size()); }
  const FormulaSteps& steps() const { return steps_; }

  /// `arguments`: a jet for each input of the formula. Results: one jet per output.
  void evaluate(const std::vector<TimeJet<Interval>>& arguments);
  const TimeJet<Interval>& bounds(int output) const { return boxes_[steps_.outputs[output]]; }
  /// The same at one instant.
  void evaluate(const std::vector<TimeJet<double>>& arguments);
  const TimeJet<double>& at(int output) const { return numbers_[steps_.outputs[output]]; }

 private:
  FormulaSteps steps_;
  std::vector<TimeJet<Interval>> boxes_;
  std::vector<TimeJet<double>> numbers_;
};

}  // namespace saltus
