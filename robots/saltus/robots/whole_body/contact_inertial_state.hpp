// State of a base with inertial sensors and feet on the ground: its propagation, the growth of its
// errors, and the measurements by leg kinematics.
//
// After Hartley, Ghaffari, Eustice, Grizzle, "Contact-aided invariant extended Kalman filtering for
// robot state estimation", 2020, extended by the orientations of flat feet (Rotella, Bloesch,
// Righetti, Schaal, "State estimation for a humanoid robot", 2014). Errors are right-invariant:
// estimate = exp(error) truth, and estimate - truth for biases. The measurement Jacobian then does
// not depend on the estimate. Neither does the growth of errors, except for the biases.
#pragma once

#include "saltus/robots/model/foot.hpp"
#include "saltus/robots/whole_body/rotation_vector.hpp"

namespace saltus::robots {

/// Pose, velocity, feet and sensor biases. All quantities are in world axes, except the biases,
/// which are in the axes of the base.
struct ContactInertialState {
  static constexpr int size = 27;  ///< number of entries of an error
  /// Error of the state, in its tangent space.
  using Error = Vec<double, size>;
  /// Covariance or Jacobian of errors.
  using Matrix = Mat<double, size, size>;
  /// First index of each block of an error; for a foot use foot(first, side).
  enum : int {
    turn = 0,                // orientation of the base, rad
    velocity = 3,            // velocity of the origin of the base, m/s
    position = 6,            // position of the origin of the base, m
    foot_positions = 9,      // positions of the contact frames, left and right, m
    foot_turns = 15,         // orientations of the contact frames, left and right, rad
    gyroscope_bias = 21,     // rad/s
    accelerometer_bias = 24  // m/s^2
  };
  /// First index of the block of a foot, where the block of the left foot begins at `first`.
  static constexpr int foot(int first, Side side) { return side == Side::left ? first : first + 3; }

  Mat<double, 3, 3> R = Mat<double, 3, 3>::Identity();  ///< rotation of the base: base axes ->
                                                        ///< world axes
  Vec<double, 3> v = Vec<double, 3>::Zero();            ///< velocity of the base, m/s
  Vec<double, 3> p = Vec<double, 3>::Zero();            ///< position of the base, m
  Eigen::Isometry3d left_sole = Eigen::Isometry3d::Identity();   ///< contact frame in the world
  Eigen::Isometry3d right_sole = Eigen::Isometry3d::Identity();  ///< contact frame in the world
  Vec<double, 3> b_gyroscope = Vec<double, 3>::Zero();           ///< bias, rad/s
  Vec<double, 3> b_accelerometer = Vec<double, 3>::Zero();       ///< bias, m/s^2

  /// Contact frame of the foot on the given side.
  Eigen::Isometry3d& sole(Side side) { return side == Side::left ? left_sole : right_sole; }
  /// Contact frame of the foot on the given side.
  const Eigen::Isometry3d& sole(Side side) const {
    return side == Side::left ? left_sole : right_sole;
  }
  /// Pose of the base in the world.
  Eigen::Isometry3d base() const;

  /// exp(error) applied to this state; biases plus error.
  ContactInertialState displaced(const Error& error) const;
  /// The error for which truth.displaced(error) is this state.
  Error error_to(const ContactInertialState& truth) const;

  /// Propagates the state over dt (s) with the mean readings of gyroscope (rad/s) and accelerometer
  /// (specific force, m/s^2) in axes of the base. The feet do not move.
  void move_on(const Vec<double, 3>& angular_velocity, const Vec<double, 3>& specific_force,
               double dt);
  /// d error after / d error before, to first order in dt.
  Matrix transition(double dt) const;
  /// Rate of the error per unit error of the readings; columns (gyroscope | accelerometer).
  Mat<double, size, 6> reading_errors() const;

  /// Deviation (m | rad) between the sole pose by leg kinematics (in the base's frame) and the sole
  /// pose of the state. An error changes it by error(position) - error(foot position) and by
  /// error(turn) - error(foot turn).
  Vec<double, 6> mismatch(Side side, const Eigen::Isometry3d& sole_in_base) const;
};

}  // namespace saltus::robots
