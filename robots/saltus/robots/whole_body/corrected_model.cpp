#include "saltus/robots/whole_body/corrected_model.hpp"

#include <algorithm>
#include <utility>

#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/contact_wrench.hpp"

namespace saltus::robots {
namespace {

// Inertia about a point of a mass at the vector r from it.
Mat<double, 3, 3> point_inertia(double mass, const Vec<double, 3>& r) {
  return mass * (r.squaredNorm() * Mat<double, 3, 3>::Identity() - r * r.transpose());
}

}  // namespace

CorrectedModel::CorrectedModel(std::unique_ptr<DynamicsModel> model, const FloatingRobot& robot,
                               const MassEstimateOptions& options)
    : described_(std::move(model)), options_(options), rotor_inertia_(robot.joints()) {
  const int n = described_->joints();
  for (int i = 0; i < n; ++i) rotor_inertia_[i] = robot.bodies[i + 1].drive.rotor_inertia;
  mass_matrix_.resize(6 + n, 6 + n);
  bias_.resize(6 + n);
  left_.jacobian.resize(6, 6 + n);
  right_.jacobian.resize(6, 6 + n);
  reset();
}

void CorrectedModel::reset() {
  factor_ = 1.0;
  shift_.setZero();
  quiet_ = 0.0;
  observed_ = 0.0;
  is_observing_ = false;
}

void CorrectedModel::update(const WholeBodyState& state) {
  described_->update(state);
  base_ = state.base.linear();
  left_ = described_->sole(Side::left);
  right_ = described_->sole(Side::right);
  mass_matrix_ = factor_ * described_->mass_matrix();
  mass_matrix_.diagonal().tail(joints()) += (1.0 - factor_) * rotor_inertia_;
  bias_ = factor_ * described_->bias();

  // Terms of a first moment that is fixed to the base, in its axes.
  const double m = mass();
  const Vec<double, 3> moment = m * shift_;
  const Vec<double, 3> from_base =
      base_.transpose() * (described_->com() - state.base.translation());
  const Mat<double, 3, 3> inertia =
      point_inertia(m, from_base + shift_) - point_inertia(m, from_base);
  mass_matrix_.topLeftCorner<3, 3>() += inertia;
  mass_matrix_.block<3, 3>(0, 3) += skew<double>(moment);
  mass_matrix_.block<3, 3>(3, 0) -= skew<double>(moment);
  const Vec<double, 3> w = base_.transpose() * state.base_twist.head<3>();
  const Vec<double, 3> v = base_.transpose() * state.base_twist.tail<3>();
  const Vec<double, 3> linear = w.cross(moment);
  const Vec<double, 3> angular = inertia * w + moment.cross(v);
  const Vec<double, 3> gravity = base_.transpose() * Vec<double, 3>(0.0, 0.0, -standard_gravity);
  bias_.head<3>() += w.cross(angular) + v.cross(linear) - moment.cross(gravity);
  bias_.segment<3>(3) += w.cross(linear);

  com_ = described_->com() + base_ * shift_;
  com_velocity_ = described_->com_velocity() + base_ * linear / m;
  momentum_ = factor_ * described_->angular_momentum() + base_ * angular +
              m * ((base_ * from_base).cross(described_->com_velocity()) -
                   (base_ * (from_base + shift_)).cross(com_velocity_));
}

bool CorrectedModel::is_quiet(double dt) {
  const bool moves = com_velocity_.norm() > options_.most_speed ||
                     momentum_.norm() > options_.most_momentum * mass();
  quiet_ = moves ? 0.0 : quiet_ + dt;
  return quiet_ >= options_.rest;
}

// Momentum of the described robot. The shift of the CoM changes it little.
CorrectedModel::Sums CorrectedModel::momentum() const {
  const Vec<double, 3> linear = described_->mass() * described_->com_velocity();
  const Vec<double, 3> angular =
      described_->angular_momentum() + (described_->com() - point_).cross(linear);
  return {linear[2], angular[0], angular[1]};
}

void CorrectedModel::observe(double dt, const GroundForce& ground) {
  if (!is_quiet(dt)) {
    is_observing_ = false;
    return;
  }
  if (!is_observing_) {
    is_observing_ = true;
    is_pending_ = false;
    point_ = com_;
    point_[2] = std::min(left_.pose.translation()[2], right_.pose.translation()[2]);
    recent_.setZero();
    since_ = 0.0;
  } else {
    recent_ -= factor_ * (momentum() - last_);
  }
  last_ = momentum();
  const Vec<double, 3> torque = ground.torque - point_.cross(ground.force);
  const Vec<double, 3> from = com_ - point_;
  const double weight = mass() * standard_gravity;
  recent_ += dt * Sums(ground.force[2] - weight, torque[0] - weight * from[1],
                       torque[1] + weight * from[0]);
  since_ += dt;
  if (since_ < options_.batch) return;
  if (is_pending_) correct(pending_ / since_, since_);
  pending_ = recent_;
  is_pending_ = true;
  recent_.setZero();
  since_ = 0.0;
}

// `residual`: mean over `dt` (s), N and Nm.
void CorrectedModel::correct(const Sums& residual, double dt) {
  observed_ += dt;
  const double share =
      std::min(1.0, dt / std::clamp(observed_, options_.shortest, options_.longest));
  const Vec<double, 3> from = com_ - point_;
  const double m = mass();
  factor_ = std::clamp(factor_ + share * residual[0] / (described_->mass() * standard_gravity),
                       1.0 - options_.most_mass, 1.0 + options_.most_mass);
  Vec<double, 2> com =
      m * from.head<2>() + share / standard_gravity * Vec<double, 2>(-residual[2], residual[1]);
  com /= mass();
  Vec<double, 3> shift = base_ * shift_;
  shift.head<2>() += com - from.head<2>();
  shift[2] = 0.0;
  shift.head<2>() = shift.head<2>().cwiseMax(-options_.most_offset).cwiseMin(options_.most_offset);
  shift_ = base_.transpose() * shift;
}

}  // namespace saltus::robots
