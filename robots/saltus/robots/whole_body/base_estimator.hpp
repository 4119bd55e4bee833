// Estimator of the pose and velocity of the base from gyroscope, accelerometer and the feet on the
// ground: the contact-aided right-invariant extended Kalman filter on ContactInertialState.
//
// One foot is the pin: it defines the world. While it stands, its position and heading are exact by
// definition, and the rest of the robot is estimated relative to it. Without cameras, absolute
// position and heading are not observable and would drift.
#pragma once

#include "saltus/robots/whole_body/contact_inertial_state.hpp"

namespace saltus::robots {

/// Options of BaseEstimator.
struct BaseEstimatorOptions {
  /// Noise of the inertial sensors. The defaults are several times the values of data sheets: soles
  /// slip and rock, and the filter must not mistake this for a tilt or a bias.
  double gyroscope_noise = 1e-3;      ///< rad/s per sqrt(Hz), each axis
  double accelerometer_noise = 0.03;  ///< m/s^2 per sqrt(Hz)
  double gyroscope_walk = 1e-5;       ///< random walk of the bias, rad/s^2 per sqrt(Hz)
  double accelerometer_walk = 1e-4;   ///< random walk of the bias, m/s^3 per sqrt(Hz)
  /// Random walk of feet on the ground. For the pin only roll and pitch.
  double foot_walk = 0.02;       ///< m/s per sqrt(Hz)
  double rocking_walk = 0.0;     ///< the same for the pin, while it stands on an edge
  double foot_turn_walk = 0.05;  ///< rad/s per sqrt(Hz)
  /// Random walk of the orientation of a sole at rest, which stands from the start with its centre
  /// of pressure away from the edges about which it could rotate. It makes the bias of the
  /// gyroscope observable within a second. A sole that has landed may turn on soft ground.
  double resting_turn_walk = 5e-4;
  /// Errors of leg kinematics other than encoder noise, such as bending and rocking.
  double leg_position_noise = 3e-4, leg_turn_noise = 1e-3;  ///< m, rad
  /// Standard deviations of the initial estimate.
  double turn = 0.01;                ///< rad, roll and pitch of the base
  double velocity = 0.02;            ///< m/s
  double position = 0.01;            ///< m
  double ground_slope = 5e-3;        ///< rad, slope of the ground below the pin
  double gyroscope_bias = 3e-3;      ///< rad/s
  double accelerometer_bias = 0.03;  ///< m/s^2
};

/// Sole pose by leg kinematics: pose in the frame of the base, and the covariance of (position m |
/// rotation rad), axes of the base.
struct SoleReading {
  bool stands = false;  ///< true if the foot is on the ground
  bool rests = false;   ///< true if the sole is flat: its centre of pressure lies inside
  Eigen::Isometry3d pose =
      Eigen::Isometry3d::Identity();  ///< contact frame in the base, from the joints
  Mat<double, 6, 6> covariance = Mat<double, 6, 6>::Zero();  ///< covariance, axes of the base; m
                                                             ///< and rad
};

/// Kalman filter of the base. Does not allocate.
class BaseEstimator {
 public:
  /// Position, rotation, velocity, biases, soles.
  using State = ContactInertialState;

  /// The estimate is undefined before reset().
  explicit BaseEstimator(const BaseEstimatorOptions& options = {}) : options_(options) {}

  /// Starts at rest with unknown biases. The pin stands at `pin_sole`, the other foot is in the
  /// air.
  void reset(const Eigen::Isometry3d& base, Side pin, const Eigen::Isometry3d& pin_sole);
  /// Pins another foot. The estimate of all positions stays the same.
  void pin(Side side);
  /// Propagates over dt (s) with the mean readings of gyroscope (rad/s) and accelerometer (m/s^2).
  void predict(const Vec<double, 3>& angular_velocity, const Vec<double, 3>& specific_force,
               double dt);
  /// Processes a sole reading. A foot that touches down is added at its estimated position. A foot
  /// that already stands corrects the estimate.
  void correct(Side side, const SoleReading& reading);

  /// Current estimate.
  const State& state() const { return state_; }
  /// Covariance of the right-invariant error; zero for feet in the air.
  const State::Matrix& covariance() const { return P_; }
  /// True if the filter treats the foot as standing.
  bool stands(Side side) const { return stands_[index(side)]; }

 private:
  static std::size_t index(Side side) { return side == Side::left ? 0 : 1; }
  bool& stands(Side side) { return stands_[index(side)]; }
  void forget(Side side);
  void plant(Side side, const SoleReading& reading);
  Mat<double, 6, 6> noise_of(const SoleReading& reading) const;

  BaseEstimatorOptions options_;
  State state_;
  State::Matrix P_ = State::Matrix::Zero(), transition_, product_;
  bool stands_[2] = {false, false}, rests_[2] = {false, false}, landed_[2] = {false, false};
  double time_ = 0.0;  // s, since reset()
  Side pin_ = Side::left;
};

}  // namespace saltus::robots
