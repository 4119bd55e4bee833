// Orientation of the swing foot of a robot that turns or walks on a slope, and the angular
// acceleration that tracks it.
#pragma once

#include <optional>

#include "saltus/robots/whole_body/device_options.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Minimum-jerk turn to an orientation at the landing, which may change during the swing. Without
/// aim() the foot has no reference, and SwingFoot keeps its sole level. World axes, rad, s.
class SwingOrientation {
 public:
  /// Creates the orientation of a foot without reference.
  explicit SwingOrientation(const SwingOptions& options = {}) : options_(options) {}

  /// Starts from this orientation, without reference.
  void hold(const Mat<double, 3, 3>& rotation);
  /// Sets the landing time (s), the normal of the ground there, and the yaw (rad), to which the
  /// foot turns the shorter way. Without a yaw it keeps its own.
  void aim(double t, double landing_time, const Vec<double, 3>& normal,
           std::optional<double> heading = std::nullopt);
  /// True if the foot has a reference.
  bool is_aimed() const { return is_aimed_; }

  /// Advances the reference to t.
  void advance(double t);
  /// Angular acceleration that tracks the reference from the measured motion, rad/s^2.
  Vec<double, 3> acceleration(const DynamicsModel::SoleMotion& sole) const;
  /// Reference orientation.
  Mat<double, 3, 3> reference() const;

 private:
  SwingOptions options_;
  bool is_aimed_ = false;
  double now_ = 0.0, landing_time_ = 0.0;
  // Rotation vector of the tilt (x, y), and yaw before this tilt.
  Vec<double, 3> angles_ = Vec<double, 3>::Zero(), goal_ = Vec<double, 3>::Zero(),
                 rate_ = Vec<double, 3>::Zero(), acceleration_ = Vec<double, 3>::Zero();
};

}  // namespace saltus::robots
