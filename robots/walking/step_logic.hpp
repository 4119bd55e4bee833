// When does the robot step, and where does the foot land?
#pragma once

#include "saltus/core/bounds.hpp"
#include "saltus/robots/model/foot.hpp"
#include "saltus/robots/walking/step_planner.hpp"

namespace saltus {
class Settings;
}

namespace saltus::walking {

enum class StepTrigger { push, icp };
enum class Placement { predicted, fixed };

struct Step {
  bool allowed = true;
  double duration = 0.6;  ///< from the trigger to the landing, s
  StepTrigger trigger = StepTrigger::push;
  /// The placement is decided this long after the trigger, when the push is known, s.
  double decision_delay = 0.1;
  Placement placement = Placement::predicted;
  /// Of the swing sole relative to the stance sole: forward, and to the side away from it, m.
  Vec<double, 2> fixed_place{0.0, 0.14};
  double lateral_min = 0.12;  ///< reach to the side away from the stance sole, m
  double lateral_max = 0.30;
  double forward_max = 0.25;  ///< reach to the front and back, m
};

/// step.*
void declare_settings(Settings& settings, Step& step);
/// `stepping`.
void declare_stepping(Settings& settings, Step& step);

/// Decides once per tick from the capture point. The foot is placed at the capture point predicted
/// for the landing with the centre of pressure at the edge of the stance sole that is nearest to
/// it, clipped to the reach; the place is fixed at the decision.
class StepLogic final : public StepPlanner {
 public:
  /// The stance foot, on that side of the robot, stands at `stance`. Places are forward and to the
  /// side, away from the stance foot: of a left one towards -y.
  StepLogic(const Step& options, double push_start, Side side, SoleFrame stance,
            FootRectangle stance_foot);

  void update(double t, const Vec<double, 2>& capture_point, double omega) override;

  bool is_decided() const { return decided_; }
  double landing_time() const override { return landing_; }
  /// Half-way through the swing.
  double earliest_landing() const override { return landing_ - 0.5 * options_.duration; }
  const Vec<double, 3>& place() const override { return place_; }

 private:
  Vec<double, 3> in_world(const Vec<double, 2>& place) const;
  Vec<double, 2> predicted_place(double t, const Vec<double, 2>& capture_point, double omega) const;

  Step options_;
  double push_start_;
  double away_;  // from the stance foot, along its y
  SoleFrame stance_;
  FootRectangle stance_foot_;
  double trigger_ = infinity;
  double landing_ = infinity;
  bool decided_ = false;
  Vec<double, 3> place_;
};

}  // namespace saltus::walking
