// The C header for the robot's side of the link writes the bytes of the controller, and its guard
// never holds a torque for long.
#include "saltus/c/saltus_robot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "saltus/robots/control/protocol.hpp"
#include "saltus/robots/control/robot_control.hpp"
#include "saltus/robots/control/robot_link.hpp"

// Of saltus_robot_fast_math.cpp.
int take_with_fast_math(saltus_guard* guard, const saltus_link* link, const unsigned char* bytes,
                        size_t size, double now);
saltus_guard_action act_with_fast_math(saltus_guard* guard, double now, const double* q,
                                       const double* dq, double* torques);

namespace saltus::robots::control {
namespace {

const std::vector<std::string> names{"hip", "knee", "ankle"};
const char* const c_names[] = {"hip", "knee", "ankle"};
constexpr int n = 3;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::string hex_of(const void* bytes, std::size_t size) {
  std::string text;
  for (std::size_t i = 0; i < size; ++i) {
    constexpr char digits[] = "0123456789abcdef";
    const unsigned byte = static_cast<const unsigned char*>(bytes)[i];
    text += digits[byte / 16];
    text += digits[byte % 16];
  }
  return text;
}

// The same messages as in link_bytes_test.py: entry i of the numbers is i / 4.
saltus_sensors c_readings() {
  saltus_sensors m{};
  m.sequence = 7;
  m.time = 1500000000;
  m.pace = 0.5;
  m.requests_stop = 1;
  double next = 0.0;
  const auto fill = [&next](double* values, int count) {
    for (int i = 0; i < count; ++i, next += 0.25) values[i] = next;
  };
  fill(m.angular_velocity, 3);
  fill(m.specific_force, 3);
  fill(m.orientation, 4);
  fill(m.left, 6);
  fill(m.right, 6);
  fill(m.q, n);
  fill(m.dq, n);
  return m;
}
saltus_command c_command() {
  saltus_command m{};
  m.sequence = 9;
  m.answers = 7;
  m.time = 1500000000;
  m.state = SALTUS_BALANCE;
  double next = 0.0;
  for (double* part : {m.torques, m.positions, m.velocities, m.stiffness, m.damping})
    for (int i = 0; i < n; ++i, next += 0.25) part[i] = next;
  return m;
}

// Lines of link_messages.hex: readings, command.
std::vector<std::string> golden() {
  std::ifstream file(SALTUS_LINK_MESSAGES);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

TEST(RobotHeader, WritesTheBytesOfTheController) {
  const saltus_link link = saltus_link_of(c_names, n);
  Codec codec(names);
  EXPECT_EQ(link.robot, codec.robot());
  ASSERT_EQ(golden().size(), 2u);
  unsigned char bytes[SALTUS_LINK_BYTES];

  const saltus_sensors readings = c_readings();
  const std::size_t size = saltus_write_sensors(&link, &readings, bytes);
  EXPECT_EQ(size, saltus_sensors_size(n));
  EXPECT_EQ(hex_of(bytes, size), golden()[0]);
  SensorMessage got;
  ASSERT_EQ(codec.decode(std::as_bytes(std::span(bytes, size)), got), Refusal::none);
  const auto again = codec.encode(got);
  EXPECT_EQ(hex_of(again.data(), again.size()), golden()[0]);
  saltus_sensors back{};
  ASSERT_TRUE(saltus_read_sensors(&link, bytes, size, &back));
  EXPECT_EQ(back.dq[2], readings.dq[2]);
  EXPECT_EQ(back.left[0], readings.left[0]);
  EXPECT_EQ(back.requests_stop, 1);
  EXPECT_EQ(back.is_guarded, 0);
  back.requests_stop = 0;
  back.is_guarded = 1;
  const std::size_t guarded = saltus_write_sensors(&link, &back, bytes);
  ASSERT_EQ(codec.decode(std::as_bytes(std::span(bytes, guarded)), got), Refusal::none);
  EXPECT_TRUE(got.is_guarded);
  EXPECT_FALSE(got.requests_stop);
  EXPECT_EQ(bytes[22], 2);
  const auto bytes_again = codec.encode(got);
  EXPECT_EQ(hex_of(bytes_again.data(), bytes_again.size()), hex_of(bytes, guarded));

  const saltus_command command = c_command();
  const std::size_t command_size = saltus_write_command(&link, &command, bytes);
  EXPECT_EQ(hex_of(bytes, command_size), golden()[1]);
  CommandMessage answer;
  ASSERT_EQ(codec.decode(std::as_bytes(std::span(bytes, command_size)), answer), Refusal::none);
  const auto command_again = codec.encode(answer);
  EXPECT_EQ(hex_of(command_again.data(), command_again.size()), golden()[1]);
  saltus_command read{};
  ASSERT_TRUE(saltus_read_command(&link, bytes, command_size, &read));
  EXPECT_EQ(read.damping[2], command.damping[2]);
  EXPECT_EQ(read.answers, 7u);
  EXPECT_EQ(read.state, SALTUS_BALANCE);
}

TEST(RobotHeader, HasTheSizesAndStatesOfTheController) {
  EXPECT_EQ(SALTUS_LINK_VERSION, protocol_version);
  EXPECT_EQ(SALTUS_LINK_BYTES, RobotLink::most_bytes);
  EXPECT_LE(saltus_command_size(SALTUS_LINK_JOINTS), static_cast<std::size_t>(SALTUS_LINK_BYTES));
  for (const auto& [theirs, ours] : {std::pair{SALTUS_START, ControlState::start},
                                     {SALTUS_STAND, ControlState::stand},
                                     {SALTUS_BALANCE, ControlState::balance},
                                     {SALTUS_HOLD, ControlState::hold},
                                     {SALTUS_DAMP, ControlState::damp},
                                     {SALTUS_RELEASE, ControlState::release},
                                     {SALTUS_CHECK, ControlState::check}})
    EXPECT_EQ(static_cast<std::uint32_t>(theirs), static_cast<std::uint32_t>(ours));
}

TEST(RobotHeader, RefusesWrongMessages) {
  const saltus_link link = saltus_link_of(c_names, n);
  const saltus_command command = c_command();
  unsigned char bytes[SALTUS_LINK_BYTES];
  const std::size_t size = saltus_write_command(&link, &command, bytes);
  saltus_command got{};
  for (std::size_t i = 0; i < size; ++i) {
    bytes[i] ^= 0x10U;
    EXPECT_FALSE(saltus_read_command(&link, bytes, size, &got)) << i;
    bytes[i] ^= 0x10U;
  }
  EXPECT_FALSE(saltus_read_command(&link, bytes, size - 1, &got));
  saltus_sensors readings{};
  EXPECT_FALSE(saltus_read_sensors(&link, bytes, size, &readings));
  const char* const other[] = {"knee", "hip", "ankle"};
  const saltus_link stranger = saltus_link_of(other, n);
  EXPECT_FALSE(saltus_read_command(&stranger, bytes, size, &got));
  EXPECT_EQ(got.sequence, 0u);
  EXPECT_TRUE(saltus_read_command(&link, bytes, size, &got));
}

TEST(RobotHeader, RefusesWrongNumbersOfJoints) {
  const saltus_sensors readings{};
  const saltus_command command{};
  const std::vector<double> limits(300, 1.0);
  unsigned char bytes[16] = {};
  for (const int joints : {-1, 0, SALTUS_LINK_JOINTS + 1}) {
    const saltus_link link = {0, joints};
    EXPECT_EQ(saltus_write_sensors(&link, &readings, bytes), 0u);
    EXPECT_EQ(saltus_write_command(&link, &command, bytes), 0u);
    EXPECT_EQ(hex_of(bytes, sizeof bytes), std::string(2 * sizeof bytes, '0'));
    saltus_guard guard;
    saltus_guard_init(&guard, joints, limits.data());
    EXPECT_EQ(guard.joints, 0);
    EXPECT_EQ(guard.command.sequence, 0u);
    EXPECT_FALSE(saltus_guard_take(&guard, &link, bytes, sizeof bytes, 0.0));
  }
}

class Guard : public ::testing::Test {
 protected:
  Guard() : link(saltus_link_of(c_names, n)) {
    const double limits[] = {10.0, 20.0, 30.0};
    saltus_guard_init(&guard, n, limits);
  }
  int take(const saltus_command& command, double now) {
    unsigned char bytes[SALTUS_LINK_BYTES];
    return saltus_guard_take(&guard, &link, bytes, saltus_write_command(&link, &command, bytes),
                             now);
  }
  saltus_guard_action act(double now) { return saltus_guard_torques(&guard, now, q, dq, torques); }
  static saltus_command push(std::uint64_t sequence) {
    saltus_command command{};
    command.sequence = sequence;
    command.state = SALTUS_BALANCE;
    for (double& torque : command.torques) torque = 5.0;
    return command;
  }

  saltus_link link;
  saltus_guard guard{};
  double q[n] = {0.0, 0.0, 0.0}, dq[n] = {0.5, -0.5, 0.0}, torques[n] = {nan, nan, nan};
};

TEST_F(Guard, ExertsNothingBeforeTheFirstCommand) {
  EXPECT_EQ(act(0.0), SALTUS_GUARD_RELEASES);
  for (const double torque : torques) EXPECT_EQ(torque, 0.0);
  EXPECT_EQ(guard.guarded, 0);
}

// The guard holds the torque of a command for at most 15 ms by default.
TEST_F(Guard, DampsAndReleasesWithoutCommands) {
  ASSERT_TRUE(take(push(1), 1.0));
  EXPECT_EQ(act(1.0149), SALTUS_GUARD_PASSES);
  EXPECT_EQ(torques[0], 5.0);
  EXPECT_EQ(act(1.0151), SALTUS_GUARD_DAMPS);
  EXPECT_DOUBLE_EQ(torques[0], -0.2 * 10.0 * 0.5);
  EXPECT_DOUBLE_EQ(torques[1], 0.2 * 20.0 * 0.5);
  EXPECT_EQ(act(1.299), SALTUS_GUARD_DAMPS);
  EXPECT_EQ(act(1.301), SALTUS_GUARD_RELEASES);
  for (const double torque : torques) EXPECT_EQ(torque, 0.0);
  EXPECT_EQ(guard.guarded, 3);
  guard.silence = 0.05;
  ASSERT_TRUE(take(push(2), 2.0));
  EXPECT_EQ(act(2.04), SALTUS_GUARD_PASSES);
}

TEST_F(Guard, TreatsNumbersThatAreNotFiniteAsNoCommand) {
  ASSERT_TRUE(take(push(1), 0.0));
  for (double* (*part)(saltus_command&) : {+[](saltus_command& c) { return c.torques; },
                                           +[](saltus_command& c) { return c.positions; },
                                           +[](saltus_command& c) { return c.velocities; },
                                           +[](saltus_command& c) { return c.stiffness; },
                                           +[](saltus_command& c) { return c.damping; }}) {
    saltus_command bad = push(2);
    part(bad)[1] = nan;
    EXPECT_FALSE(take(bad, 0.01));
    part(bad)[1] = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(take(bad, 0.01));
  }
  EXPECT_EQ(guard.refused, 10);
  EXPECT_EQ(act(0.012), SALTUS_GUARD_PASSES);
  EXPECT_EQ(act(0.016), SALTUS_GUARD_DAMPS);
}

TEST_F(Guard, NoticesNumbersThatAreNotFiniteWithFastMath) {
  unsigned char bytes[SALTUS_LINK_BYTES];
  const saltus_command good = push(1);
  std::size_t size = saltus_write_command(&link, &good, bytes);
  EXPECT_EQ(act_with_fast_math(&guard, 0.0, q, dq, torques), SALTUS_GUARD_RELEASES);
  ASSERT_TRUE(take_with_fast_math(&guard, &link, bytes, size, 0.0));
  for (const double wrong : {nan, std::numeric_limits<double>::infinity()}) {
    saltus_command bad = push(2);
    bad.torques[1] = wrong;
    size = saltus_write_command(&link, &bad, bytes);
    EXPECT_FALSE(take_with_fast_math(&guard, &link, bytes, size, 0.001));
  }
  guard.command.stiffness[1] = 1.0;
  q[1] = nan;
  EXPECT_EQ(act_with_fast_math(&guard, 0.002, q, dq, torques), SALTUS_GUARD_PASSES);
  EXPECT_EQ(torques[0], 5.0);
  EXPECT_EQ(torques[1], 0.0);
  EXPECT_EQ(act_with_fast_math(&guard, 0.1, q, dq, torques), SALTUS_GUARD_DAMPS);
}

TEST_F(Guard, KeepsTheNewestCommand) {
  ASSERT_TRUE(take(push(5), 0.0));
  EXPECT_FALSE(take(push(4), 0.001));
  EXPECT_FALSE(take(push(5), 0.001));
  EXPECT_TRUE(take(push(6), 0.001));
}

// A controller that starts again counts from one, and answers newer readings.
TEST_F(Guard, FollowsANewControllerAfterTheRelease) {
  saltus_command last = push(1000);
  last.answers = 2000;
  ASSERT_TRUE(take(last, 0.0));
  saltus_command first = push(1);
  first.answers = 1999;
  EXPECT_FALSE(take(first, 1.0));  // an old message
  first.answers = 2200;
  EXPECT_FALSE(take(first, 0.2));
  EXPECT_TRUE(take(first, 1.0));
  EXPECT_TRUE(take(push(2), 1.001));
}

TEST_F(Guard, TreatsWrongLimitsAsZero) {
  const double limits[] = {nan, -10.0, std::numeric_limits<double>::infinity()};
  saltus_guard_init(&guard, n, limits);
  ASSERT_TRUE(take(push(1), 0.0));
  for (const double now : {0.01, 0.02}) {
    act(now);
    for (const double torque : torques) EXPECT_EQ(torque, 0.0);
  }
}

// A controller of joints that are already in their posture.
class Still final : public LinkController {
 public:
  explicit Still(ControlState runs) : runs_(runs) {}
  void start(const SensorMessage&) override {}
  const Robot::Commands& update(double, const SensorMessage&) override { return commands_; }
  ControlState state() const override { return runs_; }

 private:
  ControlState runs_;
  Robot::Commands commands_{VectorXd::Zero(n)};
};

TEST_F(Guard, FollowsANewControllerOfJointsInTheirPosture) {
  for (const ControlState runs : {ControlState::balance, ControlState::check}) {
    std::vector<LinkJoint> joints(n);
    for (LinkJoint& joint : joints) joint.effort = 10.0;
    Still still(runs);
    Codec codec(names);
    const auto take_from = [&](RobotControl& control, std::uint64_t k) {
      SensorMessage readings;
      readings.sequence = k;
      readings.time = 1e-3 * static_cast<double>(k);
      readings.q = readings.dq = VectorXd::Zero(n);
      const auto bytes = codec.encode(*control.update(readings));
      return saltus_guard_take(&guard, &link, reinterpret_cast<const unsigned char*>(bytes.data()),
                               bytes.size(), readings.time);
    };
    guard.command = {};
    guard.commanded_at = -std::numeric_limits<double>::infinity();
    RobotControl first(still, joints, {}), second(still, joints, {});
    for (std::uint64_t k = 0; k < 100; ++k) ASSERT_TRUE(take_from(first, k));
    EXPECT_TRUE(take_from(second, 500));
    EXPECT_EQ(guard.command.sequence, 1u);
    EXPECT_EQ(guard.command.state, static_cast<std::uint32_t>(runs));
    EXPECT_TRUE(take_from(second, 501));
  }
}

TEST_F(Guard, CutsTorquesToTheLimits) {
  saltus_command strong = push(1);
  strong.stiffness[0] = strong.stiffness[1] = 1e3;
  strong.positions[0] = 1.0;
  strong.velocities[1] = -100.0;
  ASSERT_TRUE(take(strong, 0.0));
  EXPECT_EQ(act(0.01), SALTUS_GUARD_PASSES);
  EXPECT_EQ(torques[0], 10.0);
  EXPECT_EQ(torques[1], -20.0);  // the position has advanced to -1 rad
  q[0] = nan;
  act(0.01);
  EXPECT_EQ(torques[0], 0.0);
}

}  // namespace
}  // namespace saltus::robots::control
