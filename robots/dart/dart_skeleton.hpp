// A FloatingRobot as a skeleton of DART. Only this folder sees DART.
#pragma once

#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/Skeleton.hpp>

#include "saltus/robots/whole_body/dynamics_model.hpp"

namespace dart::dynamics {
class FreeJoint;
}

namespace saltus::dart_engine {

/// Bodies with their collision boxes, a free joint for the base, revolute joints with limits.
/// Built directly: a loader of URDF files gives every massless frame 1 kg.
::dart::dynamics::SkeletonPtr make_skeleton(const FloatingRobot& robot);

/// What belongs together: bodies and degrees of freedom in the order of the FloatingRobot.
class SkeletonView {
 public:
  SkeletonView(::dart::dynamics::SkeletonPtr skeleton, const FloatingRobot& robot);

  ::dart::dynamics::BodyNode* body(int i) const { return bodies_[i]; }
  /// Index among DART's degrees of freedom of entry i of nu.
  int dof(int i) const { return dofs_[i]; }
  int joints() const { return static_cast<int>(dofs_.size()) - 6; }
  const ::dart::dynamics::SkeletonPtr& skeleton() const { return skeleton_; }

  void write(const WholeBodyState& state);
  void read(WholeBodyState& state) const;

 private:
  ::dart::dynamics::SkeletonPtr skeleton_;
  ::dart::dynamics::FreeJoint* base_;
  std::vector<::dart::dynamics::BodyNode*> bodies_;
  std::vector<int> dofs_;
};

}  // namespace saltus::dart_engine
