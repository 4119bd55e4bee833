// A robot in a physics engine: engine, drives, sensors, noise, delays and pushes. No other class
// contains simulated physics.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "saltus/ocp/pulse.hpp"
#include "saltus/robots/model/urdf_model.hpp"
#include "saltus/robots/walking/biped_settings.hpp"
#include "saltus/robots/whole_body/elastic_drives.hpp"
#include "saltus/robots/whole_body/joint_friction.hpp"
#include "saltus/robots/whole_body/measurement_noise.hpp"
#include "saltus/robots/whole_body/motors.hpp"
#include "saltus/robots/whole_body/plant.hpp"
#include "saltus/robots/whole_body/sensors.hpp"

namespace saltus::robots::walking {

/// The engine of these settings, DART or MuJoCo, with the ground next to the stance foot on this
/// side.
std::unique_ptr<Plant> make_engine(const FloatingRobot& body, const BipedSettings& settings,
                                   Side stance);
/// Frame at the point where a push acts. Throws InputError that names `push.link`.
FloatingRobot::Frame frame_of_push(const Push& push, const FloatingRobot& body,
                                   const UrdfModel& model);

/// The same settings give a bit-identical motion. After construction only the engine allocates.
class SimulatedRobot final : public Robot {
 public:
  /// `engine` takes steps of `settings.engine.step` and simulates `body`, whose drives it has.
  /// `control_period` (s) is the unit of the delay of commands. Throws DefinitionError if options
  /// of sensors, noise, motors, drives or delay are out of range.
  SimulatedRobot(std::unique_ptr<Plant> engine, const FloatingRobot& body,
                 const PlantSettings& settings, double control_period);

  /// Restarts in `state` at time zero.
  void reset(const WholeBodyState& state);
  /// Pushes the robot at the origin of a frame, by forces in N in world axes.
  void push_by(std::span<const Pulse> pulses, const FloatingRobot::Frame& at);

  const Robot::Readings& read() const override { return readings_; }
  void write(const Robot::Commands& commands) override;
  std::string wait() override;
  double period() const override { return step_; }
  std::string name() const override { return engine_->name(); }

  /// The engine. Its state has no measurement noise.
  const Plant& engine() const { return *engine_; }
  /// Torques of the motors during the last step, before friction, Nm.
  const VectorXd& motor_torques() const { return exerted_; }

 private:
  // A command, and the number of steps since it was given.
  struct Waiting {
    Robot::Commands commands;
    long age = 0;
  };

  void begin(const WholeBodyState& state);
  void measure();
  void drive(const Waiting& acting);

  std::unique_ptr<Plant> engine_;
  double step_;  // step of the engine, s
  long steps_ = 0;
  std::vector<Pulse> pulses_;
  FloatingRobot::Frame pushed_;
  bool has_motors_;
  Motors motors_;
  JointFriction friction_;
  ElasticDrives elastic_;
  VectorXd effort_;
  std::vector<JointDrive> drives_;
  VectorXd exerted_, joint_torques_;
  NoiseSource noise_;
  std::optional<Sensors> sensors_;  // empty: ideal sensors
  Waiting commanded_;
  std::vector<Waiting> waiting_;  // ring buffer: commands of the next steps
  std::size_t next_ = 0;          // index of the next step's commands
  bool is_first_ = true;          // no command yet
  WholeBodyEstimate measured_;
  Robot::Readings readings_;
};

}  // namespace saltus::robots::walking
