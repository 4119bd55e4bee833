#include "saltus/robots/dart/dart_skeleton.hpp"

#include <dart/collision/CollisionObject.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/CapsuleShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <utility>

namespace saltus::robots::dart_engine {

namespace dd = ::dart::dynamics;

namespace {

// A revolute joint with the inertia of a rotor. In the articulated-body algorithm this inertia adds
// to the inertia about the axis alone, for forces and for impulses.
class GearedJoint final : public dd::RevoluteJoint {
 public:
  explicit GearedJoint(const Properties& properties) : RevoluteJoint(properties) {}
  void set_rotor_inertia(double inertia) { rotor_inertia_ = inertia; }  // kg m^2

 protected:
  dd::Joint* clone() const override {
    auto* joint = new GearedJoint(getRevoluteJointProperties());
    joint->rotor_inertia_ = rotor_inertia_;
    return joint;
  }
  void updateInvProjArtInertia(const Eigen::Matrix6d& inertia) override {
    RevoluteJoint::updateInvProjArtInertia(inertia);
    add_rotor(mInvProjArtInertia);
  }
  void updateInvProjArtInertiaImplicit(const Eigen::Matrix6d& inertia, double step) override {
    RevoluteJoint::updateInvProjArtInertiaImplicit(inertia, step);
    add_rotor(mInvProjArtInertiaImplicit);
  }

 private:
  void add_rotor(Matrix& inverse) const { inverse /= 1.0 + rotor_inertia_ * inverse(0, 0); }

  double rotor_inertia_ = 0.0;
};

}  // namespace

dd::SkeletonPtr make_skeleton(const FloatingRobot& robot) {
  dd::SkeletonPtr skeleton = dd::Skeleton::create(robot.name);
  std::vector<dd::BodyNode*> bodies;
  for (const FloatingRobot::Body& b : robot.bodies) {
    dd::BodyNode::AspectProperties body(b.name);
    body.mInertia = dd::Inertia(b.mass, b.com, b.inertia);
    if (b.parent < 0) {
      dd::FreeJoint::Properties joint;
      joint.mName = "base";
      bodies.push_back(
          skeleton->createJointAndBodyNodePair<dd::FreeJoint>(nullptr, joint, body).second);
    } else {
      GearedJoint::Properties joint;
      joint.mName = b.joint;
      joint.mAxis = b.axis;
      joint.mT_ParentBodyToJoint = b.origin;
      joint.mPositionLowerLimits[0] = b.position.lower;
      joint.mPositionUpperLimits[0] = b.position.upper;
      const auto [geared, moved] =
          skeleton->createJointAndBodyNodePair<GearedJoint>(bodies[b.parent], joint, body);
      geared->set_rotor_inertia(b.drive.rotor_inertia);
      geared->setLimitEnforcement(true);
      bodies.push_back(moved);
    }
    for (const UrdfModel::Box& box : b.boxes) {
      dd::ShapeNode* shape =
          bodies.back()->createShapeNodeWith<dd::CollisionAspect, dd::DynamicsAspect>(
              std::make_shared<dd::BoxShape>(box.size));
      shape->setRelativeTransform(box.pose);
    }
  }
  skeleton->disableSelfCollisionCheck();
  return skeleton;
}

void add_capsules(const FloatingRobot& robot, dd::Skeleton& skeleton) {
  for (const FloatingRobot::Body& b : robot.bodies)
    for (const RobotDescription::LinkCapsule& c : b.capsules) {
      const Vec<double, 3> along = c.capsule.to - c.capsule.from;
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // the axis of a DART capsule is z
      pose.translation() = c.capsule.middle();
      // DART has no capsule of zero length.
      dd::ShapePtr shape = std::make_shared<dd::SphereShape>(c.capsule.radius);
      if (!along.isZero(0.0)) {
        pose.linear() =
            Eigen::Quaterniond::FromTwoVectors(Vec<double, 3>::UnitZ(), along).toRotationMatrix();
        shape = std::make_shared<dd::CapsuleShape>(c.capsule.radius, along.norm());
      }
      skeleton.getBodyNode(b.name)
          ->createShapeNodeWith<dd::CollisionAspect, dd::DynamicsAspect>(shape)
          ->setRelativeTransform(pose);
    }
}

CapsuleFilter::CapsuleFilter(const FloatingRobot& robot, const dd::Skeleton& skeleton)
    : bodies_(static_cast<int>(robot.bodies.size())),
      apart_(robot.bodies.size() * robot.bodies.size()),
      is_foot_(robot.bodies.size()) {
  for (const auto& [first, second] : robot.apart)
    apart_[static_cast<std::size_t>(first * bodies_ + second)] =
        apart_[static_cast<std::size_t>(second * bodies_ + first)] = true;
  for (const FloatingRobot::Frame& sole : {robot.left_sole, robot.right_sole})
    is_foot_[static_cast<std::size_t>(sole.body)] = true;
  for (int i = 0; i < bodies_; ++i) {
    const dd::BodyNode* body = skeleton.getBodyNode(robot.bodies[static_cast<std::size_t>(i)].name);
    for (std::size_t s = 0; s < body->getNumShapeNodes(); ++s) {
      const dd::ShapeNode* shape = body->getShapeNode(s);
      kinds_[shape] = {i, !shape->getShape()->is<dd::BoxShape>()};
    }
  }
}

CapsuleFilter::Kind CapsuleFilter::kind_of(const ::dart::collision::CollisionObject* object) const {
  const auto found = kinds_.find(object->getShapeFrame());
  return found == kinds_.end() ? Kind{} : found->second;
}

bool CapsuleFilter::ignoresCollision(const ::dart::collision::CollisionObject* first,
                                     const ::dart::collision::CollisionObject* second) const {
  Kind a = kind_of(first), b = kind_of(second);
  if (a.body < 0) std::swap(a, b);
  if (b.body < 0) return a.body < 0 || (a.is_capsule && is_foot_[static_cast<std::size_t>(a.body)]);
  return !a.is_capsule || !b.is_capsule ||
         !apart_[static_cast<std::size_t>(a.body * bodies_ + b.body)];
}

SkeletonView::SkeletonView(dd::SkeletonPtr skeleton, const FloatingRobot& robot)
    : skeleton_(std::move(skeleton)),
      base_(static_cast<dd::FreeJoint*>(skeleton_->getRootJoint())) {
  for (int i = 0; i < 6; ++i) dofs_.push_back(static_cast<int>(base_->getIndexInSkeleton(i)));
  for (const FloatingRobot::Body& b : robot.bodies) {
    bodies_.push_back(skeleton_->getBodyNode(b.name));
    if (b.parent >= 0)
      dofs_.push_back(static_cast<int>(bodies_.back()->getParentJoint()->getIndexInSkeleton(0)));
  }
}

void SkeletonView::write(const WholeBodyState& state) {
  for (int i = 0; i < joints(); ++i) {
    skeleton_->setPosition(dofs_[6 + i], state.q[i]);
    skeleton_->setVelocity(dofs_[6 + i], state.dq[i]);
  }
  base_->setTransform(state.base);
  base_->setSpatialVelocity(state.base_twist, dd::Frame::World(), dd::Frame::World());
}

void SkeletonView::set_rotor_inertias(const VectorXd& inertias) {
  for (int i = 0; i < joints(); ++i) {
    dd::BodyNode* moved = bodies_[static_cast<std::size_t>(i) + 1];
    static_cast<GearedJoint*>(moved->getParentJoint())->set_rotor_inertia(inertias[i]);
    moved->dirtyArticulatedInertia();
  }
}

void SkeletonView::read(WholeBodyState& state) const {
  state.q.resize(joints());
  state.dq.resize(joints());
  for (int i = 0; i < joints(); ++i) {
    state.q[i] = skeleton_->getPosition(dofs_[6 + i]);
    state.dq[i] = skeleton_->getVelocity(dofs_[6 + i]);
  }
  state.base = bodies_[0]->getWorldTransform();
  state.base_twist = bodies_[0]->getSpatialVelocity(dd::Frame::World(), dd::Frame::World());
}

}  // namespace saltus::robots::dart_engine
