// A FloatingRobot as a skeleton of DART. Only this folder sees DART.
#pragma once

#include <dart/collision/CollisionFilter.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <unordered_map>
#include <vector>

#include "saltus/robots/whole_body/dynamics_model.hpp"

namespace dart::dynamics {
class FreeJoint;
}

namespace saltus::dart_engine {

/// Bodies with their collision boxes, a free joint for the base, revolute joints with limits.
/// Built directly: a loader of URDF files gives every massless frame 1 kg.
::dart::dynamics::SkeletonPtr make_skeleton(const FloatingRobot& robot);

/// Bodies of a skeleton of `robot` get their capsules; which of them collide says CapsuleFilter.
void add_capsules(const FloatingRobot& robot, ::dart::dynamics::Skeleton& skeleton);

/// Capsules collide with each other where `FloatingRobot::apart` says so, and those of all bodies
/// but the feet with the ground. Boxes collide with the ground only.
class CapsuleFilter final : public ::dart::collision::CollisionFilter {
 public:
  /// Of the skeletons whose bodies have their capsules.
  CapsuleFilter(const FloatingRobot& robot, const ::dart::dynamics::Skeleton& skeleton);
  bool ignoresCollision(const ::dart::collision::CollisionObject* first,
                        const ::dart::collision::CollisionObject* second) const override;

 private:
  struct Kind {
    int body = -1;  // of the robot; -1: the ground
    bool is_capsule = false;
  };
  Kind kind_of(const ::dart::collision::CollisionObject* object) const;

  int bodies_;
  std::vector<bool> apart_;  // bodies x bodies
  std::vector<bool> is_foot_;
  std::unordered_map<const ::dart::dynamics::Frame*, Kind> kinds_;
};

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
