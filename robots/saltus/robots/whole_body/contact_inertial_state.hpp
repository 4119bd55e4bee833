// The state of a base that feels its turning and its acceleration and stands on known feet: how it
// moves on, how errors of it grow, and what the legs say of them.
//
// After Hartley, Ghaffari, Eustice, Grizzle, "Contact-aided invariant extended Kalman filtering for
// robot state estimation", 2020, with the orientations of flat feet beside their places (Rotella,
// Bloesch, Righetti, Schaal, "State estimation for a humanoid robot", 2014). Errors are
// right-invariant: estimate = exp(error) truth, for biases estimate - truth. Then neither the rows
// of the measurement nor, but for the biases, the growth of errors depend on the estimate.
#pragma once

#include "saltus/robots/model/foot.hpp"
#include "saltus/robots/whole_body/rotation_vector.hpp"

namespace saltus {

/// Everything in the axes of the world, but for the biases: axes of the base.
struct ContactInertialState {
  static constexpr int size = 27;  ///< of an error: 27 numbers
  /// Of the state, in its tangent space.
  using Error = Vec<double, size>;
  /// Its covariance and Jacobians.
  using Matrix = Mat<double, size, size>;
  /// Where the entries of an error begin; a foot's by foot(first, side).
  enum : int {
    turn = 0,                // of the base, rad
    velocity = 3,            // of its origin, m/s
    position = 6,            // of the same, m
    foot_positions = 9,      // of the contact frames, left and right, m
    foot_turns = 15,         // of the same, rad
    gyroscope_bias = 21,     // rad/s
    accelerometer_bias = 24  // m/s^2
  };
  /// Place of a foot's three numbers, whose left ones begin at `first`.
  static constexpr int foot(int first, Side side) { return side == Side::left ? first : first + 3; }

  Mat<double, 3, 3> R = Mat<double, 3, 3>::Identity();  ///< of the base: its axes -> world axes
  Vec<double, 3> v = Vec<double, 3>::Zero();            ///< of the base, m/s
  Vec<double, 3> p = Vec<double, 3>::Zero();            ///< of the base, m
  Eigen::Isometry3d left_sole = Eigen::Isometry3d::Identity();   ///< contact frame in the world
  Eigen::Isometry3d right_sole = Eigen::Isometry3d::Identity();  ///< contact frame in the world
  Vec<double, 3> b_gyroscope = Vec<double, 3>::Zero();           ///< bias, rad/s
  Vec<double, 3> b_accelerometer = Vec<double, 3>::Zero();       ///< bias, m/s^2

  /// By its side.
  Eigen::Isometry3d& sole(Side side) { return side == Side::left ? left_sole : right_sole; }
  /// By its side.
  const Eigen::Isometry3d& sole(Side side) const {
    return side == Side::left ? left_sole : right_sole;
  }
  /// Its frame in the world.
  Eigen::Isometry3d base() const;

  /// exp(error) times this; biases plus error.
  ContactInertialState displaced(const Error& error) const;
  /// The error that displaces `truth` to this.
  Error error_to(const ContactInertialState& truth) const;

  /// Over dt (s) with the mean readings of gyroscope (rad/s) and accelerometer (specific force,
  /// m/s^2), axes of the base; the feet stay.
  void move_on(const Vec<double, 3>& angular_velocity, const Vec<double, 3>& specific_force,
               double dt);
  /// d error after / d error before, to first order in dt.
  Matrix transition(double dt) const;
  /// What an error of the readings does to the error in a unit of time, columns (gyroscope |
  /// accelerometer).
  Mat<double, size, 6> reading_errors() const;

  /// How far the sole that the legs show (pose in the base's frame) is from where the state has
  /// it: (m | rad). An error changes it by error(position) - error(foot position) and by
  /// error(turn) - error(foot turn).
  Vec<double, 6> mismatch(Side side, const Eigen::Isometry3d& sole_in_base) const;
};

}  // namespace saltus
