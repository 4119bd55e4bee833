#include "saltus/robots/whole_body/contact_inertial_state.hpp"

#include "saltus/robots/model/capture_point.hpp"

namespace saltus::robots {
namespace {

using State = ContactInertialState;
const Vec<double, 3> gravity(0.0, 0.0, -standard_gravity);  // m/s^2

}  // namespace

Eigen::Isometry3d State::base() const {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = R;
  pose.translation() = p;
  return pose;
}

State State::displaced(const Error& error) const {
  const Vec<double, 3> turned = error.segment<3>(turn);
  const Mat<double, 3, 3> exp = exp_so3(turned), J = left_jacobian(turned);
  State s = *this;
  s.R = exp * R;
  s.v = exp * v + J * error.segment<3>(velocity);
  s.p = exp * p + J * error.segment<3>(position);
  for (const Side side : {Side::left, Side::right}) {
    s.sole(side).translation() =
        exp * sole(side).translation() + J * error.segment<3>(foot(foot_positions, side));
    s.sole(side).linear() = exp_so3(error.segment<3>(foot(foot_turns, side))) * sole(side).linear();
  }
  s.b_gyroscope += error.segment<3>(gyroscope_bias);
  s.b_accelerometer += error.segment<3>(accelerometer_bias);
  return s;
}

State::Error State::error_to(const State& truth) const {
  Error e;
  const Vec<double, 3> turned = log_so3(R * truth.R.transpose());
  const Mat<double, 3, 3> exp = R * truth.R.transpose();
  const Mat<double, 3, 3> J_inverse = left_jacobian(turned).inverse();
  e.segment<3>(turn) = turned;
  e.segment<3>(velocity) = J_inverse * (v - exp * truth.v);
  e.segment<3>(position) = J_inverse * (p - exp * truth.p);
  for (const Side side : {Side::left, Side::right}) {
    e.segment<3>(foot(foot_positions, side)) =
        J_inverse * (sole(side).translation() - exp * truth.sole(side).translation());
    e.segment<3>(foot(foot_turns, side)) =
        log_so3(sole(side).linear() * truth.sole(side).linear().transpose());
  }
  e.segment<3>(gyroscope_bias) = b_gyroscope - truth.b_gyroscope;
  e.segment<3>(accelerometer_bias) = b_accelerometer - truth.b_accelerometer;
  return e;
}

void State::move_on(const Vec<double, 3>& angular_velocity, const Vec<double, 3>& specific_force,
                    double dt) {
  const Vec<double, 3> turned = dt * (angular_velocity - b_gyroscope);
  const Mat<double, 3, 3> halfway = R * exp_so3(0.5 * turned);
  const Vec<double, 3> acceleration = halfway * (specific_force - b_accelerometer) + gravity;
  p += dt * (v + 0.5 * dt * acceleration);
  v += dt * acceleration;
  R = (Eigen::Quaterniond(R) * Eigen::Quaterniond(exp_so3(turned))).normalized().toRotationMatrix();
}

Mat<double, State::size, 6> State::reading_errors() const {
  Mat<double, size, 6> G = Mat<double, size, 6>::Zero();
  G.block<3, 3>(turn, 0) = R;
  G.block<3, 3>(velocity, 0) = skew<double>(v) * R;
  G.block<3, 3>(position, 0) = skew<double>(p) * R;
  for (const Side side : {Side::left, Side::right})
    G.block<3, 3>(foot(foot_positions, side), 0) = skew<double>(sole(side).translation()) * R;
  G.block<3, 3>(velocity, 3) = R;
  return G;
}

State::Matrix State::transition(double dt) const {
  Matrix F = Matrix::Identity();
  F.block<3, 3>(velocity, turn) = dt * skew<double>(gravity);
  F.block<3, 3>(position, turn) = 0.5 * dt * dt * skew<double>(gravity);
  F.block<3, 3>(position, velocity).diagonal().setConstant(dt);
  // An error of the bias acts like an error of the readings with opposite sign.
  F.block<size, 6>(0, gyroscope_bias) -= dt * reading_errors();
  return F;
}

Vec<double, 6> State::mismatch(Side side, const Eigen::Isometry3d& sole_in_base) const {
  Vec<double, 6> z;
  z.head<3>() = R * sole_in_base.translation() + p - sole(side).translation();
  z.tail<3>() = log_so3(R * sole_in_base.linear() * sole(side).linear().transpose());
  return z;
}

}  // namespace saltus::robots
