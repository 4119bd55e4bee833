#include "saltus/robots/dart/dart_skeleton.hpp"

#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/WeldJoint.hpp>

namespace saltus::dart_engine {

namespace dd = ::dart::dynamics;

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
      dd::RevoluteJoint::Properties joint;
      joint.mName = b.joint;
      joint.mAxis = b.axis;
      joint.mT_ParentBodyToJoint = b.origin;
      joint.mPositionLowerLimits[0] = b.position.lower;
      joint.mPositionUpperLimits[0] = b.position.upper;
      bodies.push_back(
          skeleton->createJointAndBodyNodePair<dd::RevoluteJoint>(bodies[b.parent], joint, body)
              .second);
      bodies.back()->getParentJoint()->setLimitEnforcement(true);
    }
    for (const UrdfBox& box : b.boxes) {
      dd::ShapeNode* shape =
          bodies.back()->createShapeNodeWith<dd::CollisionAspect, dd::DynamicsAspect>(
              std::make_shared<dd::BoxShape>(box.size));
      shape->setRelativeTransform(box.pose);
    }
  }
  skeleton->disableSelfCollisionCheck();
  return skeleton;
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

}  // namespace saltus::dart_engine
