// The robot's side of the link for any Robot: sends readings, and drives it with the commands that
// the guard of saltus/c/saltus_robot.h lets pass.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "saltus/robots/control/link_controller.hpp"
#include "saltus/robots/control/robot_link.hpp"
#include "saltus/robots/whole_body/robot.hpp"

namespace saltus::robots::control {

/// Options of serve_robot().
struct ServerOptions {
  double pace = 0.0;  ///< wall-clock seconds per second of the robot; 0: waits for the answers
  double time = 6.0;  ///< duration in balance, s; then the robot requests a stop
  double loss = 0.0;  ///< fraction of lost messages, in each direction
  double delay = 0.0, jitter = 0.0;       ///< delay, and largest additional random delay, s
  int seed = 1;                           ///< seed of loss and jitter
  double silence = 0.015, release = 0.3;  ///< times of the guard, s
  double patience = 30.0;                 ///< waiting time for a controller, s of wall-clock time
};

/// Result of serve_robot().
struct ServerResult {
  /// Reason of the end.
  enum class End {
    stopped,        ///< the controller has released the robot
    over,           ///< `is_over` was true, or `time` had passed and no controller was left
    no_controller,  ///< no controller has balanced
    failed          ///< the robot has failed, see `failure`
  };
  End end = End::stopped;  ///< reason of the end
  double time = 0.0;       ///< time since the begin of balance, s
  long guarded = 0;        ///< periods in which the guard acted
  std::string failure;     ///< sentence of Robot::wait()
};

/// Moves a robot that hangs by these commands for one period. In the state `stand` it may place the
/// joints at the commanded positions.
using HangingRobot = std::function<void(const Robot::Commands& commands, ControlState state)>;

/// Serves a robot until a controller releases it. The robot hangs until a controller balances.
/// `is_over` is polled in each period.
ServerResult serve_robot(Robot& robot, const std::vector<LinkJoint>& joints, RobotLink& link,
                         const ServerOptions& options, const HangingRobot& hang,
                         const std::function<bool()>& is_over);

}  // namespace saltus::robots::control
