#include "saltus/robots/control/robot_server.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <span>
#include <thread>

#include "saltus/c/saltus_robot.h"
#include "saltus/core/random.hpp"

namespace saltus::robots::control {
namespace {

WallClock::duration of_seconds(double s) {
  return std::chrono::duration_cast<WallClock::duration>(std::chrono::duration<double>(s));
}

// Loses messages and delays each by a random time, so that later ones can arrive first.
class Lossy {
 public:
  struct Message {
    double due = 0.0;            // s
    std::uint64_t sequence = 0;  // of the message, or of the readings that it answers
    std::vector<std::byte> bytes;
  };
  Lossy(const ServerOptions& options, std::uint64_t seed) : options_(options), random_(seed) {}

  void put(double now, std::uint64_t sequence, std::span<const std::byte> bytes) {
    const bool is_lost = random_.chance(options_.loss);
    const double late = random_.uniform(0.0, options_.jitter);
    if (!is_lost)
      waiting_.push_back({now + options_.delay + late, sequence, {bytes.begin(), bytes.end()}});
  }
  // Calls `use` with the messages that are due, in the order of their sequence numbers.
  template <class Use>
  void take(double now, Use use) {
    const auto due = std::stable_partition(waiting_.begin(), waiting_.end(),
                                           [now](const Message& m) { return m.due > now + 1e-9; });
    std::sort(due, waiting_.end(),
              [](const Message& a, const Message& b) { return a.sequence < b.sequence; });
    for (auto one = due; one != waiting_.end(); ++one) use(*one);
    waiting_.erase(due, waiting_.end());
  }

 private:
  ServerOptions options_;
  Random random_;
  std::vector<Message> waiting_;
};

const unsigned char* as_chars(std::span<const std::byte> bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

}  // namespace

ServerResult serve_robot(Robot& robot, const std::vector<LinkJoint>& joints, RobotLink& link,
                         const ServerOptions& options, const HangingRobot& hang,
                         const std::function<bool()>& is_over) {
  const int n = static_cast<int>(joints.size());
  const std::vector<std::string> names = names_of(joints);
  Codec codec(names);
  const saltus_link identity{codec.robot(), n};
  std::vector<double> limits;
  limits.reserve(joints.size());
  for (const LinkJoint& joint : joints) limits.push_back(joint.effort);
  const auto guard = std::make_unique<saltus_guard>();
  saltus_guard_init(guard.get(), n, limits.data());
  guard->silence = options.silence;
  guard->release = options.release;
  Lossy out(options, static_cast<std::uint64_t>(options.seed));
  Lossy back(options, static_cast<std::uint64_t>(options.seed) + 1000000);

  Robot::Commands commands;
  for (VectorXd* part : {&commands.torques, &commands.positions, &commands.velocities,
                         &commands.stiffness, &commands.damping})
    *part = VectorXd::Zero(n);
  VectorXd torques(n);
  SensorMessage message;
  message.q = robot.read().q;
  message.dq = VectorXd::Zero(n);
  CommandMessage answer;
  ServerResult result;
  const double period = robot.period();
  const WallClock::time_point begin = WallClock::now();
  WallClock::time_point heard = begin;
  bool hangs = true, is_alive = true, stops = false, guards = false;
  std::uint64_t written = 0;
  const auto take_over = [&commands, n](const saltus_command& c) {
    commands.torques = Eigen::Map<const VectorXd>(c.torques, n);
    commands.positions = Eigen::Map<const VectorXd>(c.positions, n);
    commands.velocities = Eigen::Map<const VectorXd>(c.velocities, n);
    commands.stiffness = Eigen::Map<const VectorXd>(c.stiffness, n);
    commands.damping = Eigen::Map<const VectorXd>(c.damping, n);
  };
  std::int64_t delivered = -1, answered = -1, requested = -1;
  for (std::uint64_t k = 0;; ++k) {
    const double now = static_cast<double>(k) * period;
    const Robot::Readings& r = robot.read();
    message.dq = (r.q - message.q) / period;
    message.q = r.q;
    message.angular_velocity = r.angular_velocity;
    message.specific_force = r.specific_force;
    message.left = r.left;
    message.right = r.right;
    message.sequence = k;
    message.time = now;
    message.pace = options.pace;
    message.requests_stop = stops;
    message.is_guarded = guards;
    out.put(now, k, codec.encode(message));
    const std::int64_t before = delivered;
    out.take(now, [&](const Lossy::Message& m) {
      delivered = std::max(delivered, static_cast<std::int64_t>(m.sequence));
      link.send(m.bytes);
    });
    // In lock-step wait for the answer to the delivered readings, otherwise until the period ends.
    const bool waits = options.pace == 0.0;
    const WallClock::time_point until =
        waits ? WallClock::now() + of_seconds(hangs ? 0.1 : 2.0)
              : begin + of_seconds(options.pace * static_cast<double>(k + 1) * period);
    while (!waits || (is_alive && answered < delivered && delivered > before)) {
      const std::span<const std::byte> bytes = link.receive(until);
      if (bytes.empty()) break;
      if (codec.decode(bytes, answer) != Refusal::none) continue;
      answered = std::max(answered, static_cast<std::int64_t>(answer.answers));
      heard = WallClock::now();
      back.put(waits ? now : now + period, answer.sequence, bytes);
    }
    if (waits && !hangs && answered < delivered && delivered > before)
      is_alive = false;  // does not wait for a controller that has gone
    back.take(now, [&](const Lossy::Message& m) {
      saltus_guard_take(guard.get(), &identity, as_chars(m.bytes), m.bytes.size(), now);
    });
    const saltus_command& c = guard->command;
    if (c.state == SALTUS_RELEASE && std::isfinite(guard->commanded_at)) {
      return result;
    }
    if (hangs && c.state == SALTUS_BALANCE) hangs = false;
    if (hangs) {
      if (c.state == SALTUS_STAND || c.state == SALTUS_CHECK) {
        take_over(c);
        hang(commands, static_cast<ControlState>(c.state));
      }
      if (WallClock::now() - heard > of_seconds(options.patience) || is_over()) {
        result.end = ServerResult::End::no_controller;
        return result;
      }
      continue;
    }
    const VectorXd& q = message.q;
    switch (saltus_guard_torques(guard.get(), now, q.data(), message.dq.data(), torques.data())) {
      case SALTUS_GUARD_PASSES:
        if (c.sequence == written) break;  // the robot advances the positions itself
        written = c.sequence;
        take_over(c);
        robot.write(commands);
        break;
      case SALTUS_GUARD_DAMPS:
      case SALTUS_GUARD_RELEASES:
        commands.torques.setZero();
        commands.positions = q;
        commands.velocities.setZero();
        commands.stiffness.setZero();
        commands.damping = Eigen::Map<const VectorXd>(guard->dampers, n);
        if (now - guard->commanded_at >= guard->release) commands.damping.setZero();
        robot.write(commands);
        break;
    }
    guards = result.guarded < guard->guarded;
    result.guarded = guard->guarded;
    result.failure = robot.wait();
    result.time += period;
    if (!result.failure.empty()) {
      result.end = ServerResult::End::failed;
      return result;
    }
    if (!stops && (is_over() || result.time > options.time - 0.5 * period)) {
      stops = true;
      requested = static_cast<std::int64_t>(k);
    }
    // The controller answers the request by a soft stop, unless it has gone.
    if (stops && (static_cast<double>(static_cast<std::int64_t>(k) - requested) * period > 5.0 ||
                  (waits && !is_alive))) {
      result.end = ServerResult::End::over;
      return result;
    }
  }
}

}  // namespace saltus::robots::control
