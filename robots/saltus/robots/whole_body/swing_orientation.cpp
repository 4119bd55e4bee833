#include "saltus/robots/whole_body/swing_orientation.hpp"

#include <cmath>
#include <numbers>

#include "saltus/robots/whole_body/minimum_jerk.hpp"
#include "saltus/robots/whole_body/rotation_vector.hpp"

namespace saltus::robots {
namespace {

// Rotation vector of the shortest turn from the vertical to this direction.
Vec<double, 2> tilt_to(const Vec<double, 3>& normal) {
  const Vec<double, 2> axis(-normal[1], normal[0]);
  const double sine = axis.norm();
  return sine > 0.0 ? Vec<double, 2>(std::atan2(sine, normal[2]) / sine * axis) : axis;
}

Mat<double, 3, 3> tilt_of(const Vec<double, 3>& angles) {
  return exp_so3(Vec<double, 3>(angles[0], angles[1], 0.0));
}

}  // namespace

void SwingOrientation::hold(const Mat<double, 3, 3>& rotation) {
  is_aimed_ = false;
  angles_ << tilt_to(rotation.col(2)), 0.0;
  const Vec<double, 3> forward = tilt_of(angles_).transpose() * rotation.col(0);
  angles_[2] = std::atan2(forward[1], forward[0]);
  goal_ = angles_;
  rate_.setZero();
  acceleration_.setZero();
}

void SwingOrientation::aim(double t, double landing_time, const Vec<double, 3>& normal,
                           std::optional<double> heading) {
  if (!is_aimed_) now_ = t;
  is_aimed_ = true;
  // The foot may still turn when its descent has become slow, but not when it touches.
  landing_time_ = landing_time - 0.5 * options_.touching();
  goal_.head<2>() = tilt_to(normal);
  if (heading)
    goal_[2] = angles_[2] + std::remainder(*heading - angles_[2], 2.0 * std::numbers::pi);
}

void SwingOrientation::advance(double t) {
  const double dt = t - now_;
  now_ = t;
  if (is_aimed_ && dt > 0.0)
    advance_minimum_jerk(goal_, landing_time_ - t, dt, angles_, rate_, acceleration_);
}

Mat<double, 3, 3> SwingOrientation::reference() const {
  return tilt_of(angles_) * exp_so3(Vec<double, 3>(0.0, 0.0, angles_[2]));
}

// The tilt is small, so its rate and that of the yaw add up to the angular velocity.
Vec<double, 3> SwingOrientation::acceleration(const DynamicsModel::SoleMotion& sole) const {
  const Eigen::AngleAxisd turn(reference() * sole.pose.linear().transpose());
  return options_.stiffness * turn.angle() * turn.axis() +
         options_.damping * (rate_ - sole.twist.head<3>()) + acceleration_;
}

}  // namespace saltus::robots
