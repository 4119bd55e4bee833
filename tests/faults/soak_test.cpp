// Runs many ticks with random faults, edits and new data, while a second thread reads plans of the
// controller. Every tick must have an input, the counters must add up, and memory must not grow.
// SALTUS_SOAK_TICKS=10000000 sets the length of the run before a release, which prints its results.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <random>
#include <sstream>
#include <thread>
#include <utility>

#include "tests/faults/loop.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/sanitized.hpp"

namespace saltus::test {
namespace {

constexpr long ticks_of_a_test = 20000;

long resident_kilobytes() {
  long all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

// A separate thread that reads the last plan repeatedly, like a logger.
class Logger {
 public:
  Logger() : thread_([this] { read(); }) {}
  ~Logger() {
    stops_ = true;
    thread_.join();
  }
  Logger(const Logger&) = delete;
  Logger& operator=(const Logger&) = delete;

  void give(Solution plan) {
    const std::lock_guard lock(mutex_);
    plan_ = std::move(plan);
    has_plan_ = true;
  }
  /// Number of complete reads of plans, and number of values that differed on a second read.
  long reads() const { return reads_; }
  long changes() const { return changes_; }

 private:
  void read() {
    while (!stops_) {
      Solution plan;
      {
        const std::lock_guard lock(mutex_);
        if (!has_plan_) continue;
        plan = plan_;
      }
      try {
        read(plan.trajectory);
      } catch (...) {  // throwing formulas throw here too
      }
      ++reads_;
    }
  }
  void read(const Trajectory& plan) {
    for (const Trajectory::Piece& piece : plan.pieces()) {
      const double middle = piece.start + 0.5 * piece.length;
      const VectorXd once = plan.state_in(piece, middle), again = plan.state_in(piece, middle);
      // Faulty dynamics give NaN here too.
      changes_ += once == again || !once.allFinite() || !again.allFinite() ? 0 : 1;
    }
    std::ostringstream text;
    plan.write_csv(text, 2);
  }

  std::mutex mutex_;
  Solution plan_;
  bool has_plan_ = false;
  std::atomic<bool> stops_ = false;
  std::atomic<long> reads_ = 0, changes_ = 0;
  std::thread thread_;  // last member, because it uses all others
};

TEST(Soak, EveryTickHasAnInputWithoutAllocation) {
  const char* given = std::getenv("SALTUS_SOAK_TICKS");
  const long ticks = given != nullptr ? std::atol(given) : ticks_of_a_test;
  constexpr unsigned seed = 5;
  std::mt19937 random(seed);
  const auto chance = [&](double share) { return random() < share * 4294967296.0; };
  FaultyLoop loop, alone;  // with and without a logger
  Logger logger;
  long other_inputs = 0;
  constexpr long ticks_per_report = 50;
  Fault fault = Fault::none;
  long left = 0, unsound = 0, faulty = 0, slowest_return = 0, since = 0, allocations = 0;
  long resident_early = 0;
  for (long k = 0; k < ticks; ++k) {
    if (k == ticks / 100) resident_early = resident_kilobytes();
    if (left == 0 && fault != Fault::none) fault = Fault::none, since = 0;
    if (left == 0 && chance(0.01)) {
      fault = static_cast<Fault>(1 + random() % (static_cast<unsigned>(Fault::count) - 1));
      left = 1 + static_cast<long>(random() % 20);
    }
    left = std::max(0L, left - 1);
    if (chance(0.05)) {
      const double aim = static_cast<double>(random() % 1000) * 1e-3;
      loop.aim(aim);
      alone.aim(aim);
    }
    if (chance(0.1)) {
      loop.edit_schedule();
      alone.edit_schedule();
    }
    if (chance(0.01)) {
      loop.strike(0.2);
      alone.strike(0.2);
    }
    faulty += fault != Fault::none ? 1 : 0;
    const testing::AllocationCount count;
    const ControlTick& tick = loop.tick(fault);
    if (fault == Fault::none && k > 0) allocations += count.made_by_this_thread();
    if (k < ticks_of_a_test)
      other_inputs += alone.tick(fault).input.back().input() == tick.input.back().input() ? 0 : 1;
    if (k % ticks_per_report == 0) logger.give(loop.report());
    unsound += loop.input_is_sound() ? 0 : 1;
    if (fault == Fault::none) since = is_of_this_tick(tick.provenance) ? 0 : since + 1;
    slowest_return = std::max(slowest_return, since);
  }
  const LoopStatistics& statistics = loop.controller().statistics();
  const LatencyHistogram all = statistics.all();
  EXPECT_EQ(unsound, 0) << "seed " << seed;
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(other_inputs, 0) << "the logger changes the behaviour of the controller";
  EXPECT_GT(logger.reads(), 0);
  EXPECT_EQ(logger.changes(), 0);
  EXPECT_EQ(all.count(), ticks);
  EXPECT_EQ(statistics.preparation.count(), ticks);
  // A sanitizer keeps freed memory and detects leaks itself.
  if (!sanitized) {
    EXPECT_LE(resident_kilobytes() - resident_early, 1024);
  }
  EXPECT_LE(slowest_return, 2);  // the tick's own plan is back soon after the last fault
  if (ticks == ticks_of_a_test) return;
  fmt::print("{} ticks, {} of them with a fault; seed {}\n", ticks, faulty, seed);
  for (int p = 0; p < provenances; ++p)
    fmt::print("{:>9} {}\n", describe(static_cast<Provenance>(p)),
               statistics.count(static_cast<Provenance>(p)));
  fmt::print("us: median {:.1f}, p99 {:.1f}, p99.9 {:.1f}, p99.99 {:.1f}, longest {:.1f}\n",
             1e6 * all.median(), 1e6 * all.p99(), 1e6 * all.p999(), 1e6 * all.quantile(0.9999),
             1e6 * all.max());
  fmt::print("resident: {} kB after {} ticks, {} kB at the end; {} edits refused\n", resident_early,
             ticks / 100, resident_kilobytes(), loop.refused());
}

}  // namespace
}  // namespace saltus::test
