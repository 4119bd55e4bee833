// Bounds of a formula and its first two time derivatives over a time interval, by interval
// arithmetic on its elementary steps. Unlike sampling, the bounds are guaranteed.
//
// The arguments are jets (value, first, second derivative) over the interval. Rounding errors of
// the interval arithmetic are neglected: they are ten orders of magnitude below every tolerance.
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
  /// The whole real line.
  static Interval entire() {
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  }
};

/// A quantity over a time interval with its time derivatives.
template <class T>
struct TimeJet {
  T value, first, second;
};

/// Evaluates a formula on jets of intervals or numbers. Reuses its memory.
class FormulaBounds {
 public:
  explicit FormulaBounds(FormulaSteps steps);

  int outputs() const { return static_cast<int>(steps_.outputs.size()); }
  const FormulaSteps& steps() const { return steps_; }

  /// Evaluates bounds. `arguments` holds one jet per input of the formula; the result has one jet
  /// per output.
  void evaluate(const std::vector<TimeJet<Interval>>& arguments);
  const TimeJet<Interval>& bounds(int output) const { return boxes_[steps_.outputs[output]]; }
  /// Evaluates the formula at one instant.
  void evaluate(const std::vector<TimeJet<double>>& arguments);
  const TimeJet<double>& at(int output) const { return numbers_[steps_.outputs[output]]; }

 private:
  FormulaSteps steps_;
  std::vector<TimeJet<Interval>> boxes_;
  std::vector<TimeJet<double>> numbers_;
};

}  // namespace saltus
