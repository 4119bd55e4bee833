// Tests that the stored problems have their documented properties and that broken files are
// refused.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "benchmarks/chain_sqp.hpp"
#include "benchmarks/point_shift.hpp"
#include "benchmarks/recorded_sequence.hpp"
#include "saltus/core/error.hpp"
#include "saltus/model/derivative_check.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus::bench {
namespace {

std::filesystem::path stored(const char* name) {
  return std::filesystem::path(SALTUS_BENCHMARK_DATA) / name;
}

TEST(RecordedSequence, HasSixtyProblemsBeforeTheLanding) {
  const std::filesystem::path file = stored("step_recovery_sequence.json");
  EXPECT_LT(std::filesystem::file_size(file), 100'000u);
  const RecordedSequence sequence = read_sequence(file);
  ASSERT_EQ(sequence.problems.size(), 60u);
  EXPECT_EQ(sequence.intervals, 15);
  EXPECT_EQ(sequence.problems[0].start, nominal_start());
  for (int tick = 0; tick < 60; ++tick)
    EXPECT_EQ(sequence.problems[tick].landing, std::max(0, 22 - tick));
  // The robot is caught: the last state is nearly at rest above the feet.
  EXPECT_LT(sequence.problems[59].start.segment<3>(3).norm(), 0.05);
}

TEST(RecordedProblems, RejectBrokenFiles) {
  EXPECT_THROW(read_sequence("no_such_file.json"), InputError);
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("saltus_broken_" + std::to_string(::getpid()));
  for (const char* text :
       {"", "[]", "3", "{\"intervals\":15}", "{\"intervals\":15,\"problems\":[1,2]}",
        "{\"intervals\":15,\"problems\":[{\"landing\":1,\"start\":[1]},{}]}"}) {
    std::ofstream(file) << text;
    EXPECT_THROW(read_sequence(file), InputError) << text;
    EXPECT_THROW(read_chain(file), InputError) << text;
  }
  std::filesystem::remove(file);
}

TEST(HangingChain, ReferenceIsAnEquilibrium) {
  const ChainData data = read_chain(stored("hanging_chain.json"));
  const Vec<double, 21> rate = HangingChain{}(0.0, data.reference, Vec<double, 3>(0, 0, 0));
  // Rounding of terms of the size of gravity.
  EXPECT_LT(rate.cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(data.reference[HangingChain::end], HangingChain::end_position);
}

TEST(HangingChain, DerivativesMatchDifferences) {
  const ChainData data = read_chain(stored("hanging_chain.json"));
  VectorXd z(1 + 21 + 3);
  z << 0.0, data.start, 0.3, -0.2, 0.1;
  const DerivativeReport report = check_derivatives(make_function<21, 3, 0>(HangingChain{}), z);
  EXPECT_TRUE(report.ok) << to_string(report);
}

TEST(PointShift, NewFootTakesTheGuessAndTheRestIsShifted) {
  const qp::StageQp from = step_recovery_qp({4, 4}, nominal_start());
  const qp::StageQp to = step_recovery_qp({4, 3}, nominal_start());
  const qp::StagePoint guess = standing_guess(to);
  const qp::StageQp capacity = step_recovery_qp({4, 0}, nominal_start());
  qp::StagePoint solution(capacity), out(capacity);
  for (int k = 0; k <= 4; ++k) {
    solution.stages[k].x.setConstant(k);
    solution.stages[k].u.setConstant(10 + k);
    for (VectorXd& multipliers : solution.stages[k].group) multipliers.setConstant(100 + k);
  }
  shift_by_one_stage(from, solution, to, guess, out);
  EXPECT_EQ(out.stages[0].x, to.start);
  EXPECT_EQ(out.stages[1].x[0], 2.0);
  EXPECT_EQ(out.stages[1].u[5], 12.0);
  EXPECT_EQ(out.stages[1].group[0][3], 102.0);
  // Both feet are in contact from stage 3 on.
  EXPECT_EQ(out.stages[3].u, guess.stages[3].u);
  EXPECT_EQ(out.stages[3].group[0][3], 103.0);
  EXPECT_EQ(out.stages[3].group[1][3], 0.0);
  EXPECT_EQ(out.stages[4].group[0][3], 104.0);
  const VectorXd next =
      to.stages[3].A * out.stages[3].x + to.stages[3].B * out.stages[3].u + to.stages[3].b;
  EXPECT_LT((out.stages[4].x - next).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace saltus::bench
