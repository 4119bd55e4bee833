#include "problems/whole_body/tracking.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/rotation_vector.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus::whole_body {
namespace {

using robots::standard_gravity;
using robots::WholeBodyController;
using Robot = robots::Kinematics<joints, double>;

constexpr double period = 1e-3;      // s
constexpr double still = 1.0;        // time after a plan that ends at rest, s
constexpr int repetitions = 4;       // of a periodic plan
constexpr double difference = 5e-3;  // half-width of differences of the reference, s
constexpr double com_gain = 60.0, com_damping = 15.0, spin_damping = 10.0;  // 1/s^2, 1/s
constexpr double swing_gain = 400.0, swing_damping = 40.0;                  // 1/s^2, 1/s
constexpr double stance_gain = 100.0;                                       // 1/s^2
constexpr double pushed_by = 0.03;  // displacement of the capture point that starts a motion, m

class Tracker {
 public:
  Tracker(const Body& body, const robots::FloatingRobot& robot,
          std::span<const PlannedTask> motions, const TrackingOptions& options)
      : body_(body),
        robot_(robot),
        motions_(motions),
        options_(options),
        reference_(planned(motions.front())),
        weight_(body.tree.mass * standard_gravity),
        model_(robots::make_dart_dynamics(robot)),
        plant_(robots::make_dart_plant(robot, dart_options(options.ground))),
        controller_(robots::make_inverse_dynamics_controller(robot, cone(0), cone(1))) {
    robots::WholeBodyState start;
    const VectorXd q = reference_.state(reference_.begin()).tail<coordinates>(),
                   dq = reference_.rate(reference_.begin()).tail<coordinates>();
    const Robot at(body.tree, q, dq);
    start.base.linear() = at.body(0).rotation;
    start.base.translation() = at.body(0).position;
    start.base_twist << at.angular_velocity(0), dq.head<3>();
    start.q = q.tail<joints>();
    start.dq = dq.tail<joints>();
    plant_->reset(start);
    controller_->stand(start);
    model_->update(start);
    at_rest_ = capture_point();
  }

  Tracking run() {
    std::vector<std::string> columns{"t [s]"};
    for (const char* what : {"planned CoM", "CoM", "left sole", "right sole"})
      for (const char axis : {'x', 'y', 'z'})
        columns.push_back(std::string(what) + " " + axis + " [m]");
    columns.insert(columns.end(), {"left force [N]", "right force [N]"});
    for (std::size_t i = 1; i < robot_.bodies.size(); ++i)
      columns.push_back(robot_.bodies[i].joint + " torque [Nm]");
    for (const char* part : {"x [m]", "y [m]", "z [m]", "qw", "qx", "qy", "qz"})
      columns.push_back(std::string("base_") + part);
    for (std::size_t i = 1; i < robot_.bodies.size(); ++i)
      columns.push_back("q_" + robot_.bodies[i].joint + " [rad]");
    result_.table = CsvTable(columns);
    for (int k = 0; k * period < duration() && !result_.fell; ++k) step(k);
    result_.duration = reference_.end();
    return result_;
  }

 private:
  static robots::DartOptions dart_options(const robots::Plant::Ground& ground) {
    robots::DartOptions options;
    options.step = period;
    options.ground = ground;
    return options;
  }
  robots::ContactCone::Options cone(int foot) const {
    robots::ContactCone::Options options;
    options.foot = body_.feet[foot];
    options.friction = 0.5;
    options.normal_force = between(0.0, 4.0 * weight_);
    return options;
  }
  static robots::Side side_of(int foot) {
    return foot == 0 ? robots::Side::left : robots::Side::right;
  }
  static PlannedMotion planned(const PlannedTask& motion) {
    return PlannedMotion(*motion.plan, PlannedMotion::Start::at_rest, motion.task->periodic,
                         motion.task->stride);
  }
  const PlannedTask& motion() const { return motions_[static_cast<std::size_t>(result_.motion)]; }
  const Task& task() const { return *motion().task; }
  // Duration of the simulation, s.
  double duration() const {
    if (waits_) return options_.push.end() + still;
    if (task().periodic) return repetitions * reference_.length();
    return begin_ + reference_.end() + still;
  }
  Vec<double, 2> capture_point() const {
    const Vec<double, 3> com = model_->com();
    const double height = com[2] - model_->sole(robots::Side::left).pose.translation()[2];
    return (com + model_->com_velocity() / robots::pendulum_frequency(height)).head<2>();
  }
  // If a push has moved the capture point, starts the motion whose place is nearest to this point.
  void watch(double now) {
    const Vec<double, 2> point = capture_point();
    if ((point - at_rest_).norm() < pushed_by) return;
    const auto distance = [&](const PlannedTask& other) {
      return other.task->choice ? (other.task->choice->expected - point).norm() : infinity;
    };
    result_.motion =
        static_cast<int>(std::ranges::min_element(motions_, {}, distance) - motions_.begin());
    reference_ = planned(motion());
    begin_ = now;
    waits_ = false;
  }

  // Mode of the plan at t, and the contact of the foot in it.
  const Mode& mode_at(double t) const {
    const int done = motion().replanner != nullptr ? motion().replanner->phase() : 0;
    const int phase = done + reference_.phase(t);
    return task().modes[static_cast<std::size_t>(phase)];
  }
  const Contact* contact_of(const Mode& mode, int foot) const {
    for (const Contact& contact : mode.contacts)
      if (contact.frame.body == body_.soles[foot].body) return &contact;
    return nullptr;
  }

  void step(int k) {
    const double now = k * period;
    const robots::WholeBodyState state = plant_->state();
    model_->update(state);
    if (waits_) watch(now);
    const double t = waits_ ? reference_.begin() - 1.0 : now - begin_;  // of the plan, s
    Replanner* const replanner = motion().replanner;
    if (!waits_ && replanner != nullptr && t >= next_plan_ && !replanner->is_over(t)) {
      reference_ = replanner->plan_from(t, measured(t, state));
      next_plan_ = t + replanner->period() - 0.5 * period;
    }
    const VectorXd planned = reference_.state(t);
    const Mode& mode = mode_at(t);
    if (mode_ != nullptr && &mode != mode_) result_.begins.push_back(now);
    mode_ = &mode;
    const VectorXd input = reference_.input(t);
    const VectorXd dq = reference_.rate(t).tail<coordinates>();
    const Robot target(body_.tree, planned.tail<coordinates>().eval());

    WholeBodyController::Tasks tasks;
    const VectorXd rate =
        (reference_.state(t + difference) - reference_.state(t - difference)) / (2.0 * difference);
    const double mass = body_.tree.mass;
    tasks.force = mass * (rate.segment<3>(3) + com_gain * (planned.head<3>() - model_->com()) +
                          com_damping * (planned.segment<3>(3) - model_->com_velocity()));
    tasks.torque = mass * rate.segment<3>(6) +
                   spin_damping * (mass * planned.segment<3>(6) - model_->angular_momentum());
    // Damping acts on the measured rates: the posture leads by what it costs.
    const WholeBodyController::Gains gains;
    const VectorXd ahead =
        (reference_.rate(t + difference) - reference_.rate(t - difference)).tail<joints>() /
        (2.0 * difference);
    tasks.posture = planned.tail<joints>() +
                    gains.posture_damping / gains.posture * dq.tail<joints>() +
                    ahead / gains.posture;
    for (int foot = 0; foot < 2; ++foot) {
      const robots::Side side = side_of(foot);
      const robots::DynamicsModel::SoleMotion& sole = model_->sole(side);
      const Contact* contact = contact_of(mode, foot);
      touches_[foot] = contact != nullptr && (touches_[foot] || plant_->contact(side).touches);
      (foot == 0 ? tasks.left_stands : tasks.right_stands) = touches_[foot];
      const Mat<double, 3, 3> axes =
          contact != nullptr ? contact->place.rotation : target.rotation(body_.soles[foot]);
      const Vec<double, 3> moved(reference_.periods(t) * task().stride, 0.0, 0.0);
      Vec<double, 3> p = contact != nullptr ? (contact->place.position + moved).eval()
                                            : target.position(body_.soles[foot]);
      if (contact != nullptr && contact->chosen) p.head<2>() = planned.segment<2>(place_at);
      const Vec<double, 3> off = p - sole.pose.translation(),
                           tilt = robots::log_so3(axes * sole.pose.linear().transpose());
      if (touches_[foot]) {
        Vec<double, 6>& hold = foot == 0 ? tasks.left_hold : tasks.right_hold;
        hold << stance_gain * tilt, 0.0, 0.0, 0.0;
        const auto at = coordinates + 6 * (contact - mode.contacts.data());
        tasks.wrenches.segment<3>(6 * foot) = weight_ * axes.transpose() * input.segment<3>(at);
        tasks.wrenches.segment<3>(6 * foot + 3) =
            weight_ * axes.transpose() * input.segment<3>(at + 3);
        if (!stood_[foot]) stood_at_[foot] = sole.pose.translation();
        result_.slip = std::max(result_.slip, (sole.pose.translation() - stood_at_[foot]).norm());
        result_.feet = std::max(result_.feet, off.norm());
      } else {
        Vec<double, 6> wanted = Vec<double, 6>::Zero(), feed = Vec<double, 6>::Zero();
        if (contact == nullptr) {
          wanted = sole_twist(t, foot);
          feed = (sole_twist(t + difference, foot) - sole_twist(t - difference, foot)) /
                 (2.0 * difference);
        } else {
          wanted[5] = -0.1;  // m/s: the ground is later than planned
        }
        Vec<double, 6> error;
        error << tilt, off;
        tasks.swing_acceleration =
            feed + swing_gain * error + swing_damping * (wanted - sole.twist);
      }
    }
    std::ranges::copy(touches_, stood_);
    const WholeBodyController::Command& command = controller_->control(*model_, state, tasks);
    plant_->set_torques(command.torques);
    note(k, planned, command);
    const VectorXd force = options_.push.mean(now, now + period);
    if (!force.isZero(0.0))
      plant_->push(options_.pushed.body, force, options_.pushed.pose.translation());
    plant_->step();
  }

  // Measured state for the plans. A chosen place is that of the foot once the foot stands.
  VectorXd measured(double t, const robots::WholeBodyState& state) const {
    const Mat<double, 3, 3> base = state.base.linear();
    VectorXd x(task().size());
    x.head<9>() << model_->com(), model_->com_velocity(),
        model_->angular_momentum() / body_.tree.mass;
    x.tail<coordinates>() << state.base.translation(), std::atan2(base(2, 1), base(2, 2)),
        -std::asin(base(2, 0)), std::atan2(base(1, 0), base(0, 0)), state.q;
    const VectorXd expected = reference_.state(t);
    for (int i = 3; i < 6; ++i) {  // angles of the base without jumps of 2 pi
      double& angle = x.tail<coordinates>()[i];
      angle = expected.tail<coordinates>()[i] +
              std::remainder(angle - expected.tail<coordinates>()[i], 2.0 * std::numbers::pi);
    }
    if (!task().choice) return x;
    x.segment<2>(place_at) = expected.segment<2>(place_at);
    for (int foot = 0; foot < 2; ++foot) {
      const Contact* contact = contact_of(mode_at(t), foot);
      if (contact != nullptr && contact->chosen && touches_[foot])
        x.segment<2>(place_at) = model_->sole(side_of(foot)).pose.translation().head<2>();
    }
    return x;
  }

  Vec<double, 6> sole_twist(double t, int foot) const {
    const VectorXd q = reference_.state(t).tail<coordinates>(),
                   dq = reference_.rate(t).tail<coordinates>();
    const Robot at(body_.tree, q, dq);
    Vec<double, 6> twist;
    twist << at.angular_velocity(body_.soles[foot].body), at.velocity(body_.soles[foot]);
    return twist;
  }

  void note(int k, const VectorXd& planned, const WholeBodyController::Command& command) {
    const double distance = (model_->com() - planned.head<3>()).norm();
    result_.com = std::max(result_.com, distance);
    result_.com_at_end = distance;
    for (int i = 0; i < joints; ++i) {
      const robots::FloatingRobot::Body& at = robot_.bodies[static_cast<std::size_t>(i) + 1];
      const double torque = std::abs(command.torques[i]) / body_.strongest[i],
                   speed = std::abs(plant_->state().dq[i]) / body_.fastest[i];
      if (torque > result_.torque) result_.torque = torque, result_.torque_of = at.joint;
      if (speed > result_.speed) result_.speed = speed, result_.speed_of = at.joint;
    }
    Vec<double, 2> forces(plant_->contact(robots::Side::left).wrench[2],
                          plant_->contact(robots::Side::right).wrench[2]);
    recent_.push_back(forces);
    if (recent_.size() > 20) recent_.pop_front();
    Vec<double, 2> mean = Vec<double, 2>::Zero();
    for (const Vec<double, 2>& f : recent_) mean += f / static_cast<double>(recent_.size());
    result_.force = std::max(result_.force, mean.maxCoeff() / weight_);
    const double ground = std::min(model_->sole(robots::Side::left).pose.translation()[2],
                                   model_->sole(robots::Side::right).pose.translation()[2]);
    if (!plant_->state().is_finite() || model_->com()[2] - ground < 0.3 || distance > 0.2) {
      result_.fell = true;
      result_.fell_at = k * period;
    }
    if (k % 5 != 0) return;
    std::vector<double> row{k * period};
    const auto add = [&](const Vec<double, 3>& v) { row.insert(row.end(), v.begin(), v.end()); };
    add(planned.head<3>());
    add(model_->com());
    add(model_->sole(robots::Side::left).pose.translation());
    add(model_->sole(robots::Side::right).pose.translation());
    row.insert(row.end(), mean.begin(), mean.end());
    row.insert(row.end(), command.torques.begin(), command.torques.end());
    const robots::WholeBodyState state = plant_->state();
    const Eigen::Quaterniond turn(state.base.linear());
    add(state.base.translation());
    row.insert(row.end(), {turn.w(), turn.x(), turn.y(), turn.z()});
    row.insert(row.end(), state.q.begin(), state.q.end());
    result_.table.add_row(row);
  }

  const Body& body_;
  const robots::FloatingRobot& robot_;
  std::span<const PlannedTask> motions_;
  TrackingOptions options_;
  PlannedMotion reference_;
  const Mode* mode_ = nullptr;  // a step ago
  bool waits_ = options_.waits;
  double begin_ = 0.0;                // start of the motion, s
  double next_plan_ = 0.0;            // time of the next plan, s
  Vec<double, 2> at_rest_{0.0, 0.0};  // capture point at the start, m
  double weight_;
  std::unique_ptr<robots::DynamicsModel> model_;
  std::unique_ptr<robots::Plant> plant_;
  std::unique_ptr<WholeBodyController> controller_;
  bool touches_[2] = {true, true};
  bool stood_[2] = {false, false};  // a step ago
  Vec<double, 3> stood_at_[2];      // where that contact began, m
  std::deque<Vec<double, 2>> recent_;
  Tracking result_;
};

}  // namespace

Tracking track(const Body& body, const robots::FloatingRobot& robot,
               std::span<const PlannedTask> motions, const TrackingOptions& options) {
  if (motions.empty()) throw DefinitionError("track: there is no motion");
  return Tracker(body, robot, motions, options).run();
}

}  // namespace saltus::whole_body
