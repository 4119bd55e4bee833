#include "saltus/robots/whole_body/swing_foot.hpp"

#include <algorithm>

#include "saltus/robots/model/levelled.hpp"
#include "saltus/robots/whole_body/minimum_jerk.hpp"

namespace saltus::robots {
namespace {

// Speed of a foot that lands softly, if the ground is lower than expected, as a multiple of the
// speed of touching: the capture point does not wait.
constexpr double softly_late = 5.0;

// True if the quintic from a height (m, above the ground) to rest on the ground in T stays above
// the ground. In s = t / T it is (1 - s)^3 (h (1 - s)^2 + 5 b s (1 - s) + 10 c s^2).
bool stays_above(double h, double v, double a, double T) {
  const double b = h + 0.2 * T * v, c = h + 0.4 * T * v + 0.05 * T * T * a;
  return c >= 0.0 && (b >= 0.0 || 25.0 * b * b <= 40.0 * h * c);
}

// Longest time to the ground, at most T. If the landing is postponed while the foot descends, the
// quintic would dip below the ground. The foot then lands earlier and rests.
double time_down(double h, double v, double a, double T) {
  if (h <= 0.0 || stays_above(h, v, a, T)) return T;
  double down = 0.0;
  for (double step = 0.5 * T; step > shortest_motion; step *= 0.5)
    if (stays_above(h, v, a, down + step)) down += step;
  return down;
}

}  // namespace

void SwingFoot::hold(const Eigen::Isometry3d& pose) {
  under_way_ = false;
  position_ = place_ = pose.translation();
  velocity_.setZero();
  acceleration_.setZero();
  rotation_ = levelled({pose.translation(), pose.linear()}).rotation;
}

void SwingFoot::start(double t, double landing_time, bool walks) {
  under_way_ = true;
  clearance_ = walks ? options_.walking_clearance : options_.clearance;
  now_ = lift_off_ = t;
  landing_time_ = landing_time;
  apex_time_ = t + options_.apex * (landing_time - t);
}

void SwingFoot::resume(const DynamicsModel::SoleMotion& sole) {
  position_ = sole.pose.translation();
  velocity_ = sole.twist.tail<3>();
  acceleration_.setZero();
}

void SwingFoot::aim(double landing_time, const Vec<double, 3>& place) {
  // Otherwise a foot with an earlier landing time would descend late and fast.
  const double apex_time = lift_off_ + options_.apex * (landing_time - lift_off_);
  if (landing_time != landing_time_ && now_ < apex_time_) apex_time_ = apex_time;
  landing_time_ = landing_time;
  place_ = place;
}

void SwingFoot::advance(double t) {
  const double dt = t - now_;
  now_ = t;
  if (!under_way_ || dt <= 0.0) return;
  // The foot may still move forward when its descent has become slow, but not when it touches.
  for (int i = 0; i < 2; ++i)
    advance_minimum_jerk(place_[i], landing_time_ - 0.5 * options_.touching() - t, dt, position_[i],
                         velocity_[i], acceleration_[i]);
  if (t < apex_time_) {
    advance_minimum_jerk(place_[2] + clearance_, apex_time_ - t, dt, position_[2], velocity_[2],
                         acceleration_[2]);
  } else if (t < landing_time_) {
    descend(t, dt);
  } else {
    const double speed =
        options_.touch_speed > 0.0 ? softly_late * options_.touch_speed : options_.late_speed;
    position_[2] -= speed * dt;
    velocity_[2] = -speed;
    acceleration_[2] = 0.0;
  }
}

// Minimum jerk to a line that reaches the ground at the landing time with the speed of touching.
void SwingFoot::descend(double t, double dt) {
  const double speed = options_.touch_speed, left = landing_time_ - t;
  double height = position_[2] - place_[2] - speed * left, velocity = velocity_[2] + speed;
  const double down = time_down(height, velocity, acceleration_[2], left - options_.touching());
  advance_minimum_jerk(0.0, down, dt, height, velocity, acceleration_[2]);
  position_[2] = place_[2] + height + speed * (left - dt);
  velocity_[2] = velocity - speed;
}

Vec<double, 6> SwingFoot::acceleration(const DynamicsModel::SoleMotion& sole) const {
  const Eigen::AngleAxisd turn(rotation_ * sole.pose.linear().transpose());
  Vec<double, 6> result;
  result.head<3>() =
      options_.stiffness * turn.angle() * turn.axis() - options_.damping * sole.twist.head<3>();
  result.tail<3>() = acceleration_ + options_.stiffness * (position_ - sole.pose.translation()) +
                     options_.damping * (velocity_ - sole.twist.tail<3>());
  return result;
}

}  // namespace saltus::robots
