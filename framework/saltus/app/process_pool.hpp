// Work in processes of its own: several at a time, and one that crashes takes nothing with it.
//
// Each piece of work is done by a forked child of this process, so that it needs no thread-safe
// libraries and leaves none of their globals behind. The child hands back a text.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "saltus/core/clock.hpp"

namespace saltus {

/// How a piece of work ended.
struct FinishedWork {
  /// Ended with what it had to say, was refused (an InputError), or its process died.
  enum class End { done, refused, died };

  long id = 0;          ///< as given to start()
  End end = End::died;  ///< how it ended
  /// `done`: what the work returned. `refused`: the sentence of the InputError or DefinitionError
  /// that it threw. `died`: what happened (exception, signal, time limit), one sentence.
  std::string text;
};

/// At most `jobs` processes at a time. Its destructor ends those that still run.
class ProcessPool {
 public:
  /// Work that takes longer than `time_limit` seconds is ended and has died. Throws
  /// DefinitionError unless jobs >= 1 and time_limit > 0.
  ProcessPool(int jobs, double time_limit);
  ~ProcessPool();
  ProcessPool(const ProcessPool&) = delete;
  ProcessPool& operator=(const ProcessPool&) = delete;

  /// Whether as many run as may run at once.
  bool is_full() const { return static_cast<int>(running_.size()) >= jobs_; }
  /// Whether none runs.
  bool is_idle() const { return running_.empty(); }
  /// How many may run at once.
  int jobs() const { return jobs_; }

  /// Begins in a child; `id` comes back with the result. What the work prints on either stream is
  /// kept only to say why it died. The caller should not have other threads. Throws
  /// std::system_error if the system has no more processes or files, DefinitionError if full.
  void start(long id, const std::function<std::string()>& work);

  /// Waits until something has finished, at most `seconds`; returns early on a signal.
  std::vector<FinishedWork> wait(double seconds);

  /// Ends everything that still runs.
  void stop();

 private:
  struct Child {
    long id = 0;
    pid_t process = -1;
    int pipe = -1;
    std::string output;  // so far
    WallClock::time_point begin;
    bool overdue = false;
  };

  double end_overdue();  // returns the time until another is, s
  FinishedWork collect(Child& child) const;

  int jobs_;
  double time_limit_;
  std::vector<Child> running_;
};

}  // namespace saltus
