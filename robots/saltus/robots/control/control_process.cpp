#include "saltus/robots/control/control_process.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <thread>
#include <vector>

#include "saltus/core/error.hpp"

namespace saltus::robots::control {
namespace {

using namespace std::chrono_literals;

double seconds_between(WallClock::time_point from, WallClock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}
WallClock::duration of_seconds(double s) {
  return std::chrono::duration_cast<WallClock::duration>(std::chrono::duration<double>(s));
}

long page_faults() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

}  // namespace

// ---- log

struct ControlLog::Writer {
  static constexpr std::size_t rows = 4096;

  std::FILE* file;
  std::size_t columns;
  std::vector<double> ring;
  std::atomic<std::size_t> written{0}, added{0};
  std::atomic<bool> ends{false};
  std::thread thread;

  void run() {
    for (;;) {
      const bool last = ends.load(std::memory_order_acquire);
      const std::size_t until = added.load(std::memory_order_acquire);
      for (std::size_t i = written.load(std::memory_order_relaxed); i < until; ++i) {
        const double* row = &ring[(i % rows) * columns];
        std::fprintf(file, "%.9g,%s", row[0],
                     describe(static_cast<ControlState>(static_cast<int>(row[1]))));
        for (std::size_t c = 2; c < columns; ++c) std::fprintf(file, ",%.9g", row[c]);
        std::fputc('\n', file);
        written.store(i + 1, std::memory_order_release);
      }
      std::fflush(file);
      if (last) return;
      std::this_thread::sleep_for(20ms);
    }
  }
};

ControlTable::ControlTable(const std::vector<LinkJoint>& joints)
    : columns_{"t [s]", "mode", "sequence", "answer [s]", "replaced"} {
  for (const auto& [kind, unit] :
       {std::pair{"q", "rad"}, std::pair{"dq", "rad/s"}, std::pair{"torque", "Nm"}})
    for (const LinkJoint& joint : joints)
      columns_.push_back(fmt::format("{}_{} [{}]", kind, joint.name, unit));
  for (const char* quantity : {"angular_velocity", "specific_force"})
    for (const char* axis : {"x", "y", "z"})
      columns_.push_back(
          fmt::format("{}_{} [{}]", quantity, axis, quantity[0] == 'a' ? "rad/s" : "m/s^2"));
  for (const char* foot : {"left", "right"})
    for (const char* part : {"fx [N]", "fy [N]", "fz [N]", "mx [Nm]", "my [Nm]", "mz [Nm]"})
      columns_.push_back(fmt::format("{}_{}", foot, part));
}

std::string ControlTable::header() const { return fmt::format("{}", fmt::join(columns_, ",")); }

ControlLog::ControlLog(const std::filesystem::path& file, const std::vector<LinkJoint>& joints,
                       int every)
    : writer_(std::make_unique<Writer>()), every_(every) {
  writer_->file = std::fopen(file.c_str(), "w");
  if (writer_->file == nullptr)
    throw InputError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(errno)));
  const ControlTable table(joints);
  std::fprintf(writer_->file, "%s\n", table.header().c_str());
  writer_->columns = table.columns().size();
  writer_->ring.resize(Writer::rows * writer_->columns);
  writer_->thread = std::thread([this] { writer_->run(); });
}

ControlLog::~ControlLog() {
  writer_->ends.store(true, std::memory_order_release);
  writer_->thread.join();
  std::fclose(writer_->file);
}

void ControlLog::add(const SensorMessage& r, const CommandMessage& command, double answer_seconds,
                     long replaced) {
  if (calls_++ % every_ != 0) return;
  const std::size_t i = writer_->added.load(std::memory_order_relaxed);
  if (i - writer_->written.load(std::memory_order_acquire) >= Writer::rows) {
    ++dropped_;
    return;
  }
  double* at = &writer_->ring[(i % Writer::rows) * writer_->columns];
  *at++ = r.time;
  *at++ = static_cast<double>(command.state);
  *at++ = static_cast<double>(r.sequence);
  *at++ = answer_seconds;
  *at++ = static_cast<double>(replaced);
  const auto copy = [&at](const auto& values) {
    for (const double v : values) *at++ = v;
  };
  copy(r.q);
  copy(r.dq);
  copy(command.commands.torques);
  copy(r.angular_velocity);
  copy(r.specific_force);
  copy(r.left);
  copy(r.right);
  writer_->added.store(i + 1, std::memory_order_release);
}

// ---- operating system

void apply(const RealTimeOptions& options) {
  if (options.cpu) {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (*options.cpu >= 0 && *options.cpu < CPU_SETSIZE)
      CPU_SET(static_cast<std::size_t>(*options.cpu), &set);
    if (::sched_setaffinity(0, sizeof set, &set) != 0)
      throw InputError(fmt::format("--cpu {}: {}; use a processor of this machine, from 0",
                                   *options.cpu, std::strerror(errno)));
  }
  if (options.priority) {
    const sched_param parameter{.sched_priority = *options.priority};
    if (::sched_setscheduler(0, SCHED_FIFO, &parameter) != 0)
      throw InputError(
          fmt::format("--priority {}: {}; use 1 to 99, and allow it (ulimit -r) or leave it out",
                      *options.priority, std::strerror(errno)));
  }
  if (options.lock_memory && ::mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    throw InputError(fmt::format(
        "--lock-memory: {}; allow it (ulimit -l unlimited) or leave it out", std::strerror(errno)));
}

// ---- loop

ProcessResult run_control(RobotLink& link, Codec& codec, RobotControl& control,
                          const ProcessOptions& options, const std::function<bool()>& stops,
                          ControlLog* log) {
  constexpr double look = 0.05;         // s, between two looks at `stops`
  constexpr double stop_period = 5e-3;  // s, between two commands without a robot
  ProcessResult result;
  SensorMessage readings;
  WallClock::time_point begin = WallClock::now(), last = begin, stop_sent = begin;
  double pace = 0.0, offset = infinity;
  long faults = page_faults();
  bool has_robot = false, is_silent = false, is_lost = false;
  while (!control.is_over()) {
    if (stops()) {
      if (!has_robot) break;
      control.stop();
    }
    const double wait = is_silent ? stop_period : look;
    const std::span<const std::byte> bytes = link.receive(WallClock::now() + of_seconds(wait));
    const WallClock::time_point arrival = WallClock::now();
    const CommandMessage* command = nullptr;
    const long replaced = control.counts().replaced;
    if (!bytes.empty()) {
      const Refusal refusal = codec.decode(bytes, readings);
      if (refusal == Refusal::none)
        command = control.update(readings);
      else
        control.note_refused(refusal);
    }
    if (command == nullptr) {
      const double silent = seconds_between(last, arrival);
      if (!has_robot) {
        if (silent > options.arrival) break;
        continue;
      }
      const bool waits = pace == 0.0 && !control.is_stopping();
      if (!is_silent &&
          silent > (waits ? options.patience
                          : std::max(options.silence,
                                     std::min(options.patience, pace * options.silence)))) {
        is_silent = true;
        is_lost = !control.is_stopping();
        control.stop(
            fmt::format("no new message from the robot for {:.3f} s; check its process and the "
                        "connection",
                        silent));
      }
      if (is_silent && seconds_between(stop_sent, arrival) >= stop_period) {
        link.send(codec.encode(control.continue_stop(stop_period)));
        stop_sent = arrival;
      }
      continue;
    }
    if (has_robot) {
      result.interval.add(seconds_between(last, arrival));
    } else {
      begin = arrival;
      faults = page_faults();
    }
    has_robot = true;
    last = arrival;
    pace = std::isfinite(readings.pace) ? std::max(readings.pace, 0.0) : 1.0;
    link.accept_sender();
    link.send(codec.encode(*command));
    const WallClock::time_point sent = WallClock::now();
    const double answered = seconds_between(arrival, sent);
    result.answer.add(answered);
    if (pace > 0.0) {
      const double stamp = pace * readings.time;
      offset = std::min(offset, seconds_between(begin, arrival) - stamp);
      result.stamp.add(std::max(0.0, seconds_between(begin, sent) - stamp - offset));
    }
    if (log != nullptr)
      log->add(readings, *command, answered, control.counts().replaced - replaced);
    control.prepare();
  }
  result.page_faults = page_faults() - faults;
  result.seconds = seconds_between(begin, WallClock::now());
  if (!has_robot)
    result.end = ProcessResult::End::no_robot;
  else if (is_lost)
    result.end = ProcessResult::End::silence;
  else if (!control.fault().empty())
    result.end = ProcessResult::End::fault;
  return result;
}

}  // namespace saltus::robots::control
