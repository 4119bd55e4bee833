// Trajectory of the swing foot and the acceleration that tracks it.
#pragma once

#include "saltus/robots/whole_body/device_options.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Minimum-jerk trajectory to a place and a landing time, both of which may change during the
/// swing. The sole stays level and lands at rest, or with the speed of the options. It lands early
/// if it would otherwise dip below the ground. World axes, m, s.
class SwingFoot {
 public:
  /// Creates a foot that is not swinging.
  explicit SwingFoot(const SwingOptions& options = {}) : options_(options) {}

  /// Holds this pose until start().
  void hold(const Eigen::Isometry3d& pose);
  /// Starts the swing at t, with the landing at landing_time, s. `walks`: it passes over steps.
  void start(double t, double landing_time, bool walks = false);
  /// Sets the target of the contact frame; its height is that of the ground.
  void aim(double landing_time, const Vec<double, 3>& place);
  /// Continues from the measured motion, towards the same place and landing time.
  void resume(const DynamicsModel::SoleMotion& sole);
  /// True if the foot is swinging.
  bool is_under_way() const { return under_way_; }

  /// Advances the reference to t. The remaining time counts from t, not from the previous call. The
  /// reference is therefore about one call ahead of the minimum-jerk trajectory (2 mm in mid-swing
  /// at 2 ms). Feet track with a lag, and without the lead they land harder.
  void advance(double t);
  /// d twist / dt (angular | linear) that tracks the reference from the measured motion.
  Vec<double, 6> acceleration(const DynamicsModel::SoleMotion& sole) const;
  /// Target of the contact frame, m.
  const Vec<double, 3>& place() const { return place_; }
  /// Reference position of the sole's origin, m.
  const Vec<double, 3>& reference() const { return position_; }

 private:
  void descend(double t, double dt);

  SwingOptions options_;
  bool under_way_ = false;
  double clearance_ = 0.0;  // of this swing, m
  double now_ = 0.0, lift_off_ = 0.0, apex_time_ = 0.0, landing_time_ = 0.0;
  Vec<double, 3> position_ = Vec<double, 3>::Zero(), velocity_ = Vec<double, 3>::Zero(),
                 acceleration_ = Vec<double, 3>::Zero(), place_ = Vec<double, 3>::Zero();
  Mat<double, 3, 3> rotation_ = Mat<double, 3, 3>::Identity();
};

}  // namespace saltus::robots
