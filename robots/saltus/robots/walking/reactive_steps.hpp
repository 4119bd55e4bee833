// Steps without a prediction beyond the next landing: any number of them, with either foot.
#pragma once

#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_logic.hpp"
#include "saltus/robots/walking/step_planner.hpp"

namespace saltus::walking {

/// When the capture point (once the angular momentum is back at zero) has left what the robot
/// stands on, it steps, if that brings the ground nearer to it (`helpful` in step_logic.hpp). Each
/// foot that may lift off and each swing time from `step.duration` down to `step.shortest` is
/// looked at: the foot is placed where the capture point will be at the landing with the centre of
/// pressure at the edge of the other sole, within reach. The longest time that catches it at ease
/// is taken, with the foot that catches it best. While the foot swings, place and time follow the
/// capture point until `step.decision_lead` before the landing; the time only gets shorter.
///
/// Told nothing about pushes. Nothing allocates.
class ReactiveSteps final : public StepPlanner {
 public:
  /// For the first scene; nothing is allocated afterwards.
  ReactiveSteps(const Step& options, const Scene& scene);

  const StepPlan& plan(const StepSituation& now) override;

 private:
  struct Landing {
    double time = infinity;                         // s
    Vec<double, 3> place = Vec<double, 3>::Zero();  // m
    double missed = infinity;                       // capture point outside the hull, m
    bool comfortable = false;                       // far from the ends of the reach
  };
  /// With the swing foot in the air from `lift_off` on.
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

}  // namespace saltus::walking
