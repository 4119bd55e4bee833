#include "saltus/robots/walking/step_logic.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "saltus/app/settings.hpp"
#include "saltus/ocp/window.hpp"
#include "saltus/robots/model/capture_point.hpp"

namespace saltus::walking {

void declare_stepping(Settings& s, Step& step) {
  s.flag("stepping", step.allowed, "may the robot step?");
}

void declare_settings(Settings& s, Step& step) {
  s.number("step.duration", step.duration, "s", "from the trigger to the landing", above(0.0));
  s.choice<StepTrigger>(
      "step.trigger", step.trigger, {{"push", StepTrigger::push}, {"icp", StepTrigger::icp}},
      "a step is taken when the capture point leaves the sole; its time counts from "
      "the push, or from then");
  s.number("step.decision_delay", step.decision_delay, "s",
           "the place of the foot is fixed this long after the trigger", at_least(0.0));
  s.choice<Placement>("step.placement", step.placement,
                      {{"predicted", Placement::predicted}, {"fixed", Placement::fixed}},
                      "at the predicted capture point, or at step.fixed_place");
  s.vector("step.fixed_place", step.fixed_place, "m",
           "swing sole relative to the stance sole: forward, and to the side away from it");
  s.rule({"step.fixed_place"}, [&step] {
    return step.fixed_place[1] > 0.0
               ? ""
               : fmt::format(
                     "step.fixed_place counts away from the stance sole, on either side: its "
                     "second entry must be positive, not {}",
                     step.fixed_place[1]);
  });
  s.number("step.lateral_min", step.lateral_min, "m", "least lateral distance of the soles",
           above(0.0));
  s.number("step.lateral_max", step.lateral_max, "m", "largest lateral distance", above(0.0));
  s.number("step.forward_max", step.forward_max, "m", "reach to the front and back", at_least(0.0));
  s.rule({"step.lateral_min", "step.lateral_max"}, [&step] {
    return step.lateral_min <= step.lateral_max
               ? ""
               : fmt::format("step.lateral_min ({}) exceeds step.lateral_max ({})",
                             step.lateral_min, step.lateral_max);
  });
}

StepLogic::StepLogic(const Step& options, double push_start, Side side, SoleFrame stance,
                     FootRectangle stance_foot)
    : options_(options),
      push_start_(push_start),
      away_(side == Side::left ? -1.0 : 1.0),
      stance_(std::move(stance)),
      stance_foot_(std::move(stance_foot)),
      place_(in_world(options.fixed_place)) {}

// From (forward, away) of the stance sole.
Vec<double, 3> StepLogic::in_world(const Vec<double, 2>& place) const {
  return stance_.position + stance_.rotation * Vec<double, 3>(place[0], away_ * place[1], 0.0);
}

void StepLogic::update(double t, const Vec<double, 2>& capture_point, double omega) {
  if (!options_.allowed || decided_) return;
  if (!is_stepping()) {
    const Vec<double, 3> offset(capture_point[0] - stance_.position[0],
                                capture_point[1] - stance_.position[1], 0.0);
    const Vec<double, 3> local = stance_.rotation.transpose() * offset;
    const bool inside = local[0] >= stance_foot_.x.lower && local[0] <= stance_foot_.x.upper &&
                        local[1] >= stance_foot_.y.lower && local[1] <= stance_foot_.y.upper;
    if (inside || t < push_start_) return;
    // The paper's timing counts from the push. A capture point that leaves the sole only after the
    // landing would have been due is a new event.
    const bool from_push =
        options_.trigger == StepTrigger::push && t < push_start_ + options_.duration;
    trigger_ = from_push ? push_start_ : t;
    landing_ = trigger_ + options_.duration;
  }
  place_ =
      in_world(options_.placement == Placement::fixed ? options_.fixed_place
                                                      : predicted_place(t, capture_point, omega));
  decided_ = t >= std::min(trigger_ + options_.decision_delay, landing_) - same_instant;
}

// Forward and away.
Vec<double, 2> StepLogic::predicted_place(double t, const Vec<double, 2>& capture_point,
                                          double omega) const {
  const Vec<double, 3> offset(capture_point[0] - stance_.position[0],
                              capture_point[1] - stance_.position[1], 0.0);
  const Vec<double, 3> local = stance_.rotation.transpose() * offset;
  const Vec<double, 2> xi = local.head<2>();
  const Vec<double, 2> edge(std::clamp(xi[0], stance_foot_.x.lower, stance_foot_.x.upper),
                            std::clamp(xi[1], stance_foot_.y.lower, stance_foot_.y.upper));
  const Vec<double, 2> at_landing =
      propagate_capture_point<double, 2>(xi, edge, omega, std::max(0.0, landing_ - t));
  return {std::clamp(at_landing[0], -options_.forward_max, options_.forward_max),
          std::clamp(away_ * at_landing[1], options_.lateral_min, options_.lateral_max)};
}

}  // namespace saltus::walking
