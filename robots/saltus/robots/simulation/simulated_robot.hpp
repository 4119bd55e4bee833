// A robot in a physics engine: engine, motors, sensors, noise, delays and pushes. No other class
// contains simulated physics.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "saltus/ocp/pulse.hpp"
#include "saltus/robots/walking/biped_settings.hpp"
#include "saltus/robots/whole_body/measurement_noise.hpp"
#include "saltus/robots/whole_body/motors.hpp"
#include "saltus/robots/whole_body/plant.hpp"
#include "saltus/robots/whole_body/sensors.hpp"

namespace saltus::robots::walking {

/// The same settings give a bit-identical motion. After construction only the engine allocates.
class SimulatedRobot final : public Robot {
 public:
  /// `engine` takes steps of `settings.engine.step`. `control_period` (s) is the unit of the torque
  /// delay. Throws DefinitionError if options of sensors, noise, motors or delay are out of
  /// range.
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

 private:
  void begin(const WholeBodyState& state);
  void measure();

  std::unique_ptr<Plant> engine_;
  double step_;  // step of the engine, s
  long steps_ = 0;
  std::vector<Pulse> pulses_;
  FloatingRobot::Frame pushed_;
  bool has_motors_;
  Motors motors_;
  NoiseSource noise_;
  std::optional<Sensors> sensors_;  // empty: ideal sensors
  VectorXd commanded_;
  std::vector<VectorXd> waiting_;  // ring buffer: torques of the next steps
  std::size_t next_ = 0;           // index of the next step's torques
  bool is_first_ = true;           // no command yet
  WholeBodyEstimate measured_;
  Robot::Readings readings_;
};

}  // namespace saltus::robots::walking
