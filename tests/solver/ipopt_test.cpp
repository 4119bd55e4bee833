// Ipopt behind the solver interface: statuses, limits, warm starts, and no output.
#include "saltus/solver/ipopt.hpp"

#include <gtest/gtest.h>

#include "tests/solver/small_programs.hpp"

namespace saltus {
namespace {

using testing_support::Rosenbrock;

const NlpPoint far_start{Vec<double, 2>{-1.2, 1.0}, {}, {}};

NlpResult run(Rosenbrock& program, const IpoptOptions& options = {}) {
  return make_ipopt(options)->solve(program, far_start, false);
}

TEST(Ipopt, FindsTheOptimumAndOurResidualAgrees) {
  Rosenbrock program;
  const NlpResult result = run(program);
  EXPECT_EQ(result.status, SolveStatus::optimal);
  EXPECT_NEAR(result.point.w[0], 1.0, 1e-7);
  EXPECT_LT(result.kkt.scaled(), 1e-7);
  EXPECT_EQ(result.hessian, "exact");
  EXPECT_GT(result.iterations, 0);
}

TEST(Ipopt, MultipliersHaveTheSignOfTheActiveBound) {
  Rosenbrock program;
  program.upper_[0] = 0.5;  // the optimum lies at (0.5, 0.25), df/da = -1
  const NlpResult upper = run(program);
  EXPECT_NEAR(upper.point.z[0], 1.0, 1e-6);
  EXPECT_LT(upper.kkt.scaled(), 1e-7);
  program.upper_[0] = infinity;
  program.row_upper_[0] = 0.75;  // same optimum, by a move along the row
  const NlpResult row = run(program);
  EXPECT_GT(row.point.lambda[0], 0.0);
  EXPECT_LT(row.kkt.scaled(), 1e-7);
  program.row_upper_[0] = infinity;
  program.row_lower_[0] = 4.0;
  EXPECT_LT(run(program).point.lambda[0], 0.0);
}

TEST(Ipopt, IsAcceptableOnlyWithinAMultipleOfTheTolerance) {
  Rosenbrock program;
  for (const char* looser : {"1e2", "1e-3", "1e-5"}) {
    const NlpResult result = run(program, {.named = {{"acceptable_tol", looser},
                                                     {"acceptable_iter", "1"},
                                                     {"acceptable_dual_inf_tol", "1e10"}}});
    EXPECT_EQ(is_success(result.status), result.kkt.scaled() <= 100 * IpoptOptions().tolerance)
        << describe(result.status) << " at " << result.kkt.scaled();
  }
}

TEST(Ipopt, BoundsAreNotRelaxed) {
  Rosenbrock program;
  program.upper_[0] = 0.5;
  EXPECT_LE(run(program).point.w[0], 0.5);
}

TEST(Ipopt, EqualBoundsRemoveAVariable) {
  Rosenbrock program;
  program.lower_[0] = program.upper_[0] = 0.3;
  const NlpResult result = run(program);
  EXPECT_EQ(result.status, SolveStatus::optimal);
  EXPECT_EQ(result.point.w[0], 0.3);
  EXPECT_NEAR(result.point.w[1], 0.09, 1e-7);
  EXPECT_LT(result.kkt.scaled(), 1e-7);
}

// min -b with a^2 = 2, a b = 3 and further rows a + b without sides. Two equations determine the
// point, so Ipopt stops as soon as they hold.
class TwoEquations : public testing_support::OfTwoVariables {
 public:
  explicit TwoEquations(int free_rows) : OfTwoVariables(2 + free_rows) {
    row_lower_[0] = row_upper_[0] = 2.0;
    row_lower_[1] = row_upper_[1] = 3.0;
    lower_.setZero();
    upper_.setConstant(1e5);
  }
  bool objective(const double* w, double& f) override {
    f = -w[1];
    return true;
  }
  bool gradient(const double*, double* g) override {
    g[0] = 0.0;
    g[1] = -1.0;
    return true;
  }
  bool constraints(const double* w, double* g) override {
    g[0] = w[0] * w[0];
    g[1] = w[0] * w[1];
    for (int r = 2; r < rows(); ++r) g[r] = w[0] + w[1];
    return true;
  }
  bool jacobian(const double* w, double* entries) override {
    for (int r = 2; r < rows(); ++r) entries[2 * r] = entries[2 * r + 1] = 1.0;
    entries[0] = 2.0 * w[0];
    entries[1] = 0.0;
    entries[2] = w[1];
    entries[3] = w[0];
    return true;
  }
  bool hessian(const double*, double, const double* lambda, double* entries, Curvature) override {
    entries[0] = 2.0 * lambda[0];
    entries[1] = lambda[1];
    entries[2] = 0.0;
    return true;
  }
};

TEST(Ipopt, RowsWithoutSidesChangeNothing) {
  const NlpPoint start{Vec<double, 2>{1.0, 1.0}, {}, {}};
  TwoEquations alone(0), with_free_rows(3);
  const NlpResult base = make_ipopt()->solve(alone, start, false);
  ASSERT_EQ(base.status, SolveStatus::optimal);
  const auto ipopt = make_ipopt();
  const NlpResult same = ipopt->solve(with_free_rows, start, false);
  EXPECT_EQ(same.status, SolveStatus::optimal);
  EXPECT_EQ(same.iterations, base.iterations);
  EXPECT_EQ(same.point.w, base.point.w);
  EXPECT_EQ(same.point.lambda.head(2), base.point.lambda);
  EXPECT_EQ(same.point.lambda.tail(3), VectorXd::Zero(3));
  // The problem kept between solves adds a row as soon as it has a side.
  with_free_rows.row_upper_[3] = 3.0;  // a + b = 3.53 there
  EXPECT_EQ(ipopt->solve(with_free_rows, start, false).status, SolveStatus::infeasible);
}

TEST(Ipopt, WithoutSecondDerivativesFallsBackToLimitedMemory) {
  Rosenbrock program;
  program.has_curvature = false;
  const NlpResult result = run(program);
  EXPECT_TRUE(is_success(result.status));
  EXPECT_EQ(result.hessian, "limited-memory BFGS");
  EXPECT_NEAR(result.point.w[0], 1.0, 1e-5);
}

// --- statuses -----------------------------------------------------------------------------------

TEST(IpoptStatus, ReportsTheIterationLimit) {
  Rosenbrock program;
  const NlpResult result = run(program, {.max_iterations = 3});
  EXPECT_EQ(result.status, SolveStatus::iteration_limit);
  EXPECT_EQ(result.iterations, 3);
  EXPECT_EQ(result.point.w.size(), 2);  // still the last iterate
}

TEST(IpoptStatus, TimeLimitIsWallClock) {
  Rosenbrock program;
  program.seconds_per_evaluation = 0.02;  // sleeps, so no processor time passes
  const NlpResult result = run(program, {.time_limit = 0.1});
  EXPECT_EQ(result.status, SolveStatus::time_limit);
  EXPECT_GE(result.seconds, 0.1);
  EXPECT_LT(result.seconds, 1.0);  // one iteration needs a few evaluations
}

TEST(IpoptStatus, ReportsInfeasibility) {
  Rosenbrock program;
  program.lower_.setZero();
  program.row_upper_[0] = -1.0;
  const NlpResult result = run(program);
  EXPECT_EQ(result.status, SolveStatus::infeasible);
  EXPECT_EQ(result.kkt.worst_row, 0);
  EXPECT_NEAR(result.kkt.feasibility, 1.0, 1e-3);
}

TEST(IpoptStatus, CrossedBoundsAreAnInvalidProblem) {
  Rosenbrock program;
  program.lower_[1] = 2.0;
  program.upper_[1] = 1.0;
  EXPECT_EQ(run(program).status, SolveStatus::invalid_problem);
}

TEST(IpoptStatus, InfiniteBoundsAreAnInvalidProblem) {
  Rosenbrock program;
  program.row_lower_[0] = infinity;
  EXPECT_EQ(run(program).status, SolveStatus::invalid_problem);
}

TEST(IpoptStatus, AStartOfTheWrongSizeIsAnInvalidProblem) {
  Rosenbrock program;
  const NlpResult result =
      make_ipopt()->solve(program, {Vec<double, 3>{1.0, 1.0, 1.0}, {}, {}}, false);
  EXPECT_EQ(result.status, SolveStatus::invalid_problem);
}

TEST(IpoptStatus, InvalidOptionsAreAnInvalidProblem) {
  Rosenbrock program;
  EXPECT_EQ(run(program, {.bound_relaxation = -1.0}).status, SolveStatus::invalid_problem);
}

TEST(IpoptStatus, ReportsAFailedEvaluation) {
  Rosenbrock program;
  program.fails = true;
  EXPECT_EQ(run(program).status, SolveStatus::evaluation_failed);
}

TEST(IpoptStatus, ReportsAnUnboundedProgram) {
  class Slope final : public Rosenbrock {
    bool objective(const double* w, double& f) override {
      f = w[0] + w[1];
      return true;
    }
    bool gradient(const double*, double* g) override {
      g[0] = g[1] = 1.0;
      return true;
    }
    bool hessian(const double*, double, const double*, double* e, Curvature) override {
      e[0] = e[1] = e[2] = 0.0;
      return true;
    }
  } program;
  EXPECT_EQ(run(program).status, SolveStatus::unbounded);
}

TEST(SolveStatus, EveryValueHasItsSentence) {
  std::vector<std::string> sentences;
  for (int s = 0; s <= static_cast<int>(SolveStatus::invalid_problem); ++s)
    sentences.emplace_back(describe(static_cast<SolveStatus>(s)));
  std::sort(sentences.begin(), sentences.end());
  EXPECT_EQ(std::unique(sentences.begin(), sentences.end()), sentences.end());
  EXPECT_EQ(std::find(sentences.begin(), sentences.end(), "unknown status"), sentences.end());
}

// --- warm starts and silence
// ----------------------------------------------------------------------

TEST(Ipopt, WarmStartNeedsFewerIterations) {
  Rosenbrock program;
  program.upper_[0] = 0.5;
  program.row_upper_[0] = 0.7;
  const auto solver = make_ipopt();
  const NlpResult cold = solver->solve(program, far_start, false);
  ASSERT_EQ(cold.status, SolveStatus::optimal);
  const NlpResult warm = solver->solve(program, cold.point, true);
  ASSERT_EQ(warm.status, SolveStatus::optimal);
  EXPECT_LT(warm.iterations, cold.iterations / 2);
  EXPECT_NEAR(warm.objective, cold.objective, 1e-8);
  // A warm start also works after a small change of the problem.
  program.row_upper_[0] = 0.69;
  const NlpResult moved = solver->solve(program, cold.point, true);
  ASSERT_EQ(moved.status, SolveStatus::optimal);
  EXPECT_LT(moved.iterations, cold.iterations);
}

TEST(Ipopt, NeverPrintsUnlessAsked) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Rosenbrock program;
  run(program);
  run(program, {.max_iterations = 2});
  run(program, {.bound_relaxation = -1.0});
  program.fails = true;
  run(program);
  program.fails = false;
  program.lower_.setZero();
  program.row_upper_[0] = -1.0;
  run(program);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace saltus
