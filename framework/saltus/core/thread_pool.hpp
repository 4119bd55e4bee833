// A fixed number of threads that share one task at a time.
//
// Suited to tasks of milliseconds: idle threads sleep and are woken through a lock. Control loops
// do not use it.
#pragma once

#include <memory>

namespace saltus {

/// Consists of the calling thread and threads() - 1 further threads. Runs one task at a time.
class ThreadPool {
 public:
  /// Throws DefinitionError unless threads >= 1.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// Number of threads, including the caller.
  int threads() const { return threads_; }

  /// Calls work(0) .. work(threads() - 1) in parallel and returns when all calls have returned. The
  /// calling thread runs work(0). If calls throw, rethrows the exception of the lowest index.
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
