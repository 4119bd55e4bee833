// Equations of motion from the Jacobians of all bodies: slow, short, and without a simulator.
//
//   M = sum_i m_i Jc_i' Jc_i + Jw_i' I_i Jw_i
//   h = sum_i m_i Jc_i' (a_i + g e_z) + Jw_i' (I_i alpha_i + omega_i x I_i omega_i)
//
// Jc_i and Jw_i map nu of DynamicsModel to the velocity of the centre of mass of body i and to its
// angular velocity in world axes; a_i and alpha_i are its accelerations for dnu/dt = 0.
#pragma once

#include <vector>

#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus {

/// Does not allocate after construction.
class TreeDynamics final : public robots::DynamicsModel {
 public:
  explicit TreeDynamics(const robots::FloatingRobot& robot)
      : robot_(robot), links_(robot.bodies.size()), Jc_(3, columns()), Jw_(3, columns()) {
    mass_matrix_.resize(columns(), columns());
    bias_.resize(columns());
    left_.jacobian.resize(6, columns());
    right_.jacobian.resize(6, columns());
  }

  int joints() const override { return robot_.joints(); }
  double mass() const override { return robot_.total_mass; }

  void update(const robots::WholeBodyState& state) override {
    move(state);
    mass_matrix_.setZero();
    bias_.setZero();
    com_.setZero();
    com_velocity_.setZero();
    for (int i = 0; i <= joints(); ++i) {
      const robots::FloatingRobot::Body& body = robot_.bodies[i];
      const Vec<double, 3> c = links_[i].pose * body.com;
      const Mat<double, 3, 3> I = inertia(i);
      jacobian(i, c);
      const Vec<double, 3> force =
          body.mass * (acceleration(i, c) + Vec<double, 3>(0.0, 0.0, robots::standard_gravity));
      const Vec<double, 3> torque =
          I * links_[i].alpha + links_[i].omega.cross(I * links_[i].omega);
      mass_matrix_ += body.mass * Jc_.transpose().lazyProduct(Jc_);
      IJw_ = I.lazyProduct(Jw_);
      mass_matrix_ += Jw_.transpose().lazyProduct(IJw_);
      bias_ += Jc_.transpose().lazyProduct(force) + Jw_.transpose().lazyProduct(torque);
      com_ += body.mass / mass() * c;
      com_velocity_ += body.mass / mass() * velocity(i, c);
    }
    momentum_.setZero();
    for (int i = 0; i <= joints(); ++i) {
      const Vec<double, 3> c = links_[i].pose * robot_.bodies[i].com;
      momentum_ += inertia(i) * links_[i].omega +
                   robot_.bodies[i].mass * (c - com_).cross(velocity(i, c) - com_velocity_);
    }
    update_sole(robot_.left_sole, left_);
    update_sole(robot_.right_sole, right_);
  }

 private:
  // Motion of the origin of a body in world axes.
  struct Link {
    Eigen::Isometry3d pose;
    Vec<double, 3> axis, omega, v, alpha, a;
  };

  int columns() const { return 6 + robot_.joints(); }

  void move(const robots::WholeBodyState& state) {
    const Vec<double, 3> omega = state.base_twist.head<3>(), v = state.base_twist.tail<3>();
    links_[0] = {state.base,    Vec<double, 3>::Zero(), omega, v, Vec<double, 3>::Zero(),
                 omega.cross(v)};  // the components of nu are along rotating axes
    for (int i = 1; i <= joints(); ++i) {
      const robots::FloatingRobot::Body& body = robot_.bodies[i];
      const Link& parent = links_[body.parent];
      Link& link = links_[i];
      link.pose = parent.pose * body.origin * Eigen::AngleAxisd(state.q[i - 1], body.axis);
      link.axis = link.pose.linear() * body.axis;
      const Vec<double, 3> turning = link.axis * state.dq[i - 1];
      const Vec<double, 3> p = link.pose.translation();
      link.omega = parent.omega + turning;
      link.alpha = parent.alpha + parent.omega.cross(turning);
      link.v = velocity(body.parent, p);
      link.a = acceleration(body.parent, p);
    }
  }
  Vec<double, 3> velocity(int i, const Vec<double, 3>& point) const {
    return links_[i].v + links_[i].omega.cross(point - links_[i].pose.translation());
  }
  Vec<double, 3> acceleration(int i, const Vec<double, 3>& point) const {
    const Link& link = links_[i];
    const Vec<double, 3> r = point - link.pose.translation();
    return link.a + link.alpha.cross(r) + link.omega.cross(link.omega.cross(r));
  }
  Mat<double, 3, 3> inertia(int i) const {
    const Mat<double, 3, 3> R = links_[i].pose.linear();
    return R * robot_.bodies[i].inertia * R.transpose();
  }
  // Computes the Jacobian of a point of body i.
  void jacobian(int i, const Vec<double, 3>& point) {
    Jc_.setZero();
    Jw_.setZero();
    const Mat<double, 3, 3> R = links_[0].pose.linear();
    Jw_.leftCols<3>() = R;
    for (int k = 0; k < 3; ++k) Jc_.col(k) = R.col(k).cross(point - links_[0].pose.translation());
    Jc_.middleCols<3>(3) = R;
    for (int j = i; j > 0; j = robot_.bodies[j].parent) {
      Jw_.col(5 + j) = links_[j].axis;
      Jc_.col(5 + j) = links_[j].axis.cross(point - links_[j].pose.translation());
    }
  }
  void update_sole(const robots::FloatingRobot::Frame& frame,
                   robots::DynamicsModel::SoleMotion& sole) {
    sole.pose = links_[frame.body].pose * frame.pose;
    const Vec<double, 3> p = sole.pose.translation();
    jacobian(frame.body, p);
    sole.jacobian.topRows<3>() = Jw_;
    sole.jacobian.bottomRows<3>() = Jc_;
    sole.twist << links_[frame.body].omega, velocity(frame.body, p);
    sole.drift << links_[frame.body].alpha, acceleration(frame.body, p);
  }

  robots::FloatingRobot robot_;
  std::vector<Link> links_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> Jc_, Jw_, IJw_;
};

}  // namespace saltus
