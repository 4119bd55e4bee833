// The largest violation of a path constraint along one step of the dense output.
//
// Where the formula is known as elementary steps the search is a branch and bound: over a piece of
// time with middle m and half width r the row is at most the least of
//   its value over the piece,  v(m) + r max |v'|,  max_d v(m) + d v'(m) + d^2/2 max v'',
// with bounds by interval arithmetic, and pieces that may hide more than was found are halved. A
// violation of more than a tenth of its tolerance is found however thin it is, to a thousandth of
// itself. Other functions are sampled, more finely until cubic Hermite interpolation predicts them.
#pragma once

#include "saltus/verify/controlled_steps.hpp"
#include "saltus/verify/plan_rows.hpp"

namespace saltus {

/// Searches rows along steps of a plan. Keeps its memory.
class RowSearch {
 public:
  /// Violations below `resolution`, in the units of the row, need not be found.
  explicit RowSearch(double resolution) : resolution_(resolution) {}

  /// The step of `field` that `steps` has taken last, up to `end`, a part of it.
  void look_at(PlanField& field, const ControlledSteps& steps, double end = 1.0);
  /// Updates the violations found in the rows of a constraint. False: the search ran out of pieces.
  bool search(PathConstraint& constraint);

 private:
  struct Sample {
    double at = 0.0;
    std::vector<double> value, slope;
  };

  bool bound(PathConstraint& constraint);
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
