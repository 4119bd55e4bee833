// The loop of `saltus control`: messages of the robot in, commands out, watchdog, log and times.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/robots/control/robot_control.hpp"
#include "saltus/robots/control/robot_link.hpp"

namespace saltus::robots::control {

/// Columns of the log.
class ControlTable {
 public:
  explicit ControlTable(const std::vector<LinkJoint>& joints);
  /// Names of the columns with their units: time and state, then numbers.
  const std::vector<std::string>& columns() const { return columns_; }
  /// First line of the table.
  std::string header() const;
  /// JSON Schema of a row as an object.
  std::string schema() const;
  /// Name of a column without its unit.
  static std::string without_unit(const std::string& column);

 private:
  std::vector<std::string> columns_;
};

/// Writes a table and an MCAP file while the loop runs. The loop copies rows into a ring, and a
/// thread writes them. Rows are dropped while the ring is full. Only the constructor and that
/// thread allocate.
class ControlLog {
 public:
  /// Creates trajectory.csv and run.mcap in the folder. Logs every `every`-th command. Throws
  /// InputError if they cannot be written.
  ControlLog(const std::filesystem::path& folder, const std::vector<LinkJoint>& joints, int every);
  ~ControlLog();
  ControlLog(const ControlLog&) = delete;
  ControlLog& operator=(const ControlLog&) = delete;

  /// Adds a row.
  void add(const SensorMessage& readings, const CommandMessage& command, double answer_seconds,
           long replaced);
  /// Rows that did not fit into the ring.
  long dropped() const { return dropped_; }

 private:
  struct Writer;
  std::unique_ptr<Writer> writer_;
  int every_;
  long calls_ = 0, dropped_ = 0;
};

/// Settings of the operating system for the calling thread.
struct RealTimeOptions {
  bool lock_memory = false;                    ///< keep all memory in RAM
  std::optional<int> priority = std::nullopt;  ///< SCHED_FIFO, 1 to 99
  std::optional<int> cpu = std::nullopt;       ///< the only processor
};
/// Applies the options. Throws InputError that names the option, the reason and the remedy.
void apply(const RealTimeOptions& options);

/// Options of run_control().
struct ProcessOptions {
  /// Time without a valid message after which the controller stops, s of the robot's clock.
  double silence = 0.1;
  double patience = 10.0;  ///< the same for a robot that waits for answers, s of our clock
  double arrival = 60.0;   ///< waiting time for the first message, s of our clock
};

/// Result of run_control().
struct ProcessResult {
  /// Reason of the end.
  enum class End {
    request,  ///< end of the duration, a signal, or a request of the robot
    fault,    ///< soft stop after a fault, see RobotControl::fault()
    silence,  ///< no message from the robot any more
    no_robot  ///< no valid message at all
  };
  End end = End::request;   ///< reason of the end
  LatencyHistogram answer;  ///< from the arrival of a message to its command, wall-clock time
  /// From the time stamp to the command, wall-clock time. The offset of the clocks is that of the
  /// fastest message. Empty for a robot that waits for answers.
  LatencyHistogram stamp;
  LatencyHistogram interval;  ///< between the arrivals of two messages with new readings
  long page_faults = 0;       ///< page faults of this process in the loop
  double seconds = 0.0;       ///< wall-clock time from the first message to the end
};

/// Runs until the soft stop is over. `stops` is polled and requests a stop. `log` may be null.
ProcessResult run_control(RobotLink& link, Codec& codec, RobotControl& control,
                          const ProcessOptions& options, const std::function<bool()>& stops,
                          ControlLog* log);

}  // namespace saltus::robots::control
