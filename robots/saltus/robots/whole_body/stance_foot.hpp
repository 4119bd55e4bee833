// Place that a standing foot keeps.
#pragma once

#include "saltus/robots/whole_body/device_options.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Holds a standing foot where it last carried load. While it carries load, its place follows the
/// measured pose, so that the ground under the foot determines it. A foot that has lost its load
/// returns to the place, and further down if it finds no ground there.
class StanceFoot {
 public:
  /// Creates the hold of a foot.
  explicit StanceFoot(const StanceFootOptions& options) : options_(options) {}

  /// Holds the foot at this pose.
  void stand(const Eigen::Isometry3d& pose);
  /// Holds this orientation and height from now on.
  void follow_turn(const Eigen::Isometry3d& pose) {
    place_.linear() = pose.linear();
    place_.translation()[2] = pose.translation()[2];
  }
  /// Advances by `dt` (s). `force` is the measured vertical force on the foot, N.
  void advance(double dt, const DynamicsModel::SoleMotion& sole, double force);
  /// d twist / dt (angular | linear) that returns the foot to its place, without damping.
  Vec<double, 6> acceleration(const DynamicsModel::SoleMotion& sole) const;

 private:
  Vec<double, 3> angle_to(const Eigen::Isometry3d& pose) const;

  StanceFootOptions options_;
  Eigen::Isometry3d place_ = Eigen::Isometry3d::Identity();
  double depth_ = 0.0;  // m, below the place
};

}  // namespace saltus::robots
