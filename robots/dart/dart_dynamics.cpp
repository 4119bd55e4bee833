#include "robots/dart/dart_dynamics.hpp"

#include "robots/capture_point.hpp"
#include "robots/dart/dart_skeleton.hpp"

namespace saltus {
namespace {

namespace dd = ::dart::dynamics;

class DartDynamics final : public DynamicsModel {
 public:
  explicit DartDynamics(const FloatingRobot& robot)
      : view_(dart_engine::make_skeleton(robot), robot),
        frames_{robot.left_sole, robot.right_sole},
        mass_(robot.total_mass),
        bodies_(static_cast<int>(robot.bodies.size())) {
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
    const MatrixXd& M = s.getMassMatrix();
    const VectorXd& h = s.getCoriolisAndGravityForces();
    const int n = static_cast<int>(bias_.size());
    for (int i = 0; i < n; ++i) {
      bias_[i] = h[view_.dof(i)];
      for (int j = 0; j < n; ++j) mass_matrix_(i, j) = M(view_.dof(i), view_.dof(j));
    }
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
  void update_sole(const FloatingRobot::Frame& frame, SoleMotion& sole) {
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
  int bodies_;
};

}  // namespace

std::unique_ptr<DynamicsModel> make_dart_dynamics(const FloatingRobot& robot) {
  return std::make_unique<DartDynamics>(robot);
}

}  // namespace saltus
