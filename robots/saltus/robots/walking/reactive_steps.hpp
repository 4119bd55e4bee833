// Reactive step planner: any number of steps with either foot, without a prediction beyond the next
// landing.
#pragma once

#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_logic.hpp"
#include "saltus/robots/walking/step_planner.hpp"

namespace saltus::robots::walking {

/// The robot steps if the capture point (after the angular momentum has returned to zero) has left
/// the support polygon, and if a step brings the ground nearer to it (`helpful` in step_logic.hpp).
///
/// All feet that may lift off and all swing times from `step.duration` down to `step.shortest_s`
/// are compared. The foot is placed at the capture point predicted for the landing, with the centre
/// of pressure at the edge of the other sole, within reach. The planner takes the longest time that
/// catches the capture point with reserve, and the foot that catches it best. During the swing,
/// place and time follow the capture point until `step.decision_lead_s` before the landing; the
/// time can only decrease.
///
/// The planner has no knowledge of pushes. It does not allocate after construction.
class ReactiveSteps final : public StepPlanner {
 public:
  /// Starts in `scene`.
  ReactiveSteps(const Step& options, const Scene& scene);

  const StepPlan& plan(const StepSituation& now) override;

 private:
  struct Landing {
    double time = infinity;                         // s
    Vec<double, 3> place = Vec<double, 3>::Zero();  // m
    double missed = infinity;  // distance of the capture point outside the hull, m
    bool comfortable = false;  // far from the ends of the reach
  };
  /// Best landing of the foot `swing`, in the air from `lift_off` on.
  Landing landing(const StepSituation& now, const Vec<double, 2>& xi, Side swing, double lift_off,
                  double landing) const;
  Landing best_landing(const StepSituation& now, const Vec<double, 2>& xi, Side swing,
                       double lift_off, double earliest, double latest) const;
  void follow(const StepSituation& now, const Vec<double, 2>& xi);
  void consider(const StepSituation& now, const Vec<double, 2>& xi);
  void set_step(Side foot, double lift_off, const Landing& landing);
  const FootRectangle& rectangle(Side foot) const {
    return foot == Side::left ? left_foot_ : right_foot_;
  }

  Step options_;
  double lead_;  // s
  FootRectangle left_foot_, right_foot_;
  double landed_at_ = -infinity;
};

}  // namespace saltus::robots::walking
