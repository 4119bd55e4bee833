// Drives a robot in another process with a LinkController: states, guards and the soft stop. No
// sockets and no clock, so that every reaction can be tested.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "saltus/robots/control/link_controller.hpp"
#include "saltus/robots/control/protocol.hpp"
#include "saltus/robots/control/stuck_joints.hpp"

namespace saltus::robots::control {

/// Options of RobotControl. Springs and dampers are multiples of the largest torque of each joint.
struct ControlOptions {
  double period = 0.001;                  ///< period of the readings, s
  double balance = infinity;              ///< duration of the state `balance` or `check`, s
  double stand = 2.0;                     ///< duration of the state `stand`, s
  double hold = 0.3, damp = 1.0;          ///< durations of these states, s
  double stiffness = 5.0, damping = 0.2;  ///< springs of `stand`, `hold` and `damp`: 1/rad, s/rad
  double near = 0.03;          ///< rad, distance of joints from the posture at which it is reached
  int most_missing = 30;       ///< consecutive readings that are replaced if they are lost or late
  double beyond_limit = 0.05;  ///< rad, by which a joint may be beyond its limits
  double speed_factor = 3.0;   ///< largest speed of a joint, as a multiple of its limit
  double clock_error = 0.5;    ///< relative difference of time stamps from the period
  /// Bandwidths of first-order filters for gyroscope and accelerometer, for the wrenches of the
  /// feet, for joint velocities, and for commanded torques, Hz; 0: no filter.
  double inertial_hz = 0.0, force_hz = 0.0, velocity_hz = 0.0, torque_hz = 0.0;
  StuckJoints::Options stuck;  ///< thresholds for stuck joints
};

/// Counts of messages.
struct LinkCounts {
  long received = 0;   ///< valid messages
  long used = 0;       ///< messages with the latest readings at that time
  long late = 0;       ///< messages that arrived after a later one
  long duplicate = 0;  ///< messages that had arrived before
  long refused = 0;    ///< messages that the codec refused
  long replaced = 0;   ///< readings that were interpolated
  long guarded = 0;    ///< used messages while the robot's guard acted and the controller ran
};

/// Turns readings into commands. Only the start of balancing and the sentence about a fault
/// allocate.
class RobotControl {
 public:
  /// `controller` must outlive this object.
  RobotControl(LinkController& controller, std::vector<LinkJoint> joints, ControlOptions options);

  /// Processes readings. Returns the command that answers them, or null if they are old.
  const CommandMessage* update(const SensorMessage& readings);
  /// Begins the soft stop. Without a fault the reason is a request.
  void stop(std::string fault = {});
  /// Command without new readings, `seconds` after the last command: continues the soft stop.
  const CommandMessage& continue_stop(double seconds);
  /// Does the work for the next update() that needs no readings. Call it after the command was
  /// sent.
  void prepare() {
    if (is_running()) controller_.prepare();
  }
  /// Counts a refused message.
  void note_refused(Refusal refusal);

  /// State that the last command belongs to.
  ControlState state() const { return command_.state; }
  /// True during and after the soft stop.
  bool is_stopping() const {
    return command_.state == ControlState::hold || command_.state == ControlState::damp ||
           is_over();
  }
  /// True after the soft stop.
  bool is_over() const { return command_.state == ControlState::release; }
  /// One sentence on the reason of a soft stop; empty for a request.
  const std::string& fault() const { return fault_; }
  /// Result of the last update().
  const CommandMessage& command() const { return command_; }
  /// Counts of messages.
  const LinkCounts& counts() const { return counts_; }
  /// Reason of the last refusal.
  Refusal last_refusal() const { return refusal_; }
  /// Messages that were sent since the first one and have not arrived.
  long lost() const;
  /// Number of commands that exceeded the largest torque and were cut.
  long cut() const { return cut_; }
  /// Detector of stuck joints.
  const StuckJoints& stuck() const { return stuck_; }
  /// Time in the state `balance` or `check`, s.
  double balanced() const { return static_cast<double>(balance_periods_) * options_.period; }

 private:
  bool is_running() const {
    return command_.state == ControlState::balance || command_.state == ControlState::check;
  }
  bool is_new(std::uint64_t sequence);
  std::string implausible(const SensorMessage& readings, double elapsed) const;
  void begin(const SensorMessage& readings);
  void filter(SensorMessage& readings);
  void run(const SensorMessage& readings, long periods);
  void stand(double elapsed);
  void spring_to(const VectorXd& positions);
  void guard_torques();
  const CommandMessage& answer();

  LinkController& controller_;
  std::vector<LinkJoint> joints_;
  ControlOptions options_;
  VectorXd start_, effort_, springs_;  // springs_: largest torques times the gains
  SensorMessage last_;                 // latest valid readings
  SensorMessage readings_, filtered_;  // of the controller
  VectorXd torques_;                   // filtered
  StuckJoints stuck_;
  VectorXd from_;  // joints at the start of `stand`, or at the start of the soft stop
  VectorXd held_torques_;
  bool has_readings_ = false;
  std::uint64_t first_ = 0;   // sequence number of the first message
  std::uint64_t window_ = 0;  // arrived messages: bit 0 is the latest one
  double stopped_for_ = 0.0, stood_for_ = 0.0;
  long balance_periods_ = 0;
  std::string fault_;
  Refusal refusal_ = Refusal::none;
  LinkCounts counts_;
  long cut_ = 0;
  CommandMessage command_;
};

}  // namespace saltus::robots::control
