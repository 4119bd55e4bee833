// A controller behind the guards of RobotControl, and its adapter for a BalanceController.
#pragma once

#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/robots/control/protocol.hpp"
#include "saltus/robots/walking/balance_controller.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots::control {

/// Data of a joint for the guards. A linear joint has m and N instead of rad and Nm.
struct LinkJoint {
  std::string name;         ///< name, which identifies the robot
  double effort = 0.0;      ///< largest torque, Nm
  double speed = infinity;  ///< largest speed, rad/s
  Bounds position = {};     ///< limits, rad
  double start = 0.0;       ///< position at which the controller starts, rad
  double gain = 1.0;        ///< factor of the springs and dampers of `stand` and of the soft stop
};
/// Names of the joints.
std::vector<std::string> names_of(const std::vector<LinkJoint>& joints);
/// Joints of a robot that starts in this posture (rad). Throws InputError if one has no largest
/// torque.
std::vector<LinkJoint> joints_of(const FloatingRobot& body, const VectorXd& posture);

/// Computes commands for a robot in another process. RobotControl checks the readings before and
/// the commands afterwards.
class LinkController {
 public:
  virtual ~LinkController() = default;
  /// Starts with the readings of the first update(). May allocate.
  virtual void start(const SensorMessage& readings) = 0;
  /// Commands for the readings of the period `time` seconds after the start. Does not allocate.
  /// Without positions the torques act alone. The reference stays valid.
  virtual const Robot::Commands& update(double time, const SensorMessage& readings) = 0;
  /// One sentence on why the robot must stop after the last update(), or empty.
  virtual std::string fault() const { return {}; }
  /// True if the controller has finished.
  virtual bool is_done() const { return false; }
  /// Work for the next update() that needs no readings. Called after a command was sent.
  virtual void prepare() {}
  /// State for its commands: `balance` or `check`.
  virtual ControlState state() const { return ControlState::balance; }
};

/// Drives a robot with a BalanceController.
class BalanceLink final : public LinkController {
 public:
  /// `controller` must outlive this object. `posture`: state at the start. `largest_tilt`:
  /// inclination of the base at which the robot has fallen, rad.
  BalanceLink(walking::BalanceController& controller, WholeBodyState posture,
              double largest_tilt = 0.8);

  void start(const SensorMessage& readings) override;
  const Robot::Commands& update(double time, const SensorMessage& readings) override;
  std::string fault() const override;
  void prepare() override;

 private:
  void read(double time, const SensorMessage& readings);

  walking::BalanceController& controller_;
  WholeBodyState posture_;
  double largest_tilt_;
  Robot::Readings readings_;
};

}  // namespace saltus::robots::control
