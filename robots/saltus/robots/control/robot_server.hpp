// The robot's side of the link for any Robot: sends its readings, and applies the commands that
// pass the guard of saltus/c/saltus_robot.h.
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
  double patience = 30.0;                 ///< wall-clock time to wait for a controller, s
};

/// Result of serve_robot().
struct ServerResult {
  /// Reason of the end.
  enum class End {
    stopped,        ///< the controller has released the robot
    over,           ///< `is_over` was true, or `time` had passed and the controller had gone
    no_controller,  ///< no controller has balanced
    failed          ///< the robot has failed, see `failure`
  };
  End end = End::stopped;  ///< reason of the end
  double time = 0.0;       ///< time since balance began, s
  long guarded = 0;        ///< periods in which the guard acted
  std::string failure;     ///< sentence of Robot::wait()
};

/// Moves a hanging robot for one period with these commands. In the state `stand` it may set the
/// joints to the commanded positions.
using HangingRobot = std::function<void(const Robot::Commands& commands, ControlState state)>;

/// Serves a robot until a controller releases it. The robot hangs until a controller balances it.
/// Each period calls `is_over`, and true ends the run.
ServerResult serve_robot(Robot& robot, const std::vector<LinkJoint>& joints, RobotLink& link,
                         const ServerOptions& options, const HangingRobot& hang,
                         const std::function<bool()>& is_over);

}  // namespace saltus::robots::control
