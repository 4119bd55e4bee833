// Messages between `saltus control` and a robot in another process, version 1. docs/robot_link.md
// specifies them byte by byte: little-endian, every field at a multiple of its size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/robots/whole_body/robot.hpp"

namespace saltus::robots::control {

/// Version of the messages. Both sides refuse any other one.
inline constexpr std::uint16_t protocol_version = 1;

/// Sensor readings of one period, from the robot.
struct SensorMessage {
  std::uint64_t sequence = 0;  ///< number of the period: one more in every period
  double time = 0.0;           ///< time of the readings on the robot's clock, s
  /// Wall-clock seconds per second of the robot's clock. 1: real time. 0: the robot waits for the
  /// answer to every message.
  double pace = 1.0;
  bool requests_stop = false;  ///< True if the controller shall stop softly.
  bool is_guarded = false;     ///< True if the robot's guard acts instead of the commands.
  /// Mean over the last period, rad/s, axes of the base; as Robot::Readings.
  Vec<double, 3> angular_velocity = Vec<double, 3>::Zero();
  /// Mean over the last period, m/s^2, axes of the base; as Robot::Readings.
  Vec<double, 3> specific_force = Vec<double, 3>::Zero();
  /// Orientation of the base in the world (w, x, y, z); zeros: unknown.
  Vec<double, 4> orientation = Vec<double, 4>::Zero();
  /// Wrenches of the ground on the feet: force N and torque Nm, axes of the soles.
  Vec<double, 6> left = Vec<double, 6>::Zero(), right = Vec<double, 6>::Zero();
  VectorXd q;   ///< joint positions, rad
  VectorXd dq;  ///< joint velocities, rad/s

  /// True if every number is finite.
  bool is_finite() const;
};

/// States of the controller; the first six in the order of a run.
enum class ControlState : std::uint32_t {
  start,    ///< waits for the first readings; no torque
  stand,    ///< moves the joints into the posture of the start
  balance,  ///< BalanceController
  hold,     ///< soft stop: the last torques, and springs around the last positions
  damp,     ///< soft stop: torques and springs fade, dampers remain
  release,  ///< no torque
  check     ///< moves one joint after the other, for a robot that hangs; instead of `balance`
};
/// Name of the state in tables and messages.
const char* describe(ControlState state);

/// Commands to all joints, from the controller.
struct CommandMessage {
  std::uint64_t sequence = 0;  ///< one more in every message
  std::uint64_t answers = 0;   ///< SensorMessage::sequence of the latest readings that were used
  double time = 0.0;           ///< SensorMessage::time of these readings, s
  ControlState state = ControlState::start;  ///< state of the controller
  Robot::Commands commands;                  ///< all vectors have one entry per joint
};

/// Result of decoding a message.
enum class Refusal {
  none,         ///< the message is valid
  truncated,    ///< its size is not the one that it names, or too small
  foreign,      ///< it does not begin as a message of this protocol
  version,      ///< another version of the protocol
  checksum,     ///< a byte has changed
  type,         ///< neither of the two kinds, or the wrong one for this side
  joint_count,  ///< another number of joints
  robot         ///< other names or another order of the joints
};
/// One clause about the refusal, for messages.
const char* describe(Refusal refusal);

/// CRC-32 of IEEE 802.3, as zlib.crc32() of Python.
std::uint32_t crc32(std::span<const std::byte> bytes);

/// Converts messages to bytes and back, for a robot with these joints. Does not allocate after
/// construction.
class Codec {
 public:
  /// `joints`: names in the order of all vectors.
  explicit Codec(std::span<const std::string> joints);

  /// Number of joints.
  int joints() const { return joints_; }
  /// Identifies the robot: CRC-32 of the names of the joints, each followed by a line break.
  std::uint32_t robot() const { return robot_; }

  /// The bytes stay valid until the next call of encode().
  std::span<const std::byte> encode(const SensorMessage& message);
  /// The bytes stay valid until the next call of encode().
  std::span<const std::byte> encode(const CommandMessage& message);
  /// A refused message leaves `message` as it was.
  Refusal decode(std::span<const std::byte> bytes, SensorMessage& message) const;
  /// A refused message leaves `message` as it was.
  Refusal decode(std::span<const std::byte> bytes, CommandMessage& message) const;

 private:
  int joints_;
  std::uint32_t robot_;
  std::vector<std::byte> bytes_;
};

}  // namespace saltus::robots::control
