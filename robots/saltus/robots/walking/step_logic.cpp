#include "saltus/robots/walking/step_logic.hpp"

#include <algorithm>

#include "saltus/core/error.hpp"
#include "saltus/ocp/schedule.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::robots::walking {

StepLogic::StepLogic(const Step& options, std::optional<double> push_start, const Scene& scene)
    : options_(options),
      push_start_(push_start.value_or(infinity)),
      swing_side_(other(scene.side)),
      away_(scene.side == Side::left ? -1.0 : 1.0),
      stance_(scene.stance),
      swing_rotation_(scene.swing.rotation),
      stance_foot_(scene.stance_foot),
      swing_foot_(scene.swing_foot),
      place_(in_world(options.fixed_place)) {
  if (options.trigger == Step::Trigger::push && !push_start)
    throw DefinitionError("step logic: the trigger push needs the time at which the push begins");
}

Vec<double, 2> StepLogic::in_stance_sole(const Vec<double, 2>& point) const {
  const Vec<double, 3> offset(point[0] - stance_.position[0], point[1] - stance_.position[1], 0.0);
  const Vec<double, 3> local = stance_.rotation.transpose() * offset;
  return local.head<2>();
}

// World position of a place (forward, away) relative to the stance sole.
Vec<double, 3> StepLogic::in_world(const Vec<double, 2>& place) const {
  return stance_.position + stance_.rotation * Vec<double, 3>(place[0], away_ * place[1], 0.0);
}

Vec<double, 2> StepLogic::nearest_of_stance_sole(const Vec<double, 2>& xi) const {
  return {std::clamp(xi[0], stance_foot_.x.lower, stance_foot_.x.upper),
          std::clamp(xi[1], stance_foot_.y.lower, stance_foot_.y.upper)};
}

bool StepLogic::is_over_stance_sole(const Vec<double, 2>& xi) const {
  return xi[0] >= stance_foot_.x.lower && xi[0] <= stance_foot_.x.upper &&
         xi[1] >= stance_foot_.y.lower && xi[1] <= stance_foot_.y.upper;
}

const StepPlan& StepLogic::plan(const StepSituation& now) {
  update(now.time,
         capture_point_at_rest(now.gamma.head<3>(), now.gamma.segment<3>(3), now.gamma.tail<3>(),
                               now.mass, now.omega),
         now.omega);
  plan_.count = is_stepping() && !now.foot(swing_side_).stands ? 1 : 0;
  if (plan_.count > 0)
    plan_.steps[0] = {swing_side_, now.time, landing_, earliest_landing(), place_};
  return plan_;
}

void StepLogic::update(double t, const Vec<double, 2>& capture_point, double omega) {
  if (!options_.allowed || decided_) return;
  const Vec<double, 2> xi = in_stance_sole(capture_point);
  double trigger = trigger_;
  if (!is_stepping()) {
    if (is_over_stance_sole(xi) || (options_.trigger == Step::Trigger::push && t < push_start_))
      return;
    // The paper measures time from the push. A new event starts if the capture point leaves the
    // sole after the time at which that landing was due, or if a step starts to help only now.
    const bool from_push = options_.trigger == Step::Trigger::push && !declined_ &&
                           t < push_start_ + options_.duration;
    trigger = from_push ? push_start_ : t;
  }
  const double landing = trigger + options_.duration;
  const Vec<double, 2> at_landing = predicted(xi, omega, std::max(0.0, landing - t));
  place_at(at_landing);
  if (!is_stepping() && options_.decide == Step::Decision::if_it_helps && !helps(xi, at_landing)) {
    declined_ = true;
    return;
  }
  trigger_ = trigger;
  landing_ = landing;
  const double decision = options_.decision_lead
                              ? std::max(trigger_, landing_ - *options_.decision_lead)
                              : std::min(trigger_ + options_.decision_delay, landing_);
  decided_ = t >= decision - same_instant;
}

// Predicted capture point in the axes of the stance sole, with the centre of pressure at its edge.
Vec<double, 2> StepLogic::predicted(const Vec<double, 2>& xi, double omega,
                                    double time_left) const {
  return propagate_capture_point<double, 2>(xi, nearest_of_stance_sole(xi), omega, time_left);
}

void StepLogic::place_at(const Vec<double, 2>& at_landing) {
  if (options_.placement == Step::Placement::fixed) return;
  place_ =
      in_world({std::clamp(at_landing[0], -options_.forward_max, options_.forward_max),
                std::clamp(away_ * at_landing[1], options_.lateral_min, options_.lateral_max)});
}

// Allocates, because hulls do; called only before the step begins.
bool StepLogic::helps(const Vec<double, 2>& xi, const Vec<double, 2>& at_landing) const {
  const SupportPolygon hull = SupportPolygon::under(
      {{stance_, stance_foot_}, {SoleFrame{place_, swing_rotation_}, swing_foot_}});
  const Vec<double, 3> point =
      stance_.position + stance_.rotation * Vec<double, 3>(at_landing[0], at_landing[1], 0.0);
  const double to_sole = (at_landing - nearest_of_stance_sole(xi)).norm();
  return hull.signed_distance(point.head<2>()) < helpful * to_sole;
}

std::unique_ptr<StepPlanner> make_formula_steps(const Step& options,
                                                std::optional<double> push_start,
                                                const Scene& scene) {
  return std::make_unique<StepLogic>(options, push_start, scene);
}

}  // namespace saltus::robots::walking
