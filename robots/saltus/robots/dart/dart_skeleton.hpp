// Conversion of a FloatingRobot to a DART skeleton. Only this folder includes DART.
#pragma once

#include <dart/collision/CollisionFilter.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <unordered_map>
#include <vector>

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace dart::dynamics {
class FreeJoint;
}

namespace saltus::robots::dart_engine {

/// Creates bodies with collision boxes, a free joint for the base, and revolute joints with limits.
/// Built directly, because the URDF loader gives every massless frame 1 kg.
::dart::dynamics::SkeletonPtr make_skeleton(const FloatingRobot& robot);

/// Adds the capsules to the bodies of a skeleton of `robot`. CapsuleFilter selects the pairs that
/// collide.
void add_capsules(const FloatingRobot& robot, ::dart::dynamics::Skeleton& skeleton);

/// Collision filter. Capsules collide with each other as listed in `FloatingRobot::apart`, and with
/// the ground unless they belong to a foot. Boxes collide with the ground only.
class CapsuleFilter final : public ::dart::collision::CollisionFilter {
 public:
  /// The bodies of the skeleton must already have their capsules.
  CapsuleFilter(const FloatingRobot& robot, const ::dart::dynamics::Skeleton& skeleton);
  bool ignoresCollision(const ::dart::collision::CollisionObject* first,
                        const ::dart::collision::CollisionObject* second) const override;

 private:
  struct Kind {
    int body = -1;  // body of the robot; -1: the ground
    bool is_capsule = false;
  };
  Kind kind_of(const ::dart::collision::CollisionObject* object) const;

  int bodies_;
  std::vector<bool> apart_;  // bodies x bodies
  std::vector<bool> is_foot_;
  std::unordered_map<const ::dart::dynamics::Frame*, Kind> kinds_;
};

/// Maps bodies and degrees of freedom to the order of the FloatingRobot.
class SkeletonView {
 public:
  SkeletonView(::dart::dynamics::SkeletonPtr skeleton, const FloatingRobot& robot);

  ::dart::dynamics::BodyNode* body(int i) const { return bodies_[i]; }
  /// Index in DART of the degree of freedom for entry i of nu.
  int dof(int i) const { return dofs_[i]; }
  int joints() const { return static_cast<int>(dofs_.size()) - 6; }
  const ::dart::dynamics::SkeletonPtr& skeleton() const { return skeleton_; }

  void write(const WholeBodyState& state);
  void read(WholeBodyState& state) const;
  /// Sets the inertias of the rotors of all joints, kg m^2. make_skeleton() created the skeleton.
  void set_rotor_inertias(const VectorXd& inertias);

 private:
  ::dart::dynamics::SkeletonPtr skeleton_;
  ::dart::dynamics::FreeJoint* base_;
  std::vector<::dart::dynamics::BodyNode*> bodies_;
  std::vector<int> dofs_;
};

}  // namespace saltus::robots::dart_engine
