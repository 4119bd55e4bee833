// Distances between limbs and their derivatives with respect to the joints.
//
// The distance d of two capsules is that of their segments less both radii; it is negative if they
// overlap. Let n be the unit vector from the second's closest point to the first's, with both
// points fixed to their bodies. Then dd/dt = n' (v_1 - v_2) = J dq. Its derivative is J d2q +
// drift, where drift holds the accelerations of the points at d2q = 0. The motion of the closest
// points along the segments and the rotation of n are neglected.
#pragma once

#include <vector>

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Two capsules that are near each other, with distance and speed.
struct Approach {
  int first = -1, second = -1;         ///< indices in Clearance::members()
  double distance = infinity;          ///< m
  Vec<double, 3> on_first, on_second;  ///< closest points of the segments, m
  Vec<double, 3> normal;               ///< unit vector n, world axes like the points
  double speed = 0.0;                  ///< dd/dt, m/s
  double drift = 0.0;                  ///< m/s^2
  double keep = infinity;              ///< distance to keep, m; see Clearance::stand
};

/// Finds the nearest pairs of `FloatingRobot::apart`.
class Clearance {
 public:
  /// A monitored capsule.
  struct Member {
    int body = 0;                         ///< index in FloatingRobot::bodies
    RobotDescription::LinkCapsule shape;  ///< in the body's frame
  };

  /// Keeps at most `most` approaches. Throws DefinitionError unless `most` is positive.
  Clearance(const FloatingRobot& robot, int most);

  /// Sets a posture in which the robot will stand. For pairs that are nearer in it than twice
  /// `margin` (m), the distance to `keep` becomes half of that distance. Allocates.
  void stand(const WholeBodyState& state, double margin);
  /// Finds the pairs with the smallest distance extrapolated by `ahead` seconds at the present
  /// speed, nearest first, among those nearer than `range` (m). Does not allocate.
  void update(const WholeBodyState& state, double range = infinity, double ahead = 0.0) noexcept;
  /// Number of pairs found.
  int count() const { return count_; }
  /// Pair i, nearest first.
  const Approach& approach(int i) const { return nearest_[static_cast<std::size_t>(i)]; }
  /// Row J of approach i: one entry per joint.
  void jacobian(int i, Eigen::Ref<VectorXd> row) const noexcept;

  /// All monitored capsules.
  const std::vector<Member>& members() const { return members_; }
  /// Capsule of a member in the world, after the last update().
  const Capsule& capsule(int member) const { return capsules_[static_cast<std::size_t>(member)]; }
  /// Names of the two links, such as "l_hand and l_upper_leg".
  std::string names(const Approach& approach) const;

 private:
  struct Link {
    int parent;
    Eigen::Isometry3d origin;
    Vec<double, 3> axis;
  };
  // Motion of a body relative to a resting base: axis of its joint, its twist and the derivative of
  // the twist at d2q = 0 (of the origin), world axes.
  struct Motion {
    Eigen::Isometry3d pose;
    Vec<double, 3> axis, turn, speed, turn_change, speed_change;
  };

  void move(const WholeBodyState& state) noexcept;
  Approach approach_of(int first, int second) const noexcept;

  std::vector<Link> links_;
  std::vector<Motion> bodies_;
  std::vector<Member> members_;
  std::vector<Capsule> capsules_;  // capsules of the members, in the world
  // radius of a sphere around each member: half its length plus its radius
  std::vector<double> reaches_;
  std::vector<std::pair<int, int>> pairs_;  // pairs of members
  std::vector<double> keeps_;               // distances to keep of pairs_, m; empty until stand()
  std::vector<Approach> nearest_;
  std::vector<double> urgency_;  // extrapolated distances of the nearest pairs
  int count_ = 0;
};

}  // namespace saltus::robots
