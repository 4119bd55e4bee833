// Runs work in parallel child processes, so that a crash affects only its own work.
//
// A forked child of this process does each piece of work. Libraries therefore need not be
// thread-safe, and their globals stay unchanged. The child returns a text.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "saltus/core/clock.hpp"

namespace saltus {

/// Outcome of a piece of work.
struct WorkResult {
  /// Finished, rejected (an InputError), or ended by the death of its process.
  enum class End { done, refused, died };

  long id = 0;          ///< id given to start()
  End end = End::died;  ///< how it ended
  /// `done`: the returned text. `refused`: the message of the InputError or DefinitionError.
  /// `died`: one sentence with the exception, signal or time limit.
  std::string text;
};

/// Runs at most `jobs` processes at a time. Its destructor ends running ones.
class ProcessPool {
 public:
  /// Work that takes longer than `time_limit` seconds is killed and counts as died. Throws
  /// DefinitionError unless jobs >= 1 and time_limit > 0.
  ProcessPool(int jobs, double time_limit);
  ~ProcessPool();
  ProcessPool(const ProcessPool&) = delete;
  ProcessPool& operator=(const ProcessPool&) = delete;

  /// True if `jobs` processes are running.
  bool is_full() const { return static_cast<int>(running_.size()) >= jobs_; }
  /// True if no process is running.
  bool is_idle() const { return running_.empty(); }
  /// Maximum number of parallel processes.
  int jobs() const { return jobs_; }

  /// Starts work in a child process; its result carries `id`. Output of the work on either stream
  /// is kept only to report why it died. The caller should not have other threads. Throws
  /// std::system_error if the system permits no further process or file, DefinitionError if the
  /// pool is full.
  void start(long id, const std::function<std::string()>& work);

  /// Waits at most `seconds` for results. Returns early on a signal.
  std::vector<WorkResult> wait(double seconds);

  /// Ends all running processes.
  void stop();

 private:
  struct Child {
    long id = 0;
    pid_t process = -1;
    int pipe = -1;
    std::string output;  // output so far
    WallClock::time_point begin;
    bool overdue = false;
  };

  double end_overdue();  // returns the time in seconds until the next one is overdue
  WorkResult collect(Child& child) const;

  int jobs_;
  double time_limit_;
  std::vector<Child> running_;
};

}  // namespace saltus
