// Options of the sensors and motors of a simulated robot, and of the estimator.
//
// The defaults of the sensors are published values for iCub-class hardware; each comment names the
// source.
#pragma once

namespace saltus::robots {

/// Options of all sensors.
struct SensorOptions {
  /// Options of joint encoders.
  struct Encoder {
    double rate = 1000.0;  ///< Hz: the period of the motor boards (EMS) of iCub
    /// rad: optical encoder of 14400 counts on the motor behind a reducer of 100 (mechanicals and
    /// motorControl of iCubGenova02's legs in robotology/robots-configuration).
    double resolution = 4.4e-6;
    /// rad per sample: five counts. Not published; allows for ripple and backlash of the reducer.
    double noise = 2e-5;
    /// rad: the encoder on the joint (4096 counts per turn, same source) finds the zero position,
    /// with a standard deviation of 2 pi / 4096 / sqrt(12).
    double bias = 4.4e-4;
    double delay = 0.001;  ///< s: one period
  };

  /// Options of a gyroscope (rad/s) or accelerometer (m/s^2) with three axes. Readings are means
  /// over the period.
  struct Inertial {
    double rate;   ///< Hz
    double noise;  ///< density, per sqrt(Hz); the noise of a sample is density times sqrt(rate)
    double bias;   ///< standard deviation, constant during a run
    double delay;  ///< s
  };

  /// Options of force-torque sensors.
  struct ForceTorque {
    double rate = 100.0;  ///< Hz: acquisition every 10 ms (strain boards of iCubGenova02)
    /// N, Nm: resolution of the IIT FT45 after dropping three counts of noise.
    double force_noise = 0.25, torque_noise = 0.005;
    double force_bias = 2.0, torque_bias = 0.1;  ///< N, Nm: allows for drift since taring
    double delay = 0.001;                        ///< s: one period of the motor boards
  };

  Encoder encoder;  ///< joint encoders
  /// Xsens MTi-300: 0.01 deg/s per sqrt(Hz), bias repeatable to 0.2 deg/s; raw data up to 2 kHz,
  /// delay below 2 ms.
  Inertial gyroscope{1000.0, 1.75e-4, 3.5e-3, 0.001};
  /// Same device: 60 ug per sqrt(Hz), 0.03 m/s^2.
  Inertial accelerometer{1000.0, 5.9e-4, 0.03, 0.001};
  ForceTorque force_torque;  ///< sensors of the feet
  int seed = 1;              ///< seed of the noise; equal seeds give equal noise
};

/// Standard deviations of the noise, drawn anew in every step of the engine. Positions are not
/// filtered. Velocities have separate noise, which represents the error of an estimator. It is not
/// the noise of a difference of positions.
struct MeasurementNoise {
  double position = 0.0;          ///< m, of the base's origin, each axis
  double angle = 0.0;             ///< rad, of the base's orientation (each axis) and of every joint
  double velocity = 0.0;          ///< m/s, of the base's origin, each axis
  double angular_velocity = 0.0;  ///< rad/s, of the base (each axis) and of every joint
  double force = 0.0;             ///< relative, of every entry of the wrench of a foot
  int seed = 1;                   ///< The same seed gives the same numbers.

  /// True if no noise is added.
  bool is_zero() const {
    return position == 0.0 && angle == 0.0 && velocity == 0.0 && angular_velocity == 0.0 &&
           force == 0.0;
  }
};

/// First-order lag followed by a limit on the rate of change. All joints have the same options.
struct MotorOptions {
  double bandwidth = 0.0;    ///< cut-off frequency (-3 dB) of the lag, Hz; 0: no lag
  double torque_rate = 0.0;  ///< largest rate of change, Nm/s; 0: no limit

  /// True if torques act at once and as commanded.
  bool is_ideal() const { return bandwidth == 0.0 && torque_rate == 0.0; }
};

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using MeasurementNoise [[deprecated("use robots::MeasurementNoise; removed in 0.4")]] =
    robots::MeasurementNoise;
}  // namespace saltus
