// Step planner by formula: one step of the swing foot to the predicted capture point.
#pragma once

#include <optional>

#include "saltus/core/bounds.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_planner.hpp"

namespace saltus::walking {

/// Step planner: one step of the foot in the air by a formula (StepLogic), any number of steps with
/// either foot by a rule (ReactiveSteps), or the problem's own planner by optimal control.
enum class StepPlannerChoice { formula, reactive, ocp };
/// Trigger of a step: the start of the push, or the capture point.
enum class StepTrigger { push, icp };
/// Step always, or only if standing cannot recover.
enum class StepDecision { always, if_it_helps };
/// Placement of the foot: by the capture point, or at a fixed place.
enum class Placement { predicted, fixed };

/// Largest share of the distance between ground and capture point that a helpful step may leave.
/// Halving it does not yet recover the robot, but a step with less effect costs a standing robot
/// its balance.
inline constexpr double helpful = 0.5;

/// Options of the step planner.
struct Step {
  bool allowed = true;                                     ///< true if the robot may step
  StepPlannerChoice planner = StepPlannerChoice::formula;  ///< type of planner
  double duration = 0.6;  ///< time from the trigger to the landing, s
  double shortest = 0.3;  ///< shortest swing of the reactive planner, s
  /// True if the formula knows the start of the push. No planner knows its size, direction or
  /// duration, and the other planners have no knowledge of the push.
  bool known = true;
  StepTrigger trigger = StepTrigger::push;     ///< trigger of a step
  StepDecision decide = StepDecision::always;  ///< step always, or only if it helps
  /// Time from the trigger to the final placement, s; the push of the paper is then over.
  double decision_delay = 0.1;
  /// Alternative to `decision_delay`: time from the final placement to the landing, s.
  std::optional<double> decision_lead;
  Placement placement = Placement::predicted;  ///< by the capture point or fixed
  /// Place of the swing sole relative to the stance sole: forward, and to the side away from it, m.
  Vec<double, 2> fixed_place{0.0, 0.14};
  double lateral_min = 0.12;  ///< smallest distance to the side of the stance sole, m
  double lateral_max = 0.30;  ///< largest distance to the side of the stance sole, m
  double forward_max = 0.25;  ///< largest distance to the front or back, m
};

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

}  // namespace saltus::walking
