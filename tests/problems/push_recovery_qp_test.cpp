// The push recovery problem reproduces independently computed optima.
#include <gtest/gtest.h>

#include "benchmarks/push_recovery_cases.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/replay.hpp"

namespace saltus::push_recovery {
namespace {

class NumericInstance : public testing::TestWithParam<const char*> {};

TEST_P(NumericInstance, CostStatesAndWrenchesMatchThePublication) {
  const QpCase c = read_case(GetParam());
  MultipleShooting shooting = transcribe(c);
  const auto solver = make_ipopt({.tolerance = 1e-10});
  const Solution solution = solve(shooting, *solver);
  ASSERT_EQ(solution.status, SolveStatus::optimal) << solution.message;
  EXPECT_NEAR(solution.cost, c.optimum, 1e-6 * c.optimum);
  EXPECT_LT(solution.kkt.scaled(), 1e-7);
  int k = 0;
  for (const Trajectory::Piece& piece : solution.trajectory.pieces()) {
    EXPECT_LT((piece.state - c.gamma.row(k).transpose()).cwiseAbs().maxCoeff(), 1e-5) << k;
    EXPECT_LT((piece.coefficients - c.f.row(k).transpose()).cwiseAbs().maxCoeff(), 0.05) << k;
    ++k;
  }
  EXPECT_EQ(k, c.model.intervals);
  EXPECT_LT((solution.trajectory.final_state() - c.gamma.row(k).transpose()).cwiseAbs().maxCoeff(),
            1e-5);
}

TEST_P(NumericInstance, PlanHoldsUnderAnotherIntegrator) {
  const QpCase c = read_case(GetParam());
  MultipleShooting shooting = transcribe(c);
  const Solution solution = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  const ReplayReport report =
      replay(shooting.problem(), solution.trajectory,
             cvodes({.method = CvodesOptions::Method::Adams, .tolerance = 1e-12}));
  ASSERT_TRUE(report.completed);
  EXPECT_LT(report.from_nodes, 1e-8);
  EXPECT_LT(report.from_start, 1e-8) << "the flow grows by " << report.flow_growth;
}

INSTANTIATE_TEST_SUITE_P(Cases, NumericInstance, testing::Values("ICUB-1", "ICUB-3"),
                         [](const auto& instance) {
                           return std::string(instance.param) == "ICUB-1" ? "ImpactInside"
                                                                          : "ImpactBeyond";
                         });

}  // namespace
}  // namespace saltus::push_recovery
