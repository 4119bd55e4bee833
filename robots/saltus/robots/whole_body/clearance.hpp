// How near do limbs come to each other, and how does that change with the joints?
//
// The distance d of two capsules is that of their segments less both radii, < 0 when they overlap.
// With n the unit vector from the second's closest point to the first's, and both points fixed to
// their bodies, dd/dt = n' (v_1 - v_2) = J dq. Its derivative is J d2q + drift, where drift holds
// the accelerations of the points at d2q = 0. That the closest points wander along the segments and
// that n turns is left out.
#pragma once

#include <vector>

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus {

/// Two capsules, and how they approach.
struct Approach {
  int first = -1, second = -1;         ///< of Clearance::members()
  double distance = infinity;          ///< m
  Vec<double, 3> on_first, on_second;  ///< closest points of the segments, m
  Vec<double, 3> normal;               ///< n; world axes like the points
  double speed = 0.0;                  ///< dd/dt, m/s
  double drift = 0.0;                  ///< m/s^2
  double keep = infinity;              ///< see Clearance::stand, m
};

/// Of the pairs of `FloatingRobot::apart` that are nearest.
class Clearance {
 public:
  /// A capsule that is watched.
  struct Member {
    int body = 0;       ///< of FloatingRobot::bodies
    LinkCapsule shape;  ///< in the body's frame
  };

  /// Keeps at most `most` approaches. Throws DefinitionError unless that is positive.
  Clearance(const FloatingRobot& robot, int most);

  /// In a posture in which the robot will stand: pairs that are nearer there than twice `margin`
  /// (m) are built so, and half of their distance is what they `keep` from now on. Allocates.
  void stand(const WholeBodyState& state, double margin);
  /// Keeps the pairs that would be nearest `ahead` seconds later at their present speed, nearest
  /// first; only those that are nearer than `range` (m). Does not allocate.
  void update(const WholeBodyState& state, double range = infinity, double ahead = 0.0) noexcept;
  /// How many pairs are near.
  int count() const { return count_; }
  /// Pair i, nearest first.
  const Approach& approach(int i) const { return nearest_[static_cast<std::size_t>(i)]; }
  /// J of approach i: one entry per joint.
  void jacobian(int i, Eigen::Ref<VectorXd> row) const noexcept;

  /// All capsules that are watched.
  const std::vector<Member>& members() const { return members_; }
  /// Of a member, in the world, after update().
  const Capsule& capsule(int member) const { return capsules_[static_cast<std::size_t>(member)]; }
  /// "l_hand and l_upper_leg"
  std::string names(const Approach& approach) const;

 private:
  struct Link {
    int parent;
    Eigen::Isometry3d origin;
    Vec<double, 3> axis;
  };
  // A body while the base rests: its joint's axis, its twist and that twist's derivative at d2q = 0
  // (of the origin), world axes.
  struct Motion {
    Eigen::Isometry3d pose;
    Vec<double, 3> axis, turn, speed, turn_change, speed_change;
  };

  void move(const WholeBodyState& state) noexcept;
  Approach approach_of(int first, int second) const noexcept;

  std::vector<Link> links_;
  std::vector<Motion> bodies_;
  std::vector<Member> members_;
  std::vector<Capsule> capsules_;           // of the members, in the world
  std::vector<double> reaches_;             // half a length and a radius
  std::vector<std::pair<int, int>> pairs_;  // of members
  std::vector<double> keeps_;               // of pairs_, m; empty until stand()
  std::vector<Approach> nearest_;
  std::vector<double> urgency_;  // their distances `ahead`
  int count_ = 0;
};

}  // namespace saltus
