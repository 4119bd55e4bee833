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
#include <iterator>
#include <thread>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/robots/control/mcap_file.hpp"

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

  Writer(const std::filesystem::path& folder, const ControlTable& table)
      : names(table.columns()),
        mcap(folder / "run.mcap", "/trajectory", "saltus.trajectory", table.schema()),
        ring(rows * names.size()) {
    const std::filesystem::path csv = folder / "trajectory.csv";
    file = std::fopen(csv.c_str(), "w");
    if (file == nullptr)
      throw InputError(
          fmt::format("{}: cannot be written: {}", csv.string(), std::strerror(errno)));
    std::fprintf(file, "%s\n", table.header().c_str());
    for (std::string& name : names) name = ControlTable::without_unit(name);
    thread = std::thread([this] { run(); });
  }
  ~Writer() {
    ends.store(true, std::memory_order_release);
    thread.join();
    std::fclose(file);
  }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void write(const double* row) {
    line.clear();
    json.clear();
    const auto to = [](std::string& text) { return std::back_inserter(text); };
    fmt::format_to(to(line), "{}", row[0]);
    fmt::format_to(to(json), "{{\"timestamp\":{}", row[0]);
    const char* state = describe(static_cast<ControlState>(static_cast<int>(row[1])));
    fmt::format_to(to(line), ",{}", state);
    fmt::format_to(to(json), ",\"{}\":\"{}\"", names[1], state);
    for (std::size_t c = 2; c < names.size(); ++c) {
      number.clear();
      if (c == 2)  // sequence numbers have more than nine digits after eleven days
        fmt::format_to(to(number), "{:.0f}", row[c]);
      else
        fmt::format_to(to(number), "{:.9g}", row[c]);
      line += ',';
      line += number;
      fmt::format_to(to(json), ",\"{}\":{}", names[c], std::isfinite(row[c]) ? number : "null");
    }
    line += '\n';
    json += '}';
    std::fwrite(line.data(), 1, line.size(), file);
    mcap.add(row[0], json);
  }
  void run() {
    for (;;) {
      const bool last = ends.load(std::memory_order_acquire);
      const std::size_t until = added.load(std::memory_order_acquire);
      for (std::size_t i = written.load(std::memory_order_relaxed); i < until; ++i) {
        write(&ring[(i % rows) * names.size()]);
        written.store(i + 1, std::memory_order_release);
      }
      std::fflush(file);
      mcap.flush();
      if (last) return;
      std::this_thread::sleep_for(20ms);
    }
  }

  std::vector<std::string> names;
  McapFile mcap;
  std::FILE* file = nullptr;
  std::vector<double> ring;
  std::string line, json, number;  // of the thread
  std::atomic<std::size_t> written{0}, added{0};
  std::atomic<bool> ends{false};
  std::thread thread;
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

std::string ControlTable::without_unit(const std::string& column) {
  return column.substr(0, column.find(" ["));
}

std::string ControlTable::schema() const {
  std::string text = R"({"title":"saltus.trajectory","type":"object","properties":{)"
                     R"("timestamp":{"type":"number","description":"t [s]"})";
  for (std::size_t i = 1; i < columns_.size(); ++i)
    text += fmt::format(R"(,"{}":{{"type":{},"description":"{}"}})", without_unit(columns_[i]),
                        i == 1 ? R"("string")" : R"(["number","null"])", columns_[i]);
  return text + "}}";
}

ControlLog::ControlLog(const std::filesystem::path& folder, const std::vector<LinkJoint>& joints,
                       int every)
    : writer_(std::make_unique<Writer>(folder, ControlTable(joints))), every_(every) {}

ControlLog::~ControlLog() = default;

void ControlLog::add(const SensorMessage& r, const CommandMessage& command, double answer_seconds,
                     long replaced) {
  if (calls_++ % every_ != 0) return;
  const std::size_t i = writer_->added.load(std::memory_order_relaxed);
  if (i - writer_->written.load(std::memory_order_acquire) >= Writer::rows) {
    ++dropped_;
    return;
  }
  double* at = &writer_->ring[(i % Writer::rows) * writer_->names.size()];
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
