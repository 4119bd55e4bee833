#include "saltus/robots/walking/balance_controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/model/levelled.hpp"
#include "saltus/robots/walking/cpu_time.hpp"
#include "saltus/robots/whole_body/foot_support.hpp"
#include "saltus/robots/whole_body/stance_foot.hpp"
#include "saltus/robots/whole_body/swing_foot.hpp"
#include "saltus/robots/whole_body/swing_orientation.hpp"

namespace saltus::robots::walking {
namespace {

SoleFrame frame_of(const DynamicsModel::SoleMotion& sole) {
  return {sole.pose.translation(), sole.pose.linear()};
}

// Planners assume level soles; whole-body controllers use the actual ones. Rotation from level axes
// to the axes of the sole.
Mat<double, 3, 3> from_level(const SoleFrame& sole) {
  return sole.rotation.transpose() * levelled(sole).rotation;
}
// Rotates force and torque of this foot.
void rotate(const Mat<double, 3, 3>& rotation, Side foot, Vec<double, 12>& wrenches) {
  for (const int part : {0, 3}) {
    auto vector = wrenches.segment<3>((foot == Side::left ? 0 : 6) + part);
    vector = (rotation * vector).eval();
  }
}

// Rate at which the base follows the mean heading of the feet, 1/s, and the largest angle between
// them that it follows, rad.
constexpr double turning_rate = 4.0, most_turned = 0.2;

// Smallest inclination of the ground that the swing foot follows, rad. A sole may tilt by less on
// level ground.
constexpr double least_inclination = 0.015;

// Normal of the ground below a sole that carries the robot.
Vec<double, 3> ground_normal(const DynamicsModel::SoleMotion& sole) {
  const Vec<double, 3> normal = sole.pose.linear().col(2);
  return normal[2] < std::cos(least_inclination) ? normal : Vec<double, 3>::UnitZ();
}

// The integer ratio of `whole` to `part`.
long multiple(const char* name, double whole, double part) {
  const double ratio = whole / part;
  if (!(ratio > 0.5) || !(std::abs(ratio - std::round(ratio)) <= 1e-6 * ratio))
    throw DefinitionError(fmt::format(
        "balance controller: the {} of {} s must be a multiple of {} s", name, whole, part));
  return std::lround(ratio);
}

BalanceController::Parts checked(BalanceController::Parts parts) {
  if (parts.corrected) parts.model = std::move(parts.corrected);
  if (!parts.estimator || !parts.model || !parts.whole_body || !parts.steps || !parts.wrenches)
    throw DefinitionError("balance controller: a part is missing");
  return parts;
}

}  // namespace

BalanceController::BalanceController(BalanceController::Parts parts,
                                     BalanceController::Options options)
    : corrected_(parts.corrected.get()),
      parts_(checked(std::move(parts))),
      options_(std::move(options)),
      per_control_(multiple("control period", options_.control_period, options_.period)),
      per_plan_(per_control_ *
                multiple("planner period", options_.planner_period, options_.control_period)),
      planner_(options_.scene, options_.contacts, std::move(parts_.steps),
               std::move(parts_.wrenches), options_.planner_period,
               options_.support.is_estimated ? BalancePlanner::LandingTime::doubted
                                             : BalancePlanner::LandingTime::when_felt),
      contact_(options_.contact),
      swing_(std::make_unique<SwingFoot>(options_.swing)),
      orientation_(std::make_unique<SwingOrientation>(options_.swing)),
      stance_{std::make_unique<StanceFoot>(options_.stance),
              std::make_unique<StanceFoot>(options_.stance)},
      support_{make_support(Side::left), make_support(Side::right)},
      swing_side_(other(options_.scene.side)) {}

std::unique_ptr<FootSupport> BalanceController::make_support(Side side) const {
  return std::make_unique<FootSupport>(options_.scene.rectangle(side),
                                       model().mass() * standard_gravity, options_.support);
}

BalanceController::~BalanceController() = default;
BalanceController::BalanceController(BalanceController&&) noexcept = default;
BalanceController& BalanceController::operator=(BalanceController&&) noexcept = default;

void BalanceController::start(const WholeBodyState& state, const Robot::Readings& readings) {
  if (corrected_ != nullptr) corrected_->reset();
  parts_.estimator->start(state, readings);
  start_time_ = readings.time;
  parts_.whole_body->stand(state);
  parts_.model->update(estimate().state);
  swing_->hold(model().sole(swing_side_).pose);
  orientation_->hold(model().sole(swing_side_).pose.linear());
  stands(swing_side_) = options_.scene.two_feet;
  stands(other(swing_side_)) = true;
  for (const Side side : {Side::left, Side::right}) stance(side).stand(model().sole(side).pose);
  const Vec<double, 2> heading = feet_heading().normalized();
  forward_ = state.base.linear().transpose() * Vec<double, 3>(heading[0], heading[1], 0.0);
  tasks_.posture = state.q;
  applied_ = options_.scene.standing_wrenches(model().mass(), model().com());
  expected_ = applied_;
  for (const Side side : {Side::left, Side::right})
    support(side).stand(applied_[side == Side::left ? 2 : 8]);
  commands_ = {};
  commands_.torques = VectorXd::Zero(state.q.size());
  if (parts_.drives) {
    parts_.drives->start(state.q);
    commands_ = parts_.drives->commands();
  }
  updates_ = 0;
}

const Robot::Commands& BalanceController::update(const Robot::Readings& readings) {
  const double t = readings.time - start_time_;
  update_ = {};
  update_.time = readings.time;
  update_.has_controlled = updates_ % per_control_ == 0;
  update_.has_planned = updates_ % per_plan_ == 0;
  ++updates_;
  {
    CpuTime watch(statistics_.control_seconds);
    parts_.estimator->update(readings);
    if (update_.has_controlled) parts_.model->update(estimate().state);
  }
  if (update_.has_planned) {
    plan(t);
  } else {
    find_contact(t);
    planner_.note_contacts();
  }
  if (update_.has_controlled) control(t);
  return commands_;
}

BalancePlanner::Estimate BalanceController::centroidal_estimate() const {
  BalancePlanner::Estimate e;
  const DynamicsModel::SoleMotion &left = model().sole(Side::left),
                                  &right = model().sole(Side::right);
  e.gamma << model().com(), model().com_velocity(), model().angular_momentum();
  e.mass = model().mass();
  e.left_sole = frame_of(left);
  e.right_sole = frame_of(right);
  e.left_velocity = left.twist.tail<3>();
  e.right_velocity = right.twist.tail<3>();
  e.applied = applied_;
  e.contact_force = levelled(e.left_sole).rotation * applied_.segment<3>(0) +
                    levelled(e.right_sole).rotation * applied_.segment<3>(6);
  if (options_.support.is_estimated) {
    e.left_support = support(Side::left).area();
    e.right_support = support(Side::right).area();
  }
  return e;
}

// The planners plan for the described mass. The same motion of another mass needs wrenches and
// angular momentum in proportion.
void BalanceController::scale_to_described_mass(BalancePlanner::Estimate& e) const {
  const double scale = 1.0 / corrected_->mass_factor();
  e.mass *= scale;
  e.gamma.tail<3>() *= scale;
  e.applied *= scale;
  e.contact_force *= scale;
}

void BalanceController::plan(double t) {
  CpuTime watch(statistics_.plan_seconds);
  BalancePlanner::Estimate measured = centroidal_estimate();
  if (corrected_ != nullptr) scale_to_described_mass(measured);
  {
    statistics_.step_seconds = 0.0;
    CpuTime step_watch(statistics_.step_seconds);
    update_.step = planner_.plan_steps(t, measured);
  }
  const StepPlan::Step& step = planner_.step();
  if (update_.step.has_lifted) {
    swing_side_ = step.foot;
    stands(swing_side_) = false;
    swing_->hold(model().sole(swing_side_).pose);
    orientation_->hold(model().sole(swing_side_).pose.linear());
    ground_normal_ = ground_normal(model().sole(other(swing_side_)));
    support(swing_side_).stand(0.0);
    parts_.estimator->pin(other(swing_side_));
  }
  if (update_.step.has_target) {
    if (!swing_->is_under_way()) swing_->start(t, step.landing, walks());
    aim_swing(t, step);
    contact_.expect(step.earliest_landing, step.landing, swing_->place()[2]);
  }
  find_contact(t);
  if (planner_.step().heading) planner_.turn(yaw_momentum());
  planner_.plan_wrenches(t, measured);
}

// Finds out whether the swing foot has landed, or has lost the contact before it has carried load.
void BalanceController::find_contact(double t) {
  const DynamicsModel::SoleMotion& sole = model().sole(swing_side_);
  const double force = estimate().contact(swing_side_).wrench[2];
  contact_.update({t, force, sole.pose.translation()[2], -sole.twist[5]});
  if (planner_.is_stepping() && contact_.has_landed()) {
    stands(swing_side_) = true;
    stance(swing_side_).stand(sole.pose);
    support(swing_side_).stand(force, walks());
    planner_.land(t, sole.pose.translation());
    contact_.expect(t, t, sole.pose.translation()[2]);  // from now on only the force counts
    update_.has_landed = true;
  } else if (stands(swing_side_) && support(swing_side_).most_load() < infinity &&
             contact_.is_lost()) {
    stands(swing_side_) = false;
    swing_->resume(sole);
    planner_.take_back();
    update_.has_lost = true;
  }
}

void BalanceController::observe_mass() {
  CorrectedModel::GroundForce ground;
  for (const Side side : {Side::left, Side::right}) {
    if (!stands(side)) continue;
    const Vec<double, 6>& wrench = estimate().contact(side).wrench;
    const Vec<double, 3> force = wrench.head<3>();
    ground.force += force;
    ground.torque += wrench.tail<3>() + model().sole(side).pose.translation().cross(force);
  }
  corrected_->observe(options_.control_period, ground);
}

// The foot of a walking robot lands on the plane through the stance sole and parallel to it.
void BalanceController::aim_swing(double t, const StepPlan::Step& step) {
  const Vec<double, 3> level = Vec<double, 3>::UnitZ();
  const Vec<double, 3> normal = walks() ? ground_normal_ : level;
  Vec<double, 3> place = step.place;
  if (normal != level) {
    const Vec<double, 3> away = place - model().sole(other(swing_side_)).pose.translation();
    place[2] -= normal.head<2>().dot(away.head<2>()) / normal[2];
  }
  swing_->aim(step.landing, place);
  if (step.heading || normal != level) orientation_->aim(t, step.landing, normal, step.heading);
}

// Sum of the forward axes of both soles, in the plane.
Vec<double, 2> BalanceController::feet_heading() const {
  return model().sole(Side::left).pose.linear().col(0).head<2>() +
         model().sole(Side::right).pose.linear().col(0).head<2>();
}

// Angular momentum about the vertical, Nms. It turns the base towards the mean heading of the feet.
double BalanceController::yaw_momentum() const {
  const Eigen::Isometry3d& base = estimate().state.base;
  const Vec<double, 2> feet = feet_heading(), ahead = (base.linear() * forward_).head<2>();
  const double error = std::atan2(ahead[0] * feet[1] - ahead[1] * feet[0], ahead.dot(feet));
  const Vec<double, 2> arm = (model().com() - base.translation()).head<2>();
  const double inertia = model().mass_matrix()(2, 2) - model().mass() * arm.squaredNorm();
  return inertia * turning_rate * std::clamp(error, -most_turned, most_turned);
}

void BalanceController::control(double t) {
  CpuTime watch(statistics_.control_seconds);
  if (corrected_ != nullptr) observe_mass();
  tasks_.wrenches = planner_.wrenches(t);
  if (corrected_ != nullptr) tasks_.wrenches *= corrected_->mass_factor();
  tasks_.force = Vec<double, 3>(0.0, 0.0, -model().mass() * standard_gravity);
  tasks_.torque.setZero();
  const Mat<double, 3, 3> into_sole[] = {from_level(frame_of(model().sole(Side::left))),
                                         from_level(frame_of(model().sole(Side::right)))};
  for (const Side side : {Side::left, Side::right}) {
    const int first = side == Side::left ? 0 : 6;
    if (side == swing_side_ && !stands(swing_side_)) tasks_.wrenches.segment<6>(first).setZero();
    const DynamicsModel::SoleMotion& sole = model().sole(side);
    rotate(into_sole[side == Side::right], side, tasks_.wrenches);
    const Vec<double, 3> f = sole.pose.linear() * tasks_.wrenches.segment<3>(first);
    tasks_.force += f;
    tasks_.torque += sole.pose.linear() * tasks_.wrenches.segment<3>(first + 3) +
                     (sole.pose.translation() - model().com()).cross(f);
  }
  for (const Side side : {Side::left, Side::right}) {
    if (!stands(side)) continue;
    const DynamicsModel::SoleMotion& sole = model().sole(side);
    const Vec<double, 6>& wrench = estimate().contact(side).wrench;
    stance(side).advance(options_.control_period, sole, wrench[2]);
    Vec<double, 6> in_sole;
    in_sole << sole.pose.linear().transpose() * wrench.head<3>(),
        sole.pose.linear().transpose() * wrench.tail<3>();
    support(side).advance(options_.control_period, sole, in_sole,
                          expected_.segment<6>(side == Side::left ? 0 : 6));
    const Vec<double, 6>& turning = support(side).turning();
    if (!turning.isZero(0.0)) stance(side).follow_turn(sole.pose);
    Vec<double, 6>& hold = side == Side::left ? tasks_.left_hold : tasks_.right_hold;
    hold = stance(side).acceleration(sole) + turning;
  }
  if (options_.support.is_estimated) {
    tasks_.left_support = support(Side::left).area();
    tasks_.right_support = support(Side::right).area();
    tasks_.left_most_load = support(Side::left).most_load();
    tasks_.right_most_load = support(Side::right).most_load();
  }
  swing_->advance(t);
  tasks_.swing_acceleration = swing_->acceleration(model().sole(swing_side_));
  orientation_->advance(t);
  if (orientation_->is_aimed())
    tasks_.swing_acceleration.head<3>() = orientation_->acceleration(model().sole(swing_side_));
  const WholeBodyController::Command& command =
      parts_.whole_body->control(model(), estimate().state, tasks_);
  if (command.status != qp::QpStatus::optimal) ++statistics_.failures;
  if (command.torques_cut > 0) ++statistics_.cuts;
  statistics_.solves.add(command.solve_seconds);
  ++statistics_.calls;
  if (parts_.drives)
    commands_ = parts_.drives->update(command, estimate().state);
  else
    commands_.torques = command.torques;
  applied_ = expected_ = command.wrenches;
  for (const Side side : {Side::left, Side::right})
    rotate(into_sole[side == Side::right].transpose(), side, applied_);
}

}  // namespace saltus::robots::walking
