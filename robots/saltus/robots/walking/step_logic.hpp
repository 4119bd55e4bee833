// When does the robot step, and where does the foot land?
#pragma once

#include <optional>

#include "saltus/core/bounds.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_planner.hpp"

namespace saltus::walking {

/// One step of the foot in the air by a formula (StepLogic), or any number of either foot: by a
/// rule (ReactiveSteps), or by optimal control, which is the problem's own.
enum class StepPlannerChoice { formula, reactive, ocp };
/// What makes the robot step: the push itself, or the capture point.
enum class StepTrigger { push, icp };
/// Step always, or only where standing does not hold.
enum class StepDecision { always, if_it_helps };
/// Where the foot is put: by the capture point, or a fixed place.
enum class Placement { predicted, fixed };

/// What a step must leave of the distance between ground and capture point at most. A step that
/// halves it is not yet a recovery, but one that does less costs the standing robot its balance.
inline constexpr double helpful = 0.5;

/// When and where a foot is put.
struct Step {
  bool allowed = true;                                     ///< may it step at all?
  StepPlannerChoice planner = StepPlannerChoice::formula;  ///< by the formula or by optimal control
  double duration = 0.6;                                   ///< from the trigger to the landing, s
  double shortest = 0.3;                                   ///< swing of the rule, s
  /// Whether the formula is told when the push begins; nobody is told of its size, direction and
  /// duration, and the other planners are told nothing.
  bool known = true;
  StepTrigger trigger = StepTrigger::push;     ///< what makes it step
  StepDecision decide = StepDecision::always;  ///< always or only where it helps
  /// The placement is decided this long after the trigger, when the paper's push is over, s.
  double decision_delay = 0.1;
  /// In place of that: this long before the landing, s.
  std::optional<double> decision_lead;
  Placement placement = Placement::predicted;  ///< by the capture point or fixed
  /// Of the swing sole relative to the stance sole: forward, and to the side away from it, m.
  Vec<double, 2> fixed_place{0.0, 0.14};
  double lateral_min = 0.12;  ///< reach to the side away from the stance sole, m
  double lateral_max = 0.30;  ///< to the side, m
  double forward_max = 0.25;  ///< reach to the front and back, m
};

/// Decides once per tick from the capture point. The foot is placed at the capture point predicted
/// for the landing with the centre of pressure at the edge of the stance sole that is nearest to
/// it, clipped to the reach; the place moves with the prediction until it is decided.
///
/// A step helps if the hull of both feet is less than half as far from that point as the stance
/// sole is (none of it where it contains the point). Towards the stance side, where the legs do not
/// cross, it does not, and standing with all of the angular momentum is better.
class StepLogic final : public StepPlanner {
 public:
  /// In the scene at the start. Places are forward and to the side, away from the stance foot: of a
  /// left one towards -y. `push_start` (s) as far as it is told, which the trigger `push` needs:
  /// throws DefinitionError without it.
  StepLogic(const Step& options, std::optional<double> push_start, const Scene& scene);

  const StepPlan& plan(const StepSituation& now) override;

  /// The same from the capture point (world, m) that the robot comes to at rest; omega 1/s.
  void update(double t, const Vec<double, 2>& capture_point, double omega);
  /// Whether a foot is in the air or about to be.
  bool is_stepping() const { return landing_ < infinity; }
  /// Whether place and time of the landing are settled.
  bool is_decided() const { return decided_; }
  /// In s; infinity: no step.
  double landing_time() const { return landing_; }
  /// Half-way through the swing.
  double earliest_landing() const { return landing_ - 0.5 * options_.duration; }
  /// Of the sole, m.
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
  double push_start_;  // infinite: nobody told
  Side swing_side_;
  double away_;  // from the stance foot, along its y
  SoleFrame stance_;
  Mat<double, 3, 3> swing_rotation_;
  FootRectangle stance_foot_, swing_foot_;
  bool declined_ = false;  // a step that would not have helped
  double trigger_ = infinity;
  double landing_ = infinity;
  bool decided_ = false;
  Vec<double, 3> place_;
};

}  // namespace saltus::walking
