#include "saltus/robots/dart/dart_plant.hpp"

#include "saltus/robots/dart/dart_skeleton.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/contact_wrench.hpp"

namespace saltus::robots {
namespace {

namespace dd = ::dart::dynamics;

class DartDynamics final : public DynamicsModel {
 public:
  explicit DartDynamics(const FloatingRobot& robot)
      : view_(dart_engine::make_skeleton(robot), robot),
        frames_{robot.left_sole, robot.right_sole},
        mass_(robot.total_mass),
        links_(robot.bodies),
        bodies_(static_cast<int>(robot.bodies.size())),
        composite_(robot.bodies.size()),
        axis_(robot.bodies.size()) {
    view_.skeleton()->setGravity({0.0, 0.0, -standard_gravity});
    const int n = 6 + view_.joints();
    mass_matrix_.resize(n, n);
    bias_.resize(n);
    left_.jacobian.resize(6, n);
    right_.jacobian.resize(6, n);
  }

  int joints() const override { return view_.joints(); }
  double mass() const override { return mass_; }

  void update(const WholeBodyState& state) override {
    view_.write(state);
    const dd::Skeleton& s = *view_.skeleton();
    const VectorXd& h = s.getCoriolisAndGravityForces();
    const int n = static_cast<int>(bias_.size());
    for (int i = 0; i < n; ++i) bias_[i] = h[view_.dof(i)];
    update_mass_matrix();
    update_sole(frames_[0], left_);
    update_sole(frames_[1], right_);
    com_ = s.getCOM();
    com_velocity_ = s.getCOMLinearVelocity();
    momentum_.setZero();
    for (int i = 0; i < bodies_; ++i) {
      const dd::BodyNode* b = view_.body(i);
      const Mat<double, 3, 3> R = b->getWorldTransform().linear();
      momentum_ += R * (b->getInertia().getMoment() * (R.transpose() * b->getAngularVelocity()));
      momentum_ +=
          b->getMass() * (b->getCOM() - com_).cross(b->getCOMLinearVelocity() - com_velocity_);
    }
  }

 private:
  // Composite rigid body algorithm (Featherstone, Rigid Body Dynamics Algorithms, 2008, 6.2), about
  // the origin of the base in world axes, (angular | linear). The implementation of DART takes ten
  // times as long: it propagates a unit acceleration of every joint through the whole tree.
  void update_mass_matrix() {
    const Eigen::Isometry3d& base = view_.body(0)->getWorldTransform();
    for (int i = 0; i < bodies_; ++i) {
      const FloatingRobot::Body& link = links_[i];
      const Eigen::Isometry3d& pose = view_.body(i)->getWorldTransform();
      const Mat<double, 3, 3> R = pose.linear();
      const Mat<double, 3, 3> arm = link.mass * skew<double>(pose * link.com - base.translation());
      Mat<double, 6, 6>& I = composite_[i];
      I.topLeftCorner<3, 3>() = R * link.inertia * R.transpose();
      if (link.mass > 0.0) I.topLeftCorner<3, 3>() -= arm * arm / link.mass;
      I.topRightCorner<3, 3>() = arm;
      I.bottomLeftCorner<3, 3>() = -arm;
      I.bottomRightCorner<3, 3>() = link.mass * Mat<double, 3, 3>::Identity();
      const Vec<double, 3> axis = R * link.axis;
      axis_[i] << axis, axis.cross(base.translation() - pose.translation());
    }
    for (int i = bodies_ - 1; i > 0; --i) composite_[links_[i].parent] += composite_[i];
    mass_matrix_.setZero();
    Mat<double, 6, 6> turn = Mat<double, 6, 6>::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = base.linear();
    mass_matrix_.topLeftCorner<6, 6>() = turn.transpose() * composite_[0] * turn;
    for (int i = 1; i < bodies_; ++i) {
      const Vec<double, 6> momentum = composite_[i] * axis_[i];  // per unit of joint speed
      const int row = 5 + i;
      for (int j = i; j > 0; j = links_[j].parent)
        mass_matrix_(row, 5 + j) = mass_matrix_(5 + j, row) = axis_[j].dot(momentum);
      mass_matrix_.col(row).head<6>() = turn.transpose() * momentum;
      mass_matrix_.row(row).head<6>() = mass_matrix_.col(row).head<6>().transpose();
      mass_matrix_(row, row) += links_[i].drive.rotor_inertia;
    }
  }

  void update_sole(const FloatingRobot::Frame& frame, DynamicsModel::SoleMotion& sole) {
    const dd::BodyNode* body = view_.body(frame.body);
    const Vec<double, 3> offset = frame.pose.translation();
    sole.pose = body->getWorldTransform() * frame.pose;
    const MatrixXd J = view_.skeleton()->getWorldJacobian(body, offset);
    const MatrixXd dJ = view_.skeleton()->getJacobianClassicDeriv(body, offset);
    for (int i = 0; i < sole.jacobian.cols(); ++i) sole.jacobian.col(i) = J.col(view_.dof(i));
    sole.twist = J * view_.skeleton()->getVelocities();
    sole.drift = dJ * view_.skeleton()->getVelocities();
  }

  dart_engine::SkeletonView view_;
  FloatingRobot::Frame frames_[2];
  double mass_;
  std::vector<FloatingRobot::Body> links_;
  int bodies_;
  std::vector<Mat<double, 6, 6>> composite_;  // inertia of each body with all its descendants
  std::vector<Vec<double, 6>> axis_;          // twist of each joint at unit speed
};

}  // namespace

std::unique_ptr<DynamicsModel> make_dart_dynamics(const FloatingRobot& robot) {
  return std::make_unique<DartDynamics>(robot);
}

}  // namespace saltus::robots
