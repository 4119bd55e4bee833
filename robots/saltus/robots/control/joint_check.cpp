#include "saltus/robots/control/joint_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus::robots::control {
namespace {

// Durations, s. The check waits until a swinging joint is at rest.
constexpr double rest = 0.2, longest_rest = 5.0, level_time = 0.1, motion = 0.5;
constexpr int levels = 5;
// A joint at rest moves by less than this, rad. Smaller motions are noise of its encoder.
constexpr double at_rest = 2e-3;

double smooth(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

}  // namespace

JointCheck::JointCheck(std::vector<LinkJoint> joints, const ControlOptions& options, Options check)
    : joints_(std::move(joints)), options_(options), check_(check), reports_(joints_.size()) {
  for (VectorXd* part : {&commands_.torques, &commands_.positions, &commands_.velocities,
                         &commands_.stiffness, &commands_.damping})
    *part = VectorXd::Zero(std::ssize(joints_));
}

void JointCheck::start(const SensorMessage& r) {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const double q = r.q[static_cast<Eigen::Index>(i)];
    reports_[i].offset = q - joints_[i].start;
    reports_[i].room = std::min(q - joints_[i].position.lower, joints_[i].position.upper - q);
  }
  joint_ = -1;
  next_joint(0.0);
  lowest_ = highest_ = place_ = r.q[0];
}

void JointCheck::next_joint(double time) {
  ++joint_;
  enter(Stage::rest, time);
  has_begun_ = false;
}

void JointCheck::enter(Stage stage, double time) {
  stage_ = stage;
  begin_ = time;
  level_ = 0;
  level_at_ = still_since_ = time;
}

void JointCheck::hold(double position) {
  const LinkJoint& joint = joints_[static_cast<std::size_t>(joint_)];
  commands_.positions[joint_] = position;
  commands_.stiffness[joint_] = options_.stiffness * joint.gain * joint.effort;
  commands_.damping[joint_] = options_.damping * joint.gain * joint.effort;
}

void JointCheck::release() {
  commands_.torques[joint_] = commands_.stiffness[joint_] = commands_.damping[joint_] = 0.0;
}

const Robot::Commands& JointCheck::update(double time, const SensorMessage& r) {
  ++updates_;
  gravity_ += r.specific_force.norm();
  turning_ += r.angular_velocity.norm();
  if (is_done()) return commands_;
  const LinkJoint& joint = joints_[static_cast<std::size_t>(joint_)];
  Report& report = reports_[static_cast<std::size_t>(joint_)];
  const double q = r.q[joint_], dq = r.dq[joint_];
  const double t = time - begin_;
  travelled_ += options_.period * dq;
  switch (stage_) {
    case Stage::rest:
      if (!has_begun_ || std::abs(q - place_) > at_rest) {
        has_begun_ = true;
        place_ = lowest_ = highest_ = q;
        fastest_ = 0.0;
        still_since_ = time;
      }
      lowest_ = std::min(lowest_, q);
      highest_ = std::max(highest_, q);
      fastest_ = std::max(fastest_, std::abs(dq));
      if (time - still_since_ < rest && t < longest_rest) break;
      place_ = q;
      direction_ = q - joint.position.lower < joint.position.upper - q ? 1.0 : -1.0;
      if (joint.position.lower == -infinity && joint.position.upper == infinity) direction_ = 1.0;
      angle_ = std::min(check_.angle,
                        0.5 * std::max(q - joint.position.lower, joint.position.upper - q));
      report.is_checked = true;
      has_begun_ = false;
      travelled_ = 0.0;
      enter(Stage::push, time);
      [[fallthrough]];
    case Stage::push: {
      // Motions beyond those at rest, twice over.
      const double noise = std::max(2.0 * (highest_ - lowest_), 1e-6);
      if (time - level_at_ >= level_time && !has_begun_) {
        ++level_;
        level_at_ = time;
      }
      const bool is_over = time - level_at_ >= 5.0 * level_time;
      if (!has_begun_ && (std::abs(q - place_) > noise || std::abs(dq) > 2.0 * fastest_ + 1e-4)) {
        has_begun_ = true;
        report.delay = time - level_at_;
        report.torque = joint.effort * check_.torque * (level_ + 1) / levels;
      }
      if (std::abs(q - place_) > check_.moved) {
        report.sign = (q - place_) * direction_ > 0.0 ? 1 : -1;
        report.velocity_ratio = travelled_ / (q - place_);
        release();
        enter(Stage::back, time);
      } else if (level_ >= levels || is_over) {
        release();
        next_joint(time);
      } else {
        commands_.torques[joint_] =
            direction_ * joint.effort * check_.torque * (level_ + 1) / levels;
      }
      break;
    }
    case Stage::back: {
      // Velocities with the wrong sign would turn the damper of the spring into a drive.
      const bool has_spring = report.sign > 0 && report.velocity_ratio > 0.0;
      if (has_spring) hold(place_);
      if (t < motion) break;
      if (!has_spring) {
        next_joint(time);
        break;
      }
      from_ = q;
      travelled_ = 0.0;
      enter(Stage::move, time);
      break;
    }
    case Stage::move:
      hold(place_ + direction_ * angle_ * smooth(t / motion));
      if (t >= motion) enter(Stage::stay, time);
      break;
    case Stage::stay:
      if (t < motion) break;
      report.followed = (q - from_) / (direction_ * angle_);
      report.velocity_ratio = travelled_ / (q - from_);
      enter(Stage::home, time);
      break;
    case Stage::home:
      hold(place_ + direction_ * angle_ * smooth(1.0 - t / motion));
      if (t >= motion) next_joint(time);
      break;
  }
  return commands_;
}

std::vector<JointCheck::Report> JointCheck::reports() const {
  std::vector<Report> all = reports_;
  for (Report& r : all) {
    if (!r.is_checked) {
      r.findings.emplace_back("the check ended before it");
      continue;
    }
    const auto note = [&r](bool is_wrong, std::string text) {
      if (is_wrong) r.findings.push_back(std::move(text));
    };
    note(std::abs(r.offset) > check_.offset,
         fmt::format("it is off by {:+.3f} rad in its known posture; correct the zero of its "
                     "encoder or `start`",
                     r.offset));
    note(r.room < 0.0, "it is beyond its limits; correct `limits` or the zero of its encoder");
    note(r.sign == 0, fmt::format("it moves by less than {:.3f} rad; check brake, motor and "
                                  "`torque`, or use a larger --push",
                                  check_.moved));
    note(r.sign < 0, "it moves against its torque; reverse the motor or the encoder");
    if (r.sign <= 0) continue;
    note(r.velocity_ratio > 0.0 && !(std::abs(r.followed - 1.0) < 0.3),
         fmt::format("it followed {:.0f} % of the motion; check `gain`, its load and its units",
                     100.0 * r.followed));
    note(!(std::abs(r.velocity_ratio - 1.0) < 0.2),
         fmt::format("its velocities are {:.2f} times the motion; check sign and unit",
                     r.velocity_ratio));
  }
  return all;
}

}  // namespace saltus::robots::control
