// A fixed number of threads that take part in one piece of work after the other.
//
// For work that takes milliseconds: threads sleep between pieces and are woken through a lock. No
// control path has one.
#pragma once

#include <memory>

namespace saltus {

/// The calling thread and threads() - 1 of its own. One piece of work at a time.
class ThreadPool {
 public:
  /// Throws DefinitionError unless threads >= 1.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// How many work, the caller included.
  int threads() const { return threads_; }

  /// Calls work(0) .. work(threads() - 1), each on a thread of its own, work(0) on that of the
  /// caller, and returns when all have returned. If some have thrown, what the first of them in
  /// this order threw is thrown again.
  template <class Work>
  void run(const Work& work) {
    run_erased(&work, [](const void* of, int k) { (*static_cast<const Work*>(of))(k); });
  }

 private:
  struct State;
  void run_erased(const void* of, void (*work)(const void*, int));

  int threads_;
  std::unique_ptr<State> state_;
};

}  // namespace saltus
