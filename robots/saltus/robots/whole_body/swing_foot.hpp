// The trajectory of the foot that steps: where it should be, and the acceleration that brings it
// there.
#pragma once

#include "saltus/robots/whole_body/dynamics_model.hpp"

namespace saltus {

/// Of the swing foot's motion.
struct SwingOptions {
  double clearance = 0.03;                   ///< m, of the sole above the ground at mid-swing
  double stiffness = 400.0, damping = 40.0;  ///< 1/s^2, 1/s
  double late_speed = 0.3;  ///< m/s, downward, when the ground is not where it was expected
};

/// Minimum jerk towards a place and a landing time that may change while the foot is under way; the
/// sole stays level and lands with zero velocity, before its time if it would dip otherwise. World
/// axes, m, s.
class SwingFoot {
 public:
  /// Not under way.
  explicit SwingFoot(const SwingOptions& options = {}) : options_(options) {}

  /// Holds this pose until start().
  void hold(const Eigen::Isometry3d& pose);
  /// From the ground at t to the landing at landing_time, s.
  void start(double t, double landing_time);
  /// The place of the contact frame, its height that of the ground.
  void aim(double landing_time, const Vec<double, 3>& place);
  /// Whether it is in the air.
  bool is_under_way() const { return under_way_; }

  /// Moves the reference on to t, with the time to go from t on: about one call ahead of the
  /// minimum jerk (2 mm in mid-swing at 2 ms). Feet follow late, and without the lead they land
  /// harder.
  void advance(double t);
  /// d twist / dt (angular | linear) that follows the reference from the motion measured.
  Vec<double, 6> acceleration(const SoleMotion& sole) const;
  /// Of the sole's origin, m.
  const Vec<double, 3>& reference() const { return position_; }

 private:
  SwingOptions options_;
  bool under_way_ = false;
  double now_ = 0.0, lift_off_ = 0.0, apex_time_ = 0.0, landing_time_ = 0.0;
  Vec<double, 3> position_ = Vec<double, 3>::Zero(), velocity_ = Vec<double, 3>::Zero(),
                 acceleration_ = Vec<double, 3>::Zero(), place_ = Vec<double, 3>::Zero();
  Mat<double, 3, 3> rotation_ = Mat<double, 3, 3>::Identity();
};

}  // namespace saltus
