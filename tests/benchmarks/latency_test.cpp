// Tests that every instance of every case of `saltus bench latency` reaches its optimum.
#include "benchmarks/latency.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "benchmarks/statistics.hpp"
#include "saltus/core/error.hpp"

namespace saltus::bench {
namespace {

#ifdef NDEBUG
constexpr int solves = 100;  // as with --quick
#else
constexpr int solves = 3;  // sanitizers are slow
#endif

void expect_optimal(const std::string& only) {
  const LatencyReport report = measure_latency({.solves = solves, .only = only});
  for (const CaseResult& result : report.cases) {
    EXPECT_GT(result.n, 0) << result.name;
    // A residual above 1e-8 is a failure for any solver status; see Measurement::count.
    for (const Failure& f : result.failures) {
      ADD_FAILURE() << result.name << " seed " << f.seed << ": " << describe(f.status) << ", "
                    << f.residual;
    }
  }
}

TEST(Measurement, LargeResidualFailsForAnyStatus) {
  qp::QpResult optimal;
  optimal.status = qp::QpStatus::optimal;
  Measurement m("case");
  m.count(1.0, optimal, 0.9e-8, 1);
  m.count(1.0, optimal, 1.1e-8, 2);
  m.count(1.0, optimal, NAN, 3);
  m.count(1.0, qp::QpResult{}, 0.0, 4);
  const CaseResult result = m.result();
  ASSERT_EQ(result.failures.size(), 3u);
  EXPECT_EQ(result.failures[0].seed, 2u);
}

TEST(Latency, StepRecoveryBatchesAreSolved) { expect_optimal("recipe/"); }
TEST(Latency, RecordedSequenceIsSolved) { expect_optimal("sequence/"); }
TEST(Latency, BoxesAreSolved) { expect_optimal("box/"); }
TEST(Latency, HangingChainIsSolved) { expect_optimal("chain/"); }

TEST(Latency, CapturePointRowsAreActiveInBindingInstances) {
  const LatencyReport report = measure_latency({.solves = solves, .only = "recipe/binding"});
  ASSERT_EQ(report.cases.size(), 1u);
  ASSERT_EQ(report.cases[0].details.size(), 1u);
  EXPECT_GE(report.cases[0].details[0].value, 1.0);
}

TEST(Latency, WarmSolvesTakeFewerIterationsThanColdOnes) {
  const LatencyReport report = measure_latency({.solves = solves, .only = "sequence/"});
  ASSERT_EQ(report.cases.size(), 2u);
  EXPECT_LT(report.find("sequence/warm")->iterations_mean,
            report.find("sequence/cold")->iterations_mean);
}

TEST(Latency, RejectsAnUnknownCase) {
  EXPECT_THROW(measure_latency({.solves = 1, .only = "no such case"}), InputError);
}

TEST(Statistics, MatchAHundredNumbers) {
  std::vector<double> numbers;
  for (int i = 100; i >= 1; --i) numbers.push_back(i);
  const Spread s = spread(numbers);
  EXPECT_EQ(s.median, 50.5);
  EXPECT_EQ(s.p99, 99.0);
  EXPECT_EQ(s.max, 100.0);
  EXPECT_EQ(spread({7.0}).p99, 7.0);
}

}  // namespace
}  // namespace saltus::bench
