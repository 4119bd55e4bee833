// Transports of the messages to a robot in another process: UDP, and shared memory on one machine.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "saltus/core/clock.hpp"

namespace saltus::robots::control {

/// Sends and receives messages of at most RobotLink::most_bytes. Messages can be lost or reordered.
/// Use it from one thread. Does not allocate after construction.
class RobotLink {
 public:
  static constexpr std::size_t most_bytes = 8192;  ///< largest message

  virtual ~RobotLink() = default;
  /// Waits for a message until `deadline`; empty if there is none. The bytes stay valid until the
  /// next call.
  virtual std::span<const std::byte> receive(WallClock::time_point deadline) = 0;
  /// Sends to the other side if it is known. A failed transmission counts as a lost message.
  virtual void send(std::span<const std::byte> message) = 0;
  /// Makes send() address the sender of the last message received.
  virtual void accept_sender() {}
};

/// Sides of a link. The controller opens it first, and keeps its address.
enum class LinkSide { controller, robot };

/// Opens "udp:PORT" or "udp:ADDRESS:PORT" (IPv4), or "shm:NAME". The controller listens at the
/// address, without ADDRESS on the loopback interface only; port 0: any free one. Throws InputError
/// that names the address.
std::unique_ptr<RobotLink> open_link(const std::string& address, LinkSide side);

/// Port of a UDP link, 0 for other links.
int port_of(const RobotLink& link);

}  // namespace saltus::robots::control
