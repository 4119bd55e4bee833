// Options of the sensors and motors of a simulated robot, of the estimator, and of the motion of
// the feet.
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

/// Options of the motion of the swing foot.
struct SwingOptions {
  double clearance = 0.03;  ///< m, height of the sole above the ground at mid-swing
  double stiffness = 400.0, damping = 40.0;  ///< 1/s^2, 1/s
  double late_speed = 0.3;  ///< m/s, downward, if the ground is lower than expected and the foot
                            ///< does not land softly
  double apex = 0.5;        ///< time of the largest height, as a fraction of the swing
  double walking_clearance = 0.035;  ///< m, the clearance while the robot walks, for steps of 2 cm
  /// The foot descends through the last `touch_height` (m) with a constant speed (m/s), so that it
  /// lands softly on ground that is higher than expected. 0: it lands at rest at the landing time.
  double touch_speed = 0.0, touch_height = 0.005;

  /// Duration of this last part, s. The foot moves only downwards in it.
  double touching() const { return touch_speed > 0.0 ? touch_height / touch_speed : 0.0; }
};

/// Options of the hold of a stance foot.
struct StanceFootOptions {
  double stiffness = 0.0;      ///< 1/s^2; 0: the foot is not held
  double loaded = 20.0;        ///< N, vertical force above which the foot carries load
  double follow = 0.1;         ///< s, time constant with which the place follows a loaded foot
  double search_speed = 0.1;   ///< m/s, downward, without load
  double search_depth = 0.03;  ///< m, largest distance below the place
  /// Largest errors that are corrected, m and rad. Beyond them the place follows the foot.
  double most_distance = 0.02, most_angle = 0.1;
};

/// Options of the estimate of the ground's support of a standing foot.
struct FootSupportOptions {
  bool is_estimated = false;  ///< False: every sole is supported as a whole.
  double lag = 0.01;          ///< s, of the wrenches
  double loaded = 0.1;        ///< weights; with less load the centre of pressure is uncertain
  double touched = 0.5;       ///< part of this load with which a sole that seeks the ground turns
  /// The supported area ends where the centre of pressure stays behind the commanded one. This
  /// needs a distance of more than `apart` (m), of which the integral over time exceeds `missed`
  /// (m s), and a sole that has turned by more than `tilted` (rad).
  double apart = 0.008, missed = 4e-4, tilted = 0.006;
  double settle = 0.2, forget = 0.6;  ///< s; a turn is forgotten, sooner by a sole that rests
  double regain = 0.02;               ///< m/s, growth of the area below a sole that rests
  /// A centre of pressure is on the rim if it is closer to it than `on_edge` (m) and the error of
  /// the measured moment (Nm) divided by the load.
  double on_edge = 0.004, moment_error = 0.7;
  /// rad/s^2, acceleration of a sole on its rim, which stance_damping limits to a speed; rad,
  /// largest tilt to which it leads.
  double flattening = 30.0, most_tilt = 0.15;
  /// A foot that has landed may be given the measured load times a factor and a first load
  /// (weights). This ends when it has carried `proven` weights.
  double more_load = 1.5, first_load = 0.3, proven = 0.45;
  /// The ground is soft if the foot has sunk so far, while it took the proven load, that it would
  /// sink by `soft` (m) under the weight. Then only the middle `soft_part` of its length and width
  /// carries load. The error of the centre of pressure decays with `soft_time` (s), because the
  /// sole turns, with a rate of at most `soft_rate` (rad/s).
  double soft = 1.5e-3, soft_part = 0.5, soft_time = 0.1, soft_rate = 3.0;
  /// 1/s: the rate is followed with `soft_damping` instead of `damping`, the gain of the whole-body
  /// controller.
  double soft_damping = 30.0, damping = 50.0;
  /// Part of the damping of the descent that is compensated while a foot takes load, and on soft
  /// ground. A damped foot would take its load late.
  double sink_relief = 0.7;
};

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using MeasurementNoise [[deprecated("use robots::MeasurementNoise; removed in 0.4")]] =
    robots::MeasurementNoise;
}  // namespace saltus
