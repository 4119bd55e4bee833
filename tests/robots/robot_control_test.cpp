// The link to a robot in another process: messages, transports, and the reactions of the
// controller. The fake robot replays recorded sensor data, so no simulator is linked.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <limits>
#include <thread>

#include "saltus/core/error.hpp"
#include "saltus/robots/control/control_process.hpp"
#include "saltus/robots/control/link_file.hpp"
#include "saltus/robots/control/plugin_controller.hpp"
#include "tests/robots/recorded_run.hpp"
#include "tests/robots/synthetic_balance.hpp"
#include "tests/robots/tree_dynamics.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus::robots::control {
namespace {

using namespace std::chrono_literals;
using walking::BalanceController;

const std::vector<std::string> names{"hip", "knee", "ankle"};
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

SensorMessage some_readings() {
  SensorMessage m;
  m.sequence = 0x123456789abcdef0;
  m.time = 12.345678901;
  m.pace = 2.5;
  m.requests_stop = true;
  m.angular_velocity << 0.1, -0.2, 0.3;
  m.specific_force << 0.4, 0.5, 9.81;
  m.orientation << 1.0, 0.0, -0.0, 1e-300;
  m.left << 1, 2, 3, 4, 5, 6;
  m.right << -1, -2, -3, -4, -5, -6;
  m.q = Vec<double, 3>(0.7, 0.8, 0.9);
  m.dq = Vec<double, 3>(7.0, 8.0, 9.0);
  return m;
}

std::vector<std::byte> copy_of(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

// ---- messages

// The check value of CRC-32 in the catalogue of CRC algorithms.
TEST(Protocol, ChecksumIsCrc32) {
  EXPECT_EQ(crc32(std::as_bytes(std::span("123456789", 9))), 0xcbf43926U);
}

TEST(Protocol, SensorsComeBackUnchanged) {
  Codec codec(names);
  const SensorMessage sent = some_readings();
  SensorMessage got;
  const auto bytes = codec.encode(sent);
  ASSERT_EQ(bytes.size(), 40u + 8 * 24 + 16 * 3);
  ASSERT_EQ(codec.decode(bytes, got), Refusal::none);
  EXPECT_EQ(got.sequence, sent.sequence);
  EXPECT_NEAR(got.time, sent.time, 1e-9);
  EXPECT_EQ(got.pace, sent.pace);
  EXPECT_TRUE(got.requests_stop);
  EXPECT_EQ(got.angular_velocity, sent.angular_velocity);
  EXPECT_EQ(got.specific_force, sent.specific_force);
  EXPECT_EQ(got.orientation, sent.orientation);
  EXPECT_EQ(got.left, sent.left);
  EXPECT_EQ(got.right, sent.right);
  EXPECT_EQ(got.q, sent.q);
  EXPECT_EQ(got.dq, sent.dq);
}

TEST(Protocol, CommandsComeBackUnchanged) {
  Codec codec(names);
  CommandMessage sent, got;
  sent.sequence = 7;
  sent.answers = 5;
  sent.time = -0.25;
  sent.state = ControlState::damp;
  Robot::Commands& c = sent.commands;
  double value = 1.0;
  for (VectorXd* part : {&c.torques, &c.positions, &c.velocities, &c.stiffness, &c.damping})
    *part = VectorXd::Constant(3, value *= -1.5);
  const auto bytes = codec.encode(sent);
  ASSERT_EQ(bytes.size(), 40u + 16 + 40 * 3);
  ASSERT_EQ(codec.decode(bytes, got), Refusal::none);
  EXPECT_EQ(got.sequence, 7u);
  EXPECT_EQ(got.answers, 5u);
  EXPECT_EQ(got.time, -0.25);
  EXPECT_EQ(got.state, ControlState::damp);
  EXPECT_EQ(got.commands.torques, c.torques);
  EXPECT_EQ(got.commands.positions, c.positions);
  EXPECT_EQ(got.commands.velocities, c.velocities);
  EXPECT_EQ(got.commands.stiffness, c.stiffness);
  EXPECT_EQ(got.commands.damping, c.damping);
}

// The beginning of a message as docs/robot_link.md specifies it.
TEST(Protocol, HeaderIsLittleEndian) {
  Codec codec(names);
  const auto bytes = codec.encode(some_readings());
  const std::vector<int> expected{0x53, 0x4c, 0x54, 0x4c, 1, 0, 1, 0, 0x18, 1, 0, 0};
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(std::to_integer<int>(bytes[i]), expected[i]) << i;
  EXPECT_EQ(codec.robot(), crc32(std::as_bytes(std::span("hip\nknee\nankle\n", 15))));
  EXPECT_EQ(std::to_integer<int>(bytes[20]), 3);
  EXPECT_EQ(std::to_integer<int>(bytes[24]), 0xf0);
}

TEST(Protocol, RefusesShortAndLongMessages) {
  Codec codec(names);
  SensorMessage got;
  std::vector<std::byte> bytes = copy_of(codec.encode(some_readings()));
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_EQ(codec.decode(std::span(bytes).first(size), got), Refusal::truncated) << size;
  bytes.emplace_back();
  EXPECT_EQ(codec.decode(bytes, got), Refusal::truncated);
  EXPECT_EQ(got.sequence, 0u);
}

TEST(Protocol, RefusesEveryChangedByte) {
  Codec codec(names);
  SensorMessage got;
  std::vector<std::byte> bytes = copy_of(codec.encode(some_readings()));
  for (std::byte& byte : bytes) {
    byte ^= std::byte{0x10};
    EXPECT_NE(codec.decode(bytes, got), Refusal::none) << &byte - bytes.data();
    byte ^= std::byte{0x10};
  }
  EXPECT_EQ(got.sequence, 0u);
  EXPECT_EQ(codec.decode(bytes, got), Refusal::none);
}

TEST(Protocol, NamesTheReasonOfARefusal) {
  Codec codec(names);
  SensorMessage got;
  const std::vector<std::byte> bytes = copy_of(codec.encode(some_readings()));
  std::vector<std::byte> other = bytes;
  other[0] = std::byte{0};
  EXPECT_EQ(codec.decode(other, got), Refusal::foreign);
  other = bytes;
  other[4] = std::byte{2};
  EXPECT_EQ(codec.decode(other, got), Refusal::version);
  other = bytes;
  other[50] ^= std::byte{1};
  EXPECT_EQ(codec.decode(other, got), Refusal::checksum);
  CommandMessage command;
  EXPECT_EQ(codec.decode(bytes, command), Refusal::type);
  const std::vector<std::string> two{"hip", "knee"}, swapped{"knee", "hip", "ankle"};
  EXPECT_EQ(Codec(two).decode(bytes, got), Refusal::joint_count);
  EXPECT_EQ(Codec(swapped).decode(bytes, got), Refusal::robot);
}

// NaN is a reading, on which the controller decides.
TEST(Protocol, PassesNanOn) {
  Codec codec(names);
  SensorMessage sent = some_readings(), got;
  sent.q[1] = nan;
  ASSERT_EQ(codec.decode(codec.encode(sent), got), Refusal::none);
  EXPECT_TRUE(std::isnan(got.q[1]));
  EXPECT_FALSE(got.is_finite());
}

// ---- transports

class Transport : public ::testing::TestWithParam<const char*> {
 protected:
  Transport() {
    const std::string kind = GetParam();
    if (kind == "udp") {
      controller = open_link("udp:0", LinkSide::controller);
      robot = open_link("udp:" + std::to_string(port_of(*controller)), LinkSide::robot);
    } else {
      name = "saltus_test_" + std::to_string(::getpid());
      controller = open_link("shm:" + name, LinkSide::controller);
      robot = open_link("shm:" + name, LinkSide::robot);
    }
  }
  ~Transport() override {
    if (!name.empty()) ::unlink(("/dev/shm/" + name).c_str());
  }
  static WallClock::time_point soon() { return WallClock::now() + 5s; }

  std::string name;
  std::unique_ptr<RobotLink> controller, robot;
};

TEST_P(Transport, CarriesMessagesBothWays) {
  Codec codec(names);
  SensorMessage readings = some_readings(), got;
  for (std::uint64_t i = 0; i < 100; ++i) {
    readings.sequence = i;
    robot->send(codec.encode(readings));
    ASSERT_EQ(codec.decode(controller->receive(soon()), got), Refusal::none);
    ASSERT_EQ(got.sequence, i);
    controller->accept_sender();
    CommandMessage command, answer;
    command.answers = i;
    for (VectorXd* part :
         {&command.commands.torques, &command.commands.positions, &command.commands.velocities,
          &command.commands.stiffness, &command.commands.damping})
      *part = VectorXd::Zero(3);
    controller->send(codec.encode(command));
    ASSERT_EQ(codec.decode(robot->receive(soon()), answer), Refusal::none);
    ASSERT_EQ(answer.answers, i);
  }
}

TEST_P(Transport, WaitsUntilTheDeadlineWithoutAMessage) {
  const WallClock::time_point begin = WallClock::now();
  EXPECT_TRUE(controller->receive(begin + 20ms).empty());
  EXPECT_GE(WallClock::now() - begin, 20ms);
}

TEST_P(Transport, DoesNotAllocate) {
  Codec codec(names);
  const SensorMessage readings = some_readings();
  SensorMessage got = readings;
  const saltus::testing::AllocationCount count;
  robot->send(codec.encode(readings));
  const Refusal refusal = codec.decode(controller->receive(soon()), got);
  EXPECT_EQ(count.made(), 0);
  EXPECT_EQ(refusal, Refusal::none);
}

INSTANTIATE_TEST_SUITE_P(Links, Transport, ::testing::Values("udp", "shm"),
                         [](const auto& one) { return std::string(one.param); });

// A timer interrupts the reader at any instruction to write another message.
RobotLink* interrupting = nullptr;
volatile std::sig_atomic_t may_interrupt = 0, interruptions = 0;
std::array<std::byte, RobotLink::most_bytes> interrupting_message;

void interrupt(int) {
  if (may_interrupt == 0) return;
  interruptions = interruptions + 1;
  interrupting->send(interrupting_message);
}

TEST(SharedMemory, ReadersNeverSeeAPartOfAMessage) {
  const std::string name = "saltus_torn_" + std::to_string(::getpid());
  const auto controller = open_link("shm:" + name, LinkSide::controller);
  const auto robot = open_link("shm:" + name, LinkSide::robot);
  interrupting = robot.get();
  interrupting_message.fill(std::byte{1});
  const std::vector<std::byte> other(RobotLink::most_bytes, std::byte{2});
  struct sigaction action {
  }, before{};
  action.sa_handler = interrupt;
  ::sigaction(SIGALRM, &action, &before);
  const itimerval often{{0, 2000}, {0, 2000}}, never{};
  ::setitimer(ITIMER_REAL, &often, nullptr);
  long mixed = 0;
  const auto end = WallClock::now() + 300ms;
  while (WallClock::now() < end) {
    robot->send(other);
    may_interrupt = 1;
    const std::span<const std::byte> got = controller->receive(WallClock::now() + 1s);
    may_interrupt = 0;
    if (std::count(got.begin(), got.end(), got[0]) != std::ssize(got)) ++mixed;
  }
  ::setitimer(ITIMER_REAL, &never, nullptr);
  ::sigaction(SIGALRM, &before, nullptr);
  EXPECT_GT(interruptions, 0);
  EXPECT_EQ(mixed, 0);

  // A writer that has died in the middle leaves an odd count. The next one continues.
  controller->receive(WallClock::now());  // at most one message is left
  const std::string file = "/dev/shm/" + name;
  {
    std::fstream memory(file, std::ios::in | std::ios::out | std::ios::binary);
    std::uint32_t count = 0;
    memory.read(reinterpret_cast<char*>(&count), sizeof count);
    count += 1;
    memory.seekp(0);
    memory.write(reinterpret_cast<const char*>(&count), sizeof count);
  }
  EXPECT_TRUE(controller->receive(WallClock::now() + 5ms).empty());
  const std::vector<std::byte> message(16, std::byte{7});
  robot->send(message);
  EXPECT_EQ(controller->receive(WallClock::now() + 1s).size(), 16u);
  ::unlink(file.c_str());
}

TEST(Links, BelongToOneController) {
  const std::string name = "saltus_test_" + std::to_string(::getpid()), file = "/dev/shm/" + name;
  auto first = open_link("shm:" + name, LinkSide::controller);
  EXPECT_THROW(open_link("shm:" + name, LinkSide::controller), InputError);
  first.reset();
  EXPECT_NO_THROW(open_link("shm:" + name, LinkSide::controller));
  ::unlink(file.c_str());
}

TEST(Links, LeaveOtherSegmentsAlone) {
  const std::string name = "saltus_test_" + std::to_string(::getpid()), file = "/dev/shm/" + name;
  const int other = ::open(file.c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(::ftruncate(other, 100), 0);
  EXPECT_THROW(open_link("shm:" + name, LinkSide::controller), InputError);
  struct stat status {};
  ASSERT_EQ(::fstat(other, &status), 0);
  EXPECT_EQ(status.st_size, 100);
  ::close(other);
  ::unlink(file.c_str());
}

TEST(Protocol, HasRoomForTheJoints) {
  EXPECT_NO_THROW(Codec(std::vector<std::string>(203, "joint")));
  EXPECT_THROW(Codec(std::vector<std::string>(204, "joint")), DefinitionError);
}

TEST(Links, RejectBadAddresses) {
  for (const char* address :
       {"tcp:1", "udp:", "udp:70000", "udp:1x", "udp:nowhere:1", "udp:-1", "shm:", "shm:a/b", ""})
    EXPECT_THROW(open_link(address, LinkSide::controller), InputError) << address;
  EXPECT_THROW(open_link("udp:0", LinkSide::robot), InputError);
  EXPECT_THROW(open_link("shm:saltus_does_not_exist", LinkSide::robot), InputError);
  const auto first = open_link("udp:0", LinkSide::controller);
  EXPECT_THROW(open_link("udp:" + std::to_string(port_of(*first)), LinkSide::controller),
               InputError);
}

// ---- reactions

class Reactions : public ::testing::Test {
 protected:
  Reactions()
      : lines(read_recorded_run(SALTUS_RECORDED_RUN, biped.robot.joints())),
        controller(new_controller()),
        balance(controller, biped.start),
        control(balance, joints_of(biped.robot, biped.start.q), options()) {}

  BalanceController new_controller() const {
    return biped.controller(std::make_unique<TreeDynamics>(biped.robot), biped.sensor_estimator());
  }
  static ControlOptions options() {
    ControlOptions o;
    o.hold = 0.01;
    o.damp = 0.02;
    return o;
  }
  SensorMessage message(std::size_t k) const {
    const Robot::Readings& r = lines.at(k).readings;
    SensorMessage m;
    m.sequence = 100 + k;
    m.time = r.time;
    m.angular_velocity = r.angular_velocity;
    m.specific_force = r.specific_force;
    m.left = r.left;
    m.right = r.right;
    m.q = r.q;
    m.dq = VectorXd::Zero(r.q.size());
    return m;
  }
  void balance_until(std::size_t end) {
    for (std::size_t k = 0; k < end; ++k) ASSERT_NE(control.update(message(k)), nullptr) << k;
    ASSERT_EQ(control.state(), ControlState::balance) << control.fault();
  }
  // The soft stop after line k: springs around the last positions, then less and less, then
  // nothing.
  void expect_soft_stop(std::size_t k) {
    const VectorXd held = lines.at(k).readings.q;
    ASSERT_EQ(control.state(), ControlState::hold);
    EXPECT_EQ(control.command().commands.positions, held);
    EXPECT_GT(control.command().commands.stiffness.minCoeff(), 0.0);
    const Robot::Commands first = control.command().commands;
    bool has_damped = false;
    for (int i = 0; i < 40 && !control.is_over(); ++i) {
      const Robot::Commands& c = control.continue_stop(1e-3).commands;
      ASSERT_TRUE(c.torques.allFinite() && c.positions.allFinite());
      if (control.state() == ControlState::hold) {
        EXPECT_EQ(c.torques, first.torques);
        EXPECT_EQ(c.stiffness, first.stiffness);
      } else if (control.state() == ControlState::damp) {
        has_damped = true;
        EXPECT_EQ(c.damping, first.damping);
        EXPECT_LT(c.stiffness[0], first.stiffness[0]);
        EXPECT_LT(c.torques.norm(), first.torques.norm());
      }
    }
    EXPECT_TRUE(has_damped);
    ASSERT_TRUE(control.is_over());
    const Robot::Commands& c = control.command().commands;
    for (const VectorXd* part : {&c.torques, &c.velocities, &c.stiffness, &c.damping})
      EXPECT_TRUE(part->isZero(0.0));
  }

  walking::SyntheticBalance biped;
  std::vector<RecordedLine> lines;
  BalanceController controller;
  BalanceLink balance;
  RobotControl control;
};

// The commands are those of the BalanceController without a link, bit for bit.
TEST_F(Reactions, BalancesAsWithoutALinkAndDoesNotAllocate) {
  BalanceController alone = new_controller();
  alone.start(biped.start, lines.front().readings);
  control.update(message(0));
  alone.update(lines.front().readings);
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const SensorMessage readings = message(k);
    const saltus::testing::AllocationCount count;
    const CommandMessage* command = control.update(readings);
    control.prepare();
    ASSERT_EQ(count.made(), 0) << k;
    ASSERT_NE(command, nullptr);
    EXPECT_EQ(command->answers, readings.sequence);
    Robot::Readings same = lines[k].readings;
    same.has_new_positions = true;
    same.time = 1e-3 * static_cast<double>(k);
    EXPECT_EQ(command->commands.torques, alone.update(same).torques) << k;
  }
  EXPECT_EQ(control.counts().replaced, 0);
  EXPECT_EQ(control.lost(), 0);
}

TEST_F(Reactions, CountsLostLateAndDuplicateMessages) {
  balance_until(20);
  ASSERT_NE(control.update(message(23)), nullptr);  // 20, 21 and 22 are missing
  EXPECT_EQ(control.counts().replaced, 3);
  EXPECT_EQ(control.lost(), 3);
  EXPECT_EQ(control.update(message(21)), nullptr);  // late
  EXPECT_EQ(control.update(message(21)), nullptr);  // and again
  EXPECT_EQ(control.update(message(23)), nullptr);
  EXPECT_EQ(control.counts().late, 1);
  EXPECT_EQ(control.counts().duplicate, 2);
  EXPECT_EQ(control.lost(), 2);
  EXPECT_NEAR(control.balanced(), 0.024, 1e-12);
  EXPECT_EQ(control.state(), ControlState::balance);
}

// With interpolated readings the torques stay close to those with all readings.
TEST_F(Reactions, BridgesLostReadings) {
  BalanceController alone = new_controller();
  alone.start(biped.start, lines.front().readings);
  double worst = 0.0;
  for (std::size_t k = 0; k < 40; ++k) {
    const VectorXd& torques = alone.update(lines[k].readings).torques;
    if (k % 7 == 3) continue;
    const CommandMessage* command = control.update(message(k));
    ASSERT_NE(command, nullptr);
    worst = std::max(worst, (command->commands.torques - torques).lpNorm<Eigen::Infinity>());
  }
  EXPECT_GT(worst, 0.0);
  EXPECT_LT(worst, 5.0);  // Nm, of limits of 80 to 120 Nm
}

TEST_F(Reactions, StopsSoftlyAtNan) {
  for (const bool encoder : {true, false}) {
    BalanceController fresh = new_controller();
    BalanceLink link(fresh, biped.start);
    RobotControl one(link, joints_of(biped.robot, biped.start.q), options());
    for (std::size_t k = 0; k < 10; ++k) one.update(message(k));
    SensorMessage bad = message(10);
    (encoder ? bad.q[2] : bad.specific_force[1]) = nan;
    ASSERT_NE(one.update(bad), nullptr);
    EXPECT_EQ(one.state(), ControlState::hold);
    EXPECT_NE(one.fault().find("NaN; check th"), std::string::npos) << one.fault();
    EXPECT_EQ(one.fault().find(biped.robot.bodies[3].joint) != std::string::npos, encoder);
  }
  balance_until(10);
  SensorMessage bad = message(10);
  bad.q[2] = nan;
  control.update(bad);
  expect_soft_stop(9);
}

TEST_F(Reactions, StopsSoftlyWhenTheClockStops) {
  balance_until(10);
  SensorMessage bad = message(10);
  bad.time = lines[9].readings.time;
  control.update(bad);
  EXPECT_NE(control.fault().find("clock"), std::string::npos) << control.fault();
  expect_soft_stop(9);
}

TEST_F(Reactions, StopsSoftlyAtAJumpAndBeyondALimit) {
  balance_until(10);
  SensorMessage bad = message(10);
  bad.q[0] += 0.1;  // rad in 1 ms, with a limit of 10 rad/s
  control.update(bad);
  EXPECT_NE(control.fault().find("jumped"), std::string::npos) << control.fault();
  expect_soft_stop(9);

  BalanceController fresh = new_controller();
  BalanceLink link(fresh, biped.start);
  RobotControl one(link, joints_of(biped.robot, biped.start.q), options());
  for (std::size_t k = 0; k < 10; ++k) one.update(message(k));
  bad = message(10);
  bad.q[0] = biped.robot.bodies[1].position.upper + 0.1;
  one.update(bad);
  EXPECT_NE(one.fault().find("beyond its limits"), std::string::npos) << one.fault();
}

TEST_F(Reactions, CutsTorquesToTheLimits) {
  FloatingRobot weak = biped.robot;
  for (FloatingRobot::Body& body : weak.bodies) body.effort = 1.0;
  RobotControl one(balance, joints_of(weak, biped.start.q), options());
  ASSERT_NE(one.update(message(0)), nullptr);
  EXPECT_EQ(one.command().commands.torques.lpNorm<Eigen::Infinity>(), 1.0);
  EXPECT_EQ(one.cut(), 1);
}

TEST_F(Reactions, StopsSoftlyWhenTheRobotHasFallen) {
  BalanceLink strict(controller, biped.start, 1e-9);  // rad, less than the estimate at the start
  RobotControl one(strict, joints_of(biped.robot, biped.start.q), options());
  for (std::size_t k = 0; k < 20 && !one.is_stopping(); ++k) one.update(message(k));
  EXPECT_EQ(one.state(), ControlState::hold);
  EXPECT_NE(one.fault().find("has fallen: its base is inclined"), std::string::npos) << one.fault();
}

TEST_F(Reactions, StopsSoftlyAfterALongGap) {
  balance_until(10);
  ASSERT_NE(control.update(message(10 + 31 + 1)), nullptr);
  EXPECT_NE(control.fault().find("lost"), std::string::npos) << control.fault();
  expect_soft_stop(9);
}

TEST_F(Reactions, StopsSoftlyOnRequestWithoutAFault) {
  balance_until(10);
  SensorMessage last = message(10 + 50);  // also if shared memory has kept only the last request
  last.requests_stop = true;
  control.update(last);
  EXPECT_EQ(control.fault(), "");
  ASSERT_EQ(control.state(), ControlState::hold);
}

// A robot that is never driven needs no hold.
TEST_F(Reactions, ReleasesAtOnceBeforeTheStart) {
  control.stop();
  EXPECT_TRUE(control.is_over());
}

TEST_F(Reactions, MovesIntoThePostureBeforeItBalances) {
  SensorMessage m = message(0);
  m.q[0] += 0.3;
  m.sequence = 0;
  m.time = 0.0;
  ASSERT_NE(control.update(m), nullptr);
  ASSERT_EQ(control.state(), ControlState::stand);
  for (int k = 1; k < 3000 && control.state() == ControlState::stand; ++k) {
    m.sequence = static_cast<std::uint64_t>(k);
    m.time = 1e-3 * k;
    m.q = control.command().commands.positions;  // a robot that follows exactly
    control.update(m);
  }
  EXPECT_EQ(control.state(), ControlState::balance) << control.fault();
}

TEST_F(Reactions, NamesAJointThatDoesNotReachThePosture) {
  SensorMessage m = message(0);
  m.q[0] += 0.3;
  for (int k = 0; k < 5000 && !control.is_stopping(); ++k) {
    m.sequence = static_cast<std::uint64_t>(k);
    m.time = 1e-3 * k;
    control.update(m);
  }
  EXPECT_NE(control.fault().find(biped.robot.bodies[1].joint), std::string::npos)
      << control.fault();
}

// ---- stuck joints

constexpr double dt = 1e-3;

// Seconds until joint 1 of two is found stuck, or infinity after 3 s. `q` and `torque` are
// functions of time.
template <class Position, class Torque>
double found_after(Position q, Torque torque) {
  StuckJoints watch(Vec<double, 2>(10.0, 20.0), {});
  Robot::Commands c;
  for (VectorXd* part : {&c.torques, &c.positions, &c.velocities, &c.stiffness, &c.damping})
    *part = VectorXd::Zero(2);
  VectorXd at = Vec<double, 2>(0.0, q(0.0)), dq = VectorXd::Zero(2);
  watch.start(at);
  for (int k = 1; k <= 3000; ++k) {
    const double t = dt * k;
    at = Vec<double, 2>(0.1 * t, q(t));
    c.torques = Vec<double, 2>(5.0 * std::sin(20.0 * t), torque(t));
    const saltus::testing::AllocationCount count;
    const Eigen::Index found = watch.update(dt, at, dq, c);
    EXPECT_EQ(count.made(), 0);
    if (found < 0) continue;
    EXPECT_EQ(found, 1);
    return t;
  }
  return infinity;
}

TEST(Stuck, IsAJointWhoseTorqueGrowsWithoutMotion) {
  const auto still = [](double) { return 0.3; };
  // The torque rises by 7 Nm of 20 Nm at 1 s. It is noticed at the end of the second third of 0.3
  // s.
  const double t = found_after(still, [](double s) { return s < 1.0 ? 8.0 : 15.0; });
  EXPECT_GT(t, 1.1);
  EXPECT_LT(t, 1.31);
  EXPECT_LT(found_after(still, [](double s) { return s < 1.0 ? -3.0 : -18.5; }), 1.4);
}

TEST(Stuck, IsNotAJointThatHoldsALoadOrMoves) {
  const auto still = [](double) { return 0.3; };
  EXPECT_EQ(found_after(still, [](double) { return 15.0; }), infinity);
  EXPECT_EQ(found_after(still, [](double s) { return 8.0 + 3.0 * std::sin(5.0 * s); }), infinity);
  EXPECT_EQ(
      found_after([](double s) { return 0.01 * s; }, [](double s) { return s < 1.0 ? 8.0 : 19.0; }),
      infinity);
}

TEST(Stuck, IsAJointThatDoesNotMoveAtItsLargestTorque) {
  const double t = found_after([](double) { return 0.3; }, [](double) { return 19.0; });
  EXPECT_NEAR(t, 0.3, 0.01);
}

TEST(Stuck, IsNotWatchedWithoutATime) {
  StuckJoints watch(Vec<double, 1>(1.0), {.time = 0.0});
  Robot::Commands c;
  for (VectorXd* part : {&c.torques, &c.positions, &c.velocities, &c.stiffness, &c.damping})
    *part = VectorXd::Ones(1);
  const VectorXd q = VectorXd::Zero(1);
  watch.start(q);
  for (int k = 0; k < 1000; ++k) EXPECT_LT(watch.update(dt, q, q, c), 0);
}

// A controller that drives two joints without a load.
class Push final : public LinkController {
 public:
  void start(const SensorMessage&) override {}
  const Robot::Commands& update(double, const SensorMessage& readings) override {
    seen = readings;
    times.push_back(readings.time);
    return commands;
  }
  Robot::Commands commands{Vec<double, 2>(1.0, 9.5)};
  SensorMessage seen;
  std::vector<double> times;
};
SensorMessage of_two(std::uint64_t k) {
  SensorMessage m;
  m.sequence = k;
  m.time = dt * static_cast<double>(k);
  m.q = m.dq = VectorXd::Zero(2);
  return m;
}
std::vector<LinkJoint> two_joints() {
  LinkJoint hip, knee;
  hip.name = "hip";
  knee.name = "knee";
  hip.effort = knee.effort = 10.0;
  return {hip, knee};
}
const std::vector<LinkJoint> two = two_joints();

TEST(Stuck, StopsSoftlyAndNamesTheJoint) {
  Push push;
  RobotControl robot(push, two, {});
  std::uint64_t k = 0;
  for (; k < 1000 && !robot.is_stopping(); ++k) robot.update(of_two(k));
  EXPECT_NEAR(static_cast<double>(k), 300.0, 5.0);
  EXPECT_EQ(robot.state(), ControlState::hold);
  EXPECT_NE(robot.fault().find("knee has not moved for 0.30 s although"), std::string::npos)
      << robot.fault();
}

TEST(Plugin, StopsSoftlyAfterItsFirstFailure) {
  PluginController plugin(SALTUS_FAILING_PLUGIN, "", 2, dt);
  RobotControl robot(plugin, two, {});
  for (std::uint64_t k = 0; k < 2; ++k) {
    robot.update(of_two(k));
    robot.prepare();
    EXPECT_EQ(plugin.fault(), "");
  }
  ASSERT_EQ(robot.state(), ControlState::balance);
  robot.update(of_two(2));
  EXPECT_EQ(robot.state(), ControlState::hold);
  EXPECT_EQ(robot.fault(), "the controller of the plugin has failed: no memory for the tick");
}

TEST(MissingReadings, HaveTheirTimesAndThePaceOfTheRobot) {
  Push push;
  RobotControl robot(push, two, {});
  for (const std::uint64_t k : {0u, 1u, 4u}) {
    SensorMessage m = of_two(k);
    m.pace = 0.0;
    robot.update(m);
  }
  ASSERT_EQ(push.times.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_NEAR(push.times[k], dt * static_cast<double>(k), 1e-12) << k;
  EXPECT_EQ(push.seen.pace, 0.0);
}

// A controller that demands ten times the largest torque, and then reports a fault.
TEST(Stop, HoldsTorquesWithinTheLimits) {
  class Strong final : public LinkController {
   public:
    void start(const SensorMessage&) override {}
    const Robot::Commands& update(double, const SensorMessage&) override {
      ++updates;
      return commands;
    }
    std::string fault() const override { return updates > 3 ? "it is too strong" : ""; }
    Robot::Commands commands{Vec<double, 2>(-100.0, 100.0)};
    int updates = 0;
  } strong;
  RobotControl robot(strong, two, {});
  for (std::uint64_t k = 0; k < 4; ++k) robot.update(of_two(k));
  ASSERT_EQ(robot.state(), ControlState::hold);
  EXPECT_EQ(robot.cut(), 4);
  const Vec<double, 2> largest(-10.0, 10.0);
  EXPECT_EQ(robot.command().commands.torques, largest);
  const ControlOptions options;
  robot.continue_stop(options.hold + 0.5 * options.damp);
  ASSERT_EQ(robot.state(), ControlState::damp);
  EXPECT_TRUE(robot.command().commands.torques.isApprox(0.5 * largest, 1e-9));
  EXPECT_EQ(robot.cut(), 4);
}

TEST(Stuck, IsNotAJointWhoseCommandsDoNotAct) {
  Push push;
  RobotControl robot(push, two, {});
  for (std::uint64_t k = 0; k < 1000; ++k) {
    SensorMessage m = of_two(k);
    m.is_guarded = true;
    robot.update(m);
  }
  EXPECT_EQ(robot.state(), ControlState::balance) << robot.fault();
  EXPECT_EQ(robot.counts().guarded, 1000);
}

// ---- filters and gains

TEST(Filters, AreOfFirstOrder) {
  Push push;
  ControlOptions options;
  options.inertial_hz = options.force_hz = options.velocity_hz = options.torque_hz = 10.0;
  options.stuck.time = 0.0;
  RobotControl robot(push, two, options);
  robot.update(of_two(0));
  for (std::uint64_t k = 1; k <= 16; ++k) {  // a time constant: 1 / (2 pi 10 Hz) = 15.9 ms
    SensorMessage m = of_two(k);
    m.angular_velocity[1] = m.specific_force[2] = m.left[3] = m.right[5] = 1.0;
    m.dq[1] = 1.0;
    robot.update(m);
  }
  const double step = 1.0 - std::exp(-2.0 * 3.14159265358979 * 10.0 * 16e-3);
  for (const double value : {push.seen.angular_velocity[1], push.seen.specific_force[2],
                             push.seen.left[3], push.seen.right[5], push.seen.dq[1]})
    EXPECT_NEAR(value, step, 1e-9);
  EXPECT_EQ(push.seen.q[0], 0.0);
  const double torque_step = 1.0 - std::exp(-2.0 * 3.14159265358979 * 10.0 * 17e-3);
  EXPECT_NEAR(robot.command().commands.torques[0], torque_step, 1e-9);
}

TEST(Gains, AreMultiplesOfTheLargestTorque) {
  Push push;
  std::vector<LinkJoint> joints = two;
  joints[1].gain = 0.5;
  joints[1].start = 0.2;
  ControlOptions options;
  options.stiffness = 3.0;
  options.damping = 0.1;
  RobotControl robot(push, joints, options);
  robot.update(of_two(0));
  ASSERT_EQ(robot.state(), ControlState::stand);
  const Robot::Commands& c = robot.command().commands;
  EXPECT_EQ(c.stiffness, (Vec<double, 2>(30.0, 15.0)));
  EXPECT_EQ(c.damping, (Vec<double, 2>(1.0, 0.5)));
}

// ---- the robot file

TEST(LinkFile, ComesBackAsWritten) {
  std::vector<LinkJoint> joints = two;
  joints[0].speed = 4.0;
  joints[0].position = between(-1.0, 0.5);
  joints[1].gain = 0.25;
  joints[1].start = -0.125;
  ControlOptions options;
  options.period = 0.002;
  options.torque_hz = 50.0;
  options.stuck.change = 0.4;
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("saltus_link_" + std::to_string(::getpid()));
  std::ofstream(file) << to_link_file(joints, options);
  std::vector<LinkJoint> read;
  ControlOptions got;
  read_link_file(file, read, got);
  EXPECT_EQ(to_link_file(read, got), to_link_file(joints, options));
  EXPECT_EQ(read[0].position.upper, 0.5);
  EXPECT_EQ(got.torque_hz, 50.0);

  // A partial file adjusts existing values.
  std::ofstream(file) << "joints: {knee: {torque: 5}}\nguards: {near: 0.1}\n";
  read_link_file(file, read, got);
  EXPECT_EQ(read[1].effort, 5.0);
  EXPECT_EQ(read[1].gain, 0.25);
  EXPECT_EQ(got.near, 0.1);
  EXPECT_EQ(got.period, 0.002);
  for (const char* wrong :
       {"joints: {foot: {torque: 5}}\n", "joints: {knee: {torque: 0}}\n", "gains: {stiff: 1}\n",
        "joints: {hip: {start: 2}}\n", "gain: 1\n", "period: 0\n", "filters: {torque_hz: -1}\n"}) {
    std::ofstream(file) << wrong;
    EXPECT_THROW(read_link_file(file, read, got), InputError) << wrong;
  }
  EXPECT_EQ(read[1].effort, 5.0);
  std::filesystem::remove(file);
}

// ---- the loop

// The fake robot in its own process. `answers`: false for one that stops without a word.
class Loop : public Reactions {
 protected:
  Loop() : codec(joints()), link(open_link("udp:0", LinkSide::controller)) {}
  ~Loop() override {
    if (robot > 0) ::kill(robot, SIGKILL);
    if (robot > 0) ::waitpid(robot, nullptr, 0);
  }
  std::vector<std::string> joints() const {
    return names_of(joints_of(biped.robot, biped.start.q));
  }
  void start_robot(double pace, bool requests_stop) {
    const std::string address = "udp:" + std::to_string(port_of(*link));
    robot = ::fork();
    if (robot != 0) return;
    const auto side = open_link(address, LinkSide::robot);
    Codec own(joints());
    for (std::size_t k = 0; k < lines.size(); ++k) {
      SensorMessage m = message(k);
      m.pace = pace;
      m.requests_stop = requests_stop && k + 60 > lines.size();
      side->send(own.encode(m));
      side->receive(WallClock::now() + 5s);
    }
    ::_exit(0);
  }
  ProcessResult run(const ProcessOptions& options) {
    return run_control(
        *link, codec, control, options, [] { return false; }, nullptr);
  }

  Codec codec;
  std::unique_ptr<RobotLink> link;
  pid_t robot = 0;
};

TEST_F(Loop, EndsAtTheRequestOfTheRobot) {
  start_robot(0.0, true);
  const ProcessResult result = run({.silence = 10.0});
  EXPECT_EQ(result.end, ProcessResult::End::request);
  EXPECT_EQ(control.fault(), "");
  EXPECT_EQ(control.counts().used, static_cast<long>(lines.size()) - 59 + 31);
  EXPECT_EQ(result.answer.count(), control.counts().used);
}

TEST_F(Loop, StopsWhenTheRobotIsSilent) {
  start_robot(0.0, false);
  const ProcessResult result = run({.silence = 1.0, .patience = 1.0});
  EXPECT_EQ(result.end, ProcessResult::End::silence);
  EXPECT_NE(control.fault().find("no new message"), std::string::npos) << control.fault();
  EXPECT_EQ(control.counts().used, static_cast<long>(lines.size()));
}

// The robot sets the pace, but it does not decide how long the controller waits for it.
TEST_F(Loop, StopsWhenASlowRobotIsSilent) {
  start_robot(1e6, false);
  const ProcessResult result = run({.silence = 0.1, .patience = 0.5});
  EXPECT_EQ(result.end, ProcessResult::End::silence);
}

// A robot that has started again counts from zero, and its messages are old.
TEST_F(Loop, StopsWhenTheRobotOnlyRepeatsItself) {
  const auto side = open_link("udp:" + std::to_string(port_of(*link)), LinkSide::robot);
  std::atomic<bool> ends{false};
  std::thread again([&] {
    Codec own(joints());
    for (std::size_t k = 0; !ends; k = (k + 1) % 20) {
      SensorMessage m = message(k);
      m.pace = 1.0;
      side->send(own.encode(m));
      std::this_thread::sleep_for(1ms);
    }
  });
  const ProcessResult result = run({.silence = 0.2});
  ends = true;
  again.join();
  EXPECT_EQ(result.end, ProcessResult::End::silence);
}

TEST(RealTime, NamesAnImpossibleOption) {
  EXPECT_NO_THROW(apply({}));
  EXPECT_THROW(apply({.cpu = 100000}), InputError);
  EXPECT_THROW(apply({.priority = 1000}), InputError);
}

TEST_F(Loop, EndsWithoutARobot) {
  EXPECT_EQ(run({.arrival = 0.02}).end, ProcessResult::End::no_robot);
}

TEST_F(Loop, CountsForeignMessages) {
  const auto stranger = open_link("udp:" + std::to_string(port_of(*link)), LinkSide::robot);
  const std::vector<std::byte> noise(100);
  stranger->send(noise);
  EXPECT_EQ(run({.arrival = 0.2}).end, ProcessResult::End::no_robot);
  EXPECT_EQ(control.counts().refused, 1);
  EXPECT_EQ(control.last_refusal(), Refusal::foreign);
}

// The records of an MCAP file (https://mcap.dev/spec): opcode and content.
std::vector<std::pair<int, std::string>> mcap_records(const std::string& bytes) {
  std::vector<std::pair<int, std::string>> records;
  const std::string magic("\x89MCAP0\r\n", 8);
  EXPECT_EQ(bytes.substr(0, 8), magic);
  EXPECT_EQ(bytes.substr(bytes.size() - 8), magic);
  for (std::size_t at = 8; at + 9 <= bytes.size() - 8;) {
    std::uint64_t size = 0;
    std::memcpy(&size, &bytes[at + 1], sizeof size);
    records.emplace_back(bytes[at], bytes.substr(at + 9, size));
    at += 9 + size;
  }
  return records;
}

// Every row of the log is complete, in both formats.
TEST_F(Loop, LogsWhileItRuns) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("saltus_log_" + std::to_string(::getpid()));
  std::filesystem::create_directory(folder);
  {
    ControlLog log(folder, joints_of(biped.robot, biped.start.q), 2);
    for (std::size_t k = 0; k < 100; ++k) {
      control.update(message(k));
      SensorMessage readings = message(k);
      readings.q[0] = k == 4 ? nan : readings.q[0];
      if (k == 98) {  // after a long time
        readings.sequence = 12345678901;
        readings.time = 1700000000.125;
      }
      const saltus::testing::AllocationCount count;
      log.add(readings, control.command(), 1e-4, 0);
      ASSERT_EQ(count.made_by_this_thread(), 0);
    }
    EXPECT_EQ(log.dropped(), 0);
  }
  std::ifstream table(folder / "trajectory.csv");
  std::string line, last;
  long columns = -1, rows = 0;
  for (; std::getline(table, line); last = line) {
    const long commas = std::count(line.begin(), line.end(), ',');
    if (columns < 0) columns = commas;
    EXPECT_EQ(commas, columns);
    ++rows;
  }
  EXPECT_EQ(rows, 51);
  EXPECT_EQ(last.substr(0, 35), "1700000000.125,balance,12345678901,");

  std::ifstream file(folder / "run.mcap", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const auto records = mcap_records(bytes);
  ASSERT_EQ(records.size(), 3u + 50 + 2);  // header, schema, channel; data end, footer
  EXPECT_EQ(records[1].first, 3);
  EXPECT_EQ(records[2].first, 4);
  EXPECT_EQ(records.back().first, 2);
  std::uint64_t nanoseconds = 0;
  const std::string& third = records[5].second;
  EXPECT_EQ(records[5].first, 5);
  std::memcpy(&nanoseconds, &third[6], sizeof nanoseconds);
  EXPECT_EQ(nanoseconds, 4000000u);
  const std::string json = third.substr(22);
  EXPECT_EQ(json.substr(0, 40), R"({"timestamp":0.004,"mode":"balance","seq)");
  EXPECT_NE(json.find(":null,"), std::string::npos);
  EXPECT_EQ(std::count(json.begin(), json.end(), ':'), columns + 1);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace saltus::robots::control
