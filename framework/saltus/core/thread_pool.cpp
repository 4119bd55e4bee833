#include "saltus/core/thread_pool.hpp"

#include <fmt/format.h>

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "saltus/core/error.hpp"

namespace saltus {

struct ThreadPool::State {
  explicit State(int threads) : failures(threads) {
    try {
      for (int k = 1; k < threads; ++k) workers.emplace_back([this, k] { serve(k); });
    } catch (...) {  // stops the threads that run already: joining them would hang otherwise
      end();
      throw;
    }
  }
  ~State() { end(); }

  void end() {
    {
      const std::lock_guard lock(mutex);
      is_ending = true;
    }
    begins.notify_all();
    workers.clear();  // joins
  }

  void serve(int k) {
    long done = 0;
    std::unique_lock lock(mutex);
    for (;;) {
      begins.wait(lock, [&] { return is_ending || piece != done; });
      if (is_ending) return;
      done = piece;
      lock.unlock();
      take_part(k);
      lock.lock();
      if (--at_work == 0) ends.notify_one();
    }
  }

  void take_part(int k) {
    try {
      work(of, k);
    } catch (...) {
      failures[k] = std::current_exception();
    }
  }

  std::mutex mutex;
  std::condition_variable begins, ends;
  long piece = 0;  // counts the tasks
  int at_work = 0;
  bool is_ending = false;
  const void* of = nullptr;
  void (*work)(const void*, int) = nullptr;
  std::vector<std::exception_ptr> failures;
  std::vector<std::jthread> workers;
};

ThreadPool::ThreadPool(int threads) : threads_(threads) {
  constexpr int most_threads = 4096;
  if (threads < 1 || threads > most_threads)
    throw DefinitionError(
        fmt::format("the number of threads must be 1 to {}, not {}", most_threads, threads));
  state_ = std::make_unique<State>(threads);
}

ThreadPool::~ThreadPool() = default;

void ThreadPool::run_erased(const void* of, void (*work)(const void*, int)) {
  State& s = *state_;
  {
    const std::lock_guard lock(s.mutex);
    s.of = of;
    s.work = work;
    s.at_work = threads_ - 1;
    ++s.piece;
  }
  s.begins.notify_all();
  s.take_part(0);
  std::unique_lock lock(s.mutex);
  s.ends.wait(lock, [&] { return s.at_work == 0; });
  std::exception_ptr first;
  for (std::exception_ptr& failure : s.failures) {
    if (failure && !first) first = failure;
    failure = nullptr;
  }
  if (first) std::rethrow_exception(first);
}

}  // namespace saltus
