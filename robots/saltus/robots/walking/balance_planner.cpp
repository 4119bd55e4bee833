#include "saltus/robots/walking/balance_controller.hpp"

#include <algorithm>
#include <utility>

#include "saltus/ocp/schedule.hpp"
#include "saltus/robots/model/levelled.hpp"

namespace saltus::robots::walking {

BalancePlanner::BalancePlanner(const Scene& scene, Schedule contacts,
                               std::unique_ptr<StepPlanner> steps,
                               std::unique_ptr<Planner> wrenches, double period,
                               BalancePlanner::LandingTime landing)
    : scene_(scene),
      contacts_(std::move(contacts)),
      steps_(std::move(steps)),
      planner_(std::move(wrenches)),
      period_(period),
      landing_(landing) {
  foot(scene_.side) = {true, true};
  foot(other(scene_.side)) = {scene_.two_feet, scene_.two_feet};
}

const char* BalancePlanner::mode_now() const {
  if (stands(Side::left) && stands(Side::right)) return double_support;
  return support_of(stands(Side::left) ? Side::left : Side::right);
}

StepSituation BalancePlanner::situation(double t, const BalancePlanner::Estimate& measured) const {
  StepSituation now;
  now.time = t;
  now.period = period_;
  now.mass = measured.mass;
  now.gamma = measured.gamma;
  now.omega = lipm_frequency(now.gamma[2] - scene_.stance.position[2]);
  for (const Side side : {Side::left, Side::right}) {
    StepSituation::Foot& state = now.foot(side);
    state.sole = levelled(measured.sole(side));
    state.velocity = measured.sole_velocity(side);
    state.stands = stands(side);
    if (is_stepping_ && step_.foot == side) state.lifted_off = step_.lift_off;
    state.support = measured.support(side);
  }
  return now;
}

// The present step follows the plan as long as the plan names its foot first.
BalancePlanner::StepChange BalancePlanner::plan_steps(double t,
                                                      const BalancePlanner::Estimate& measured) {
  StepChange change;
  for (const Side side : {Side::left, Side::right})
    if (const std::optional<FootRectangle>& support = measured.support(side))
      (side == scene_.side ? scene_.stance_foot : scene_.swing_foot) = *support;
  plan_ = steps_->plan(situation(t, measured));
  scene_.motion = plan_.motion;
  if (!plan_.is_stepping()) return change;
  const StepPlan::Step& first = plan_.steps[0];
  if (!is_stepping_ && first.lift_off < t + 0.5 * period_ && stands(other(first.foot))) {
    change.has_begun = true;
    change.has_lifted = stands(first.foot);
    if (change.has_lifted) {
      const Side stance = other(first.foot);
      scene_.stand_on(stance);
      scene_.stance.position.head<2>() = measured.sole(stance).position.head<2>();
      if (first.heading) scene_.stance.rotation = levelled(measured.sole(stance)).rotation;
      foot(first.foot).stands = false;
    }
    step_ = first;
    step_.lift_off = t;
    is_stepping_ = true;
  }
  if (!is_stepping_ || step_.foot != first.foot) return change;
  change.has_target = true;
  const double begun_at = step_.lift_off;
  step_ = first;
  step_.lift_off = begun_at;
  scene_.swing.position = first.place;
  if (first.heading) scene_.swing.rotation = flat_sole(first.place, *first.heading).rotation;
  scene_.two_feet = true;
  return change;
}

void BalancePlanner::land(double t, const Vec<double, 3>& place) {
  foot(step_.foot) = {true, false};
  scene_.swing.position = place;
  is_stepping_ = false;
  contacts_.confirm(impact, t);
}

void BalancePlanner::take_back() {
  foot(step_.foot) = {false, false};
  scene_.swing.position = step_.place;
  is_stepping_ = true;
}

void BalancePlanner::plan_wrenches(double t, const BalancePlanner::Estimate& measured) {
  planner_->controller().prepare(t);  // work that needs no measurement: grid, shifted plan, blocks
  const Planner::Measurement known{t,
                                   measured.gamma,
                                   measured.applied,
                                   foot(Side::left).bore,
                                   foot(Side::right).bore,
                                   measured.contact_force};
  note_contacts();
  schedule(t);
  tick_ = &planner_->tick(known, scene_, contacts_);
}

void BalancePlanner::note_contacts() {
  for (Foot& f : feet_) f.bore = f.stands;
}

// Schedules the present step, then the planned ones. A late foot lands after this tick at the
// earliest, and no foot lifts off within it.
void BalancePlanner::schedule(double t) {
  std::array<StepPlan::Step, StepPlan::most_steps> steps;
  std::size_t count = 0;
  const double next = t + period_;
  if (is_stepping_) {
    steps[count] = step_;
    if (landing_ != BalancePlanner::LandingTime::as_planned)
      steps[count].landing = std::max(
          step_.landing, landing_ == BalancePlanner::LandingTime::doubted ? next + period_ : next);
    ++count;
  }
  const bool on_two_feet = stands(Side::left) && stands(Side::right);
  for (int i = 0; i < plan_.count && count < steps.size(); ++i) {
    const StepPlan::Step& step = plan_.steps[i];
    if (is_stepping_ && i == 0 && step.foot == step_.foot) continue;
    if (!is_stepping_ && i == 0 && (!on_two_feet || step.lift_off <= t)) break;  // landed
    steps[count] = step;
    steps[count].lift_off = std::max(step.lift_off, next);
    ++count;
  }
  if (count == 0 && contacts_.mode_at(t) == mode_now()) return;
  schedule_contacts(contacts_, stands(Side::left), stands(Side::right), {steps.data(), count});
}

Eigen::VectorBlock<const VectorXd> BalancePlanner::wrenches(double t) const {
  const HeldInput::Piece* piece = &tick_->input[0];
  for (const HeldInput::Piece& p : tick_->input)
    if (p.start <= t + same_instant) piece = &p;
  return piece->input();
}

}  // namespace saltus::robots::walking
