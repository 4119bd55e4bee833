// The largest violation of a path constraint along one step of the dense output.
//
// If the formula is known as elementary steps, the search is a branch and bound: over a time
// interval with middle m and half width r, the row is at most the smallest of
//   its value over the interval,  v(m) + r max |v'|,  max_d v(m) + d v'(m) + d^2/2 max v'',
// with bounds by interval arithmetic. Intervals that may hide more than the largest found violation
// are halved. Every violation above a tenth of its tolerance is found, however short, with a
// relative accuracy of 1e-3. Other functions are sampled, more finely until cubic Hermite
// interpolation predicts them.
#pragma once

#include "saltus/verify/controlled_steps.hpp"
#include "saltus/verify/plan_rows.hpp"

namespace saltus {

/// Searches rows along steps of a plan. Reuses its memory.
class RowSearch {
 public:
  /// Violations below `resolution`, in the units of the row, may be missed.
  explicit RowSearch(double resolution) : resolution_(resolution) {}

  /// Selects the last step of `steps` along `field`, up to the fraction `end` of it.
  void look_at(PlanField& field, const ControlledSteps& steps, double end = 1.0);
  /// Updates the violations of the rows of a constraint. Returns false if the search ran out of
  /// intervals.
  bool search(PathConstraint& constraint, int most_pieces = 20000);
  /// The fraction of the step at this time in seconds.
  double fraction_at(double time) const;

 private:
  struct Sample {
    double at = 0.0;
    std::vector<double> value, slope;
  };

  bool bound(PathConstraint& constraint, int most_pieces);
  bool sample(PathConstraint& constraint);
  bool sample_between(PathConstraint& constraint, const Sample& a, const Sample& b, int depth);
  Sample sample_at(PathConstraint& constraint, double theta);
  void note(PathRow& row, double value, double theta) const;
  double limit(double tolerance, double found) const;
  void fill(const std::vector<int>& arguments, double middle, double radius);
  double time_at(double theta) const;
  double polynomial(int state, int derivative, double theta) const;

  double resolution_;
  double end_ = 1.0;
  PlanField* field_ = nullptr;
  const ControlledSteps* steps_ = nullptr;
  std::vector<TimeJet<Interval>> box_;
  std::vector<TimeJet<double>> point_;
  std::vector<double> x_, values_, entries_;
};

}  // namespace saltus
