// Step planner by formula: one step of the swing foot to the predicted capture point.
#pragma once

#include <optional>

#include "saltus/core/bounds.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_planner.hpp"

namespace saltus::robots::walking {

/// Largest share of the distance between ground and capture point that a helpful step may leave.
/// A step that halves the distance does not yet recover the robot, but after a step with less
/// effect a standing robot loses its balance.
inline constexpr double helpful = 0.5;

/// Decides once per tick from the capture point. The foot is placed at the capture point predicted
/// for the landing, with the centre of pressure at the nearest edge of the stance sole. The place
/// is clipped to the reach and follows the prediction until the final placement.
///
/// A step helps if the hull of both feet is less than half as far from the predicted point as the
/// stance sole is (zero if the hull contains the point). Towards the stance side, where legs cannot
/// cross, a step does not help; standing with full use of the angular momentum is better.
class StepLogic final : public StepPlanner {
 public:
  /// Starts in `scene`. Places are forward and to the side, away from the stance foot: towards -y
  /// for a left one. `push_start` (s) is required for the trigger `push`; throws DefinitionError
  /// without it.
  StepLogic(const Step& options, std::optional<double> push_start, const Scene& scene);

  const StepPlan& plan(const StepSituation& now) override;

  /// Updates the plan from the capture point (world, m) at which the robot comes to rest; omega in
  /// 1/s.
  void update(double t, const Vec<double, 2>& capture_point, double omega);
  /// True if a foot swings or is about to lift off.
  bool is_stepping() const { return landing_ < infinity; }
  /// True if place and time of the landing are final.
  bool is_decided() const { return decided_; }
  /// Landing time in s; infinite: no step.
  double landing_time() const { return landing_; }
  /// Earliest accepted landing, in the middle of the swing.
  double earliest_landing() const { return landing_ - 0.5 * options_.duration; }
  /// Place of the sole, m.
  const Vec<double, 3>& place() const { return place_; }

 private:
  Vec<double, 2> in_stance_sole(const Vec<double, 2>& point) const;
  Vec<double, 3> in_world(const Vec<double, 2>& place) const;
  Vec<double, 2> nearest_of_stance_sole(const Vec<double, 2>& xi) const;
  bool is_over_stance_sole(const Vec<double, 2>& xi) const;
  Vec<double, 2> predicted(const Vec<double, 2>& xi, double omega, double time_left) const;
  void place_at(const Vec<double, 2>& at_landing);
  bool helps(const Vec<double, 2>& xi, const Vec<double, 2>& at_landing) const;

  Step options_;
  double push_start_;  // infinite: unknown
  Side swing_side_;
  double away_;  // sign of the direction away from the stance foot, along its y axis
  SoleFrame stance_;
  Mat<double, 3, 3> swing_rotation_;
  FootRectangle stance_foot_, swing_foot_;
  bool declined_ = false;  // true if a step was rejected because it would not have helped
  double trigger_ = infinity;
  double landing_ = infinity;
  bool decided_ = false;
  Vec<double, 3> place_;
};

}  // namespace saltus::robots::walking
