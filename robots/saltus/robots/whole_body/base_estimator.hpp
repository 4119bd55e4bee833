// Where the base is and how it moves, from a gyroscope and an accelerometer in it and from the feet
// that stand: the contact-aided right-invariant extended Kalman filter on ContactInertialState.
//
// One foot is the pin: the world is where it stands, so that as long as it does it is the estimate
// of its place and heading that is exact, and the rest of the robot that is found relative to it.
// Place and heading in the world have no other meaning to a robot without eyes, and would drift.
#pragma once

#include "saltus/robots/whole_body/contact_inertial_state.hpp"

namespace saltus {

/// Of the filter that knows where the base is.
struct BaseEstimatorOptions {
  /// Several times those of data sheets: soles slip and rock, and what that looks like must not be
  /// taken for a tilt or a bias, which stay.
  double gyroscope_noise = 1e-3;      ///< rad/s per sqrt(Hz), each axis
  double accelerometer_noise = 0.03;  ///< m/s^2 per sqrt(Hz)
  double gyroscope_walk = 1e-5;       ///< of the bias, rad/s^2 per sqrt(Hz)
  double accelerometer_walk = 1e-4;   ///< m/s^3 per sqrt(Hz)
  /// How feet that stand move all the same; of the pin its roll and pitch only.
  double foot_walk = 0.02;       ///< m/s per sqrt(Hz)
  double foot_turn_walk = 0.05;  ///< rad/s per sqrt(Hz)
  /// The same of a sole that rests: whose centre of pressure is off its edges, about which alone it
  /// could turn. It is what tells a gyroscope's bias within a second.
  double resting_turn_walk = 5e-4;
  /// Of what the legs say beyond the noise of encoders: what bends and rocks.
  double leg_position_noise = 3e-4, leg_turn_noise = 1e-3;  ///< m, rad
  /// The ground is level: roll and pitch of a sole that stands are zero but for this, rad, each
  /// correction.
  double level_noise = 0.1;
  /// Standard deviations at the start.
  double turn = 0.01;                ///< rad, roll and pitch of the base
  double velocity = 0.02;            ///< m/s
  double position = 0.01;            ///< m
  double ground_slope = 5e-3;        ///< rad, of the ground below the pin
  double gyroscope_bias = 3e-3;      ///< rad/s
  double accelerometer_bias = 0.03;  ///< m/s^2
};

/// What the legs say of a sole: its pose in the frame of the base, and the covariance of
/// (position m | rotation rad), axes of the base.
struct SoleReading {
  bool stands = false;  ///< on the ground
  bool rests = false;   ///< flat: its centre of pressure lies inside
  Eigen::Isometry3d pose =
      Eigen::Isometry3d::Identity();  ///< of the contact frame in the base, by the joints
  Mat<double, 6, 6> covariance = Mat<double, 6, 6>::Zero();  ///< see above; m and rad
};

/// Nothing allocates.
class BaseEstimator {
 public:
  /// Position, rotation, velocity, biases, soles.
  using State = ContactInertialState;

  /// Nothing is known before start().
  explicit BaseEstimator(const BaseEstimatorOptions& options = {}) : options_(options) {}

  /// At rest, biases unknown; the pin stands where the state has it, the other foot in the air.
  void reset(const Eigen::Isometry3d& base, Side pin, const Eigen::Isometry3d& pin_sole);
  /// Another foot is the pin from now on; where the estimate has everything stays.
  void pin(Side side);
  /// Over dt (s) with the mean readings of gyroscope (rad/s) and accelerometer (m/s^2).
  void predict(const Vec<double, 3>& angular_velocity, const Vec<double, 3>& specific_force,
               double dt);
  /// A foot that begins to stand does so where the estimate has it; one that stands corrects the
  /// estimate.
  void correct(Side side, const SoleReading& reading);

  /// What is known.
  const State& state() const { return state_; }
  /// Of the right-invariant error; zero for feet in the air.
  const State::Matrix& covariance() const { return P_; }
  /// Whether the filter holds the foot for standing.
  bool stands(Side side) const { return stands_[side == Side::left ? 0 : 1]; }

 private:
  bool& stands(Side side) { return stands_[side == Side::left ? 0 : 1]; }
  void forget(Side side);
  void level(Side side);
  void plant(Side side, const SoleReading& reading);
  Mat<double, 6, 6> noise_of(const SoleReading& reading) const;

  BaseEstimatorOptions options_;
  State state_;
  State::Matrix P_ = State::Matrix::Zero(), transition_, product_;
  bool stands_[2] = {false, false}, rests_[2] = {false, false};
  Side pin_ = Side::left;
};

}  // namespace saltus
