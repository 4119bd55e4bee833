// iCub in DART with simulated sensors, random pushes for a given time, and a restart after each
// fall. Every tick must give an input, falls are the only failures, and no memory may leak.
// SALTUS_PUSHED_SECONDS=3600 runs the hour before a release and prints the results.
// SALTUS_PUSHED_SEED sets the first seed instead of 1. Needs the URDF file named by
// SALTUS_ICUB_URDF.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "saltus/robots/walking/body_verdict.hpp"
#include "saltus/robots/walking/push.hpp"
#include "tests/problems/icub_in_dart.hpp"

namespace saltus::push_recovery {
namespace {

// Simulated time, s. A run ends at the latest after `longest_run`, which limits its records to a
// few hundred MB.
constexpr double of_a_test = 16.0, shortest_run = 8.0, longest_run = 120.0;

double number_of(const char* variable, double otherwise) {
  const char* given = std::getenv(variable);
  return given == nullptr ? otherwise : std::atof(given);
}

// Memory in use, without free memory that malloc retains.
struct Memory {
  double in_use = 0.0, resident = 0.0;  // kB

  static Memory now() {
    malloc_trim(0);
    long all = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> all >> resident;
    const struct mallinfo2 heap = mallinfo2();
    return {static_cast<double>(heap.uordblks + heap.hblkhd) / 1024.0,
            static_cast<double>(resident * sysconf(_SC_PAGESIZE)) / 1024.0};
  }
};

// All runs that began on one foot, or all that began on two.
struct Tally {
  int runs = 0, falls = 0, recovered = 0, pushes = 0, slips = 0;
  long ticks = 0, without_plan = 0, steps = 0;
  double seconds = 0.0, planning = 0.0, slip = 0.0, momentum = 0.0;
};

class LongRun : public IcubInDart {
 protected:
  // Runs at most until `until` (s) and adds the result to the tally.
  void run_once(bool on_two_feet, int seed, double until, Tally& tally, bool is_told) {
    config = Config();
    apply({"plant=dart", fmt::format("robot.urdf={}", urdf),
           on_two_feet ? "stance=both" : "stance=left", "push.start=1",
           "push.random.rate_hz=0.16667", fmt::format("push.random.until_s={:.3f}", until),
           fmt::format("push.random.seed={}", seed), fmt::format("sensor.seed={}", seed)});
    const RunLog log = run();
    const Verdict verdict = judge(config, log);
    ASSERT_FALSE(log.samples.empty());
    const double end = log.samples.back().time;
    const bool fell = log.stopped_early;
    EXPECT_FALSE(log.numerical_failure) << log.stop_reason;
    EXPECT_TRUE(fell || !log.control_failed())
        << log.control_failures << " of " << log.control_calls << " calls";
    EXPECT_EQ(log.statistics.all().count(), static_cast<long>(log.ticks.size()));
    for (const BipedSample& s : log.samples)
      if (!s.gamma.allFinite() || !s.wrenches.allFinite()) {
        ADD_FAILURE() << "no numbers at " << s.time << " s";
        break;
      }
    ASSERT_TRUE(verdict.body.has_value());
    const double slip = verdict.body->slip.maxCoeff();
    ++tally.runs;
    tally.falls += fell ? 1 : 0;
    tally.recovered += verdict.recovered ? 1 : 0;
    for (const Push& push : all_pushes(config.push, config.more_pushes))
      tally.pushes += push.start < end ? 1 : 0;
    tally.ticks += static_cast<long>(log.ticks.size());
    for (const LoopLog::Tick& tick : log.ticks)
      tally.without_plan += is_success(tick.status) ? 0 : 1;
    tally.steps += static_cast<long>(log.steps.size());
    tally.seconds += end;
    tally.planning += log.plan_seconds;
    if (!fell) {
      tally.slips += slip > planted_slip ? 1 : 0;
      tally.slip = std::max(tally.slip, slip);
      tally.momentum = std::max(tally.momentum, verdict.angular_momentum_max);
    }
    if (is_told)
      fmt::print("seed {}, from {}, {:.1f} s: {}; {} steps, slip {:.1f} mm, {:.2f} Nms\n", seed,
                 on_two_feet ? "two feet" : "one foot", end,
                 verdict.recovered ? "recovered" : verdict.reason, log.steps.size(), 1e3 * slip,
                 verdict.angular_momentum_max);
  }
};

TEST_F(LongRun, EveryTickHasAnInputAndMemoryIsConstant) {
  const double wanted = number_of("SALTUS_PUSHED_SECONDS", of_a_test);
  const int first_seed = static_cast<int>(number_of("SALTUS_PUSHED_SEED", 1.0));
  const bool is_campaign = std::getenv("SALTUS_PUSHED_SECONDS") != nullptr;
  const double length = std::clamp(wanted / 2.0, shortest_run, longest_run);
  Tally tallies[2];
  Memory early, now;
  int seed = first_seed, measured = 0;
  double most_resident = 0.0;
  for (; tallies[0].seconds + tallies[1].seconds < wanted - 1.0; ++seed) {
    const bool on_two_feet =
        tallies[1].seconds <= tallies[0].seconds;  // equal time on one foot and on two
    const double left = wanted - tallies[0].seconds - tallies[1].seconds;
    run_once(on_two_feet, seed, std::clamp(left, shortest_run, length), tallies[on_two_feet],
             is_campaign);
    if (HasFatalFailure()) return;
    now = Memory::now();
    most_resident = std::max(most_resident, now.resident);
    // One-time allocations of libraries exist after one run from two feet and one from one foot.
    if (++measured <= 2) early = now;
    if (is_campaign) {
      fmt::print("  in use {:.0f} kB, resident {:.0f} kB\n", now.in_use, now.resident);
      std::fflush(stdout);
    }
  }
  EXPECT_LE(now.in_use - early.in_use, 1024.0) << "kB, " << measured << " runs";
  if (!is_campaign) return;
  for (const Tally& t : tallies)
    fmt::print(
        "from {}: {:.0f} s in {} runs, {} pushes, {} steps; {} runs ended by a fall, {} recovered; "
        "in {} of those without a fall a foot slipped by more than {:.0f} mm, at most by {:.1f} "
        "mm, and they had at most {:.2f} Nms; {} of {} ticks without a plan of their own, {:.2f} "
        "ms of processor time "
        "per tick\n",
        &t == &tallies[1] ? "two feet" : "one foot", t.seconds, t.runs, t.pushes, t.steps, t.falls,
        t.recovered, t.slips, 1e3 * planted_slip, 1e3 * t.slip, t.momentum, t.without_plan, t.ticks,
        1e3 * t.planning / static_cast<double>(std::max(1L, t.ticks)));
  fmt::print(
      "seeds {} to {}; in use {:.0f} kB after {} runs, {:.0f} kB at the end; resident {:.0f} kB "
      "and {:.0f} kB, at most {:.0f} kB between runs\n",
      first_seed, seed - 1, early.in_use, std::min(measured, 2), now.in_use, early.resident,
      now.resident, most_resident);
}

}  // namespace
}  // namespace saltus::push_recovery
