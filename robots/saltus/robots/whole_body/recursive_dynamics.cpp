// Twists and wrenches are (angular | linear) in world axes. Those of composite bodies refer to the
// origin of the base. A joint with axis s through p has the twist (s, s x (b - p)) about the origin
// b of the base. With the inertia I_i of body i and its descendants, the mass matrix has the
// entries twist_i . I_i twist_j for ancestors j of i. The bias is the wrench that moves all bodies
// with dnu/dt = 0 against gravity, projected on the same twists.
#include "saltus/robots/whole_body/recursive_dynamics.hpp"

#include <vector>

#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/contact_wrench.hpp"

namespace saltus::robots {
namespace {

class RecursiveDynamics final : public DynamicsModel {
 public:
  explicit RecursiveDynamics(const FloatingRobot& robot)
      : robot_(robot), links_(robot.bodies.size()) {
    const int n = 6 + robot_.joints();
    mass_matrix_.setZero(n, n);
    bias_.setZero(n);
    left_.jacobian.setZero(6, n);
    right_.jacobian.setZero(6, n);
  }

  int joints() const override { return robot_.joints(); }
  double mass() const override { return robot_.total_mass; }

  void update(const WholeBodyState& state) override {
    move(state);
    gather();
    project();
    update_sole(robot_.left_sole, left_);
    update_sole(robot_.right_sole, right_);
  }

 private:
  // Motion of the origin of a body for dnu/dt = 0, and sums over the body and its descendants.
  struct Link {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    Vec<double, 3> axis, omega, v, alpha, a;
    Vec<double, 6> twist;  // of the joint at unit speed
    Mat<double, 6, 6> inertia;
    Vec<double, 6> wrench;  // that moves them
  };

  void move(const WholeBodyState& state) {
    Link& base = links_[0];
    base.pose = state.base;
    base.omega = state.base_twist.head<3>();
    base.v = state.base_twist.tail<3>();
    base.alpha.setZero();
    base.a = base.omega.cross(base.v);  // the components of nu are along rotating axes
    for (std::size_t i = 1; i < links_.size(); ++i) {
      const FloatingRobot::Body& body = robot_.bodies[i];
      const Link& parent = links_[static_cast<std::size_t>(body.parent)];
      Link& link = links_[i];
      const auto joint = static_cast<Eigen::Index>(i) - 1;
      link.pose = parent.pose * body.origin * Eigen::AngleAxisd(state.q[joint], body.axis);
      link.axis = link.pose.linear() * body.axis;
      const Vec<double, 3> turning = link.axis * state.dq[joint];
      const Vec<double, 3> r = link.pose.translation() - parent.pose.translation();
      link.omega = parent.omega + turning;
      link.alpha = parent.alpha + parent.omega.cross(turning);
      link.v = parent.v + parent.omega.cross(r);
      link.a = parent.a + parent.alpha.cross(r) + parent.omega.cross(parent.omega.cross(r));
      link.twist << link.axis, link.axis.cross(base.pose.translation() - link.pose.translation());
    }
  }

  // Inertias and wrenches of all bodies, then of composite bodies; centre of mass and momentum.
  void gather() {
    const Vec<double, 3> origin = links_[0].pose.translation();
    Vec<double, 3> linear = Vec<double, 3>::Zero(), angular = Vec<double, 3>::Zero();
    com_.setZero();
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const FloatingRobot::Body& body = robot_.bodies[i];
      Link& link = links_[i];
      const Mat<double, 3, 3> R = link.pose.linear();
      const Mat<double, 3, 3> I = R * body.inertia * R.transpose();
      const Vec<double, 3> r = R * body.com;  // from the origin of the body
      const Vec<double, 3> arm = link.pose.translation() + r - origin;
      const Vec<double, 3> v = link.v + link.omega.cross(r);
      const Vec<double, 3> a = link.a + link.alpha.cross(r) + link.omega.cross(link.omega.cross(r));
      const Vec<double, 3> force = body.mass * (a + Vec<double, 3>(0.0, 0.0, standard_gravity));
      const Vec<double, 3> spin = I * link.omega;
      link.wrench << I * link.alpha + link.omega.cross(spin) + arm.cross(force), force;
      const Mat<double, 3, 3> S = skew<double>(arm);
      link.inertia.topLeftCorner<3, 3>() = I - body.mass * S * S;
      link.inertia.topRightCorner<3, 3>() = body.mass * S;
      link.inertia.bottomLeftCorner<3, 3>() = -body.mass * S;
      link.inertia.bottomRightCorner<3, 3>() = body.mass * Mat<double, 3, 3>::Identity();
      com_ += body.mass * arm;
      linear += body.mass * v;
      angular += spin + body.mass * arm.cross(v);
    }
    for (std::size_t i = links_.size() - 1; i > 0; --i) {
      Link& parent = links_[static_cast<std::size_t>(robot_.bodies[i].parent)];
      parent.inertia += links_[i].inertia;
      parent.wrench += links_[i].wrench;
    }
    com_ /= mass();
    momentum_ = angular - com_.cross(linear);
    com_ += origin;
    com_velocity_ = linear / mass();
  }

  void project() {
    const Link& base = links_[0];
    Mat<double, 6, 6> turn = Mat<double, 6, 6>::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = base.pose.linear();
    mass_matrix_.setZero();
    mass_matrix_.topLeftCorner<6, 6>() = turn.transpose() * base.inertia * turn;
    bias_.head<6>() = turn.transpose() * base.wrench;
    for (std::size_t i = 1; i < links_.size(); ++i) {
      const Link& link = links_[i];
      const auto row = static_cast<Eigen::Index>(i) + 5;
      const Vec<double, 6> momentum = link.inertia * link.twist;  // per unit of joint speed
      for (std::size_t j = i; j > 0; j = static_cast<std::size_t>(robot_.bodies[j].parent)) {
        const auto column = static_cast<Eigen::Index>(j) + 5;
        mass_matrix_(row, column) = mass_matrix_(column, row) = links_[j].twist.dot(momentum);
      }
      const Vec<double, 6> with_base = turn.transpose() * momentum;
      mass_matrix_.col(row).head<6>() = with_base;
      mass_matrix_.row(row).head<6>() = with_base.transpose();
      mass_matrix_(row, row) += robot_.bodies[i].drive.rotor_inertia;
      bias_[row] = link.twist.dot(link.wrench);
    }
  }

  void update_sole(const FloatingRobot::Frame& frame, SoleMotion& sole) {
    const auto body = static_cast<std::size_t>(frame.body);
    const Link& link = links_[body];
    sole.pose = link.pose * frame.pose;
    const Vec<double, 3> p = sole.pose.translation();
    const Vec<double, 3> r = p - link.pose.translation();
    const Mat<double, 3, 3> R = links_[0].pose.linear();
    const Vec<double, 3> from_base = p - links_[0].pose.translation();
    sole.jacobian.setZero();
    sole.jacobian.block<3, 3>(0, 0) = sole.jacobian.block<3, 3>(3, 3) = R;
    for (int k = 0; k < 3; ++k) {
      const Vec<double, 3> axis = R.col(k);
      sole.jacobian.col(k).tail<3>() = axis.cross(from_base);
    }
    for (std::size_t j = body; j > 0; j = static_cast<std::size_t>(robot_.bodies[j].parent)) {
      const auto column = static_cast<Eigen::Index>(j) + 5;
      sole.jacobian.col(column).head<3>() = links_[j].axis;
      sole.jacobian.col(column).tail<3>() = links_[j].axis.cross(p - links_[j].pose.translation());
    }
    sole.twist << link.omega, link.v + link.omega.cross(r);
    sole.drift << link.alpha, link.a + link.alpha.cross(r) + link.omega.cross(link.omega.cross(r));
  }

  FloatingRobot robot_;
  std::vector<Link> links_;
};

}  // namespace

std::unique_ptr<DynamicsModel> make_recursive_dynamics(const FloatingRobot& robot) {
  return std::make_unique<RecursiveDynamics>(robot);
}

}  // namespace saltus::robots
