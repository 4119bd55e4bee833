// The rows of docs/promise.md on searches over modes, derivatives of an optimum and quadratic
// programs. Several threads search one graph at once, and each call of a search, of
// OptimumDerivatives and of a QP solver may come from another thread. The results are bit-identical
// to those of a single thread.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "problems/library/mode_graphs.hpp"
#include "saltus/core/random.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/sequences/sequence_search.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/optimum_derivatives.hpp"
#include "tests/support/random_qp.hpp"

namespace saltus {
namespace {

// Executes a call, possibly in another thread.
using Place = std::function<void(const std::function<void()>&)>;
void here(const std::function<void()>& call) { call(); }
void on_a_thread_of_its_own(const std::function<void()>& call) { std::jthread{call}; }

using Numbers = std::vector<double>;
void append(Numbers& numbers, const VectorXd& values) {
  numbers.insert(numbers.end(), values.begin(), values.end());
}

void append(Numbers& numbers, const SequenceResult& result) {
  for (const double number : {result.cost, result.lower_bound, static_cast<double>(result.nodes),
                              static_cast<double>(result.iterations)})
    numbers.push_back(number);
  for (const int mode : result.modes) numbers.push_back(mode);
  for (const VectorXd& state : result.states) append(numbers, state);
  for (const VectorXd& input : result.inputs) append(numbers, input);
  append(numbers, result.solution.point.w);
}

ModeGraph tanks() { return library::two_tanks(Vec<double, 2>{0.1, 0.3}); }

// A search and two ticks after it. `place` executes each call.
Numbers search(const ModeGraph& graph, double level, const Place& place) {
  Numbers numbers;
  std::unique_ptr<SequenceSearch> search;
  place([&] { search = std::make_unique<SequenceSearch>(graph, SearchOptions{.phases = 4}); });
  SequenceResult result;
  place([&] { result = search->solve(Vec<double, 2>{level, 0.3}); });
  append(numbers, result);
  for (int tick = 0; tick < 2; ++tick) {
    const VectorXd state = result.states[1];
    place([&] { result = search->solve_next(state); });
    EXPECT_EQ(result.guarantee, SequenceResult::Guarantee::optimal) << result.message;
    append(numbers, result);
  }
  place([&] { search.reset(); });
  return numbers;
}

TEST(PromiseOfSearches, OneGraphIsSearchedBySeveralThreads) {
  const ModeGraph graph = tanks();
  constexpr int count = 4;
  const auto level = [](int i) { return 0.1 + 0.02 * i; };
  std::vector<Numbers> alone, together(count);
  for (int i = 0; i < count; ++i) alone.push_back(search(tanks(), level(i), here));
  {
    std::vector<std::jthread> threads;
    threads.reserve(count);
    for (int i = 0; i < count; ++i)
      threads.emplace_back([&, i] { together[i] = search(graph, level(i), here); });
  }
  EXPECT_EQ(alone, together);
}

TEST(PromiseOfSearches, EachCallMayComeFromAnotherThread) {
  EXPECT_EQ(search(tanks(), 0.1, here), search(tanks(), 0.1, on_a_thread_of_its_own));
}

// A pendulum with limited torque. Gravity is a data parameter.
OptimalControlProblem pendulum() {
  Phase<2, 1, 1> phase{"swing",
                       [](const auto&, const auto& x, const auto& u, const auto& p) {
                         return std::decay_t<decltype(x)>{x[1], u[0] - p[0] * sin(x[0])};
                       },
                       exactly(1.5)};
  phase.data("gravity", Vec<double, 1>{3.0})
      .bound_input(0, between(-2.0, 2.0))
      .minimise("effort",
                [](const auto&, const auto&, const auto& u, const auto&) { return u[0] * u[0]; })
      .track_at_end(
          "upright",
          [](const auto&, const auto& x) {
            return std::decay_t<decltype(x)>{x[0] - 1.0, x[1]};
          },
          Vec<double, 2>{10.0, 10.0});
  OptimalControlProblem problem("swing");
  problem.start_at({0.0, 0.0}).then(phase);
  return problem;
}

TEST(PromiseOfOptimumDerivatives, EachCallMayComeFromAnotherThread) {
  const auto derivatives_at = [](const Place& place) {
    MultipleShooting shooting(pendulum(), {.intervals_per_phase = 8, .integrator = runge_kutta4()});
    const Solution solution = solve(shooting, *make_native_solver());
    EXPECT_TRUE(solution.ok()) << solution.message;
    Numbers numbers;
    std::unique_ptr<OptimumDerivatives> derivatives;
    place([&] { derivatives = std::make_unique<OptimumDerivatives>(shooting, solution); });
    EXPECT_TRUE(derivatives->reliable()) << derivatives->message();
    append(numbers, derivatives->point().w);
    const auto ask = [&](const std::function<OptimumDerivatives::Derivative()>& question) {
      OptimumDerivatives::Derivative answer;
      place([&] { answer = question(); });
      EXPECT_TRUE(answer.reliable) << answer.message;
      numbers.push_back(answer.cost);
      append(numbers, answer.first_input);
      append(numbers, answer.w);
    };
    ask([&] { return derivatives->wrt_parameter("gravity"); });
    ask([&] { return derivatives->wrt_start(1); });
    ask([&] { return derivatives->wrt_duration(0); });
    ask([&] { return derivatives->wrt_start_time(); });
    place([&] { derivatives.reset(); });
    return numbers;
  };
  EXPECT_EQ(derivatives_at(here), derivatives_at(on_a_thread_of_its_own));
}

// Cold solves and one warm solve.
TEST(PromiseOfQpSolvers, EachCallOfAStageQpSolverMayComeFromAnotherThread) {
  const auto points_at = [](const Place& place) {
    Numbers numbers;
    for (const int seed : {1, 2, 3, 4, 5}) {
      const qp::StageQp qp = testing::random_qp(seed).qp;
      std::unique_ptr<qp::StageQpSolver> solver;
      place([&] { solver = qp::make_riccati_solver(qp); });
      qp::StagePoint point(qp);
      for (const bool warm : {false, true, false}) {
        qp::QpResult result;
        place([&] { result = solver->solve(qp, point, warm); });
        EXPECT_EQ(result.status, qp::QpStatus::optimal) << seed;
        numbers.insert(numbers.end(), {1.0 * result.iterations, result.objective});
        for (const qp::StagePoint::AtStage& stage : point.stages) {
          append(numbers, stage.x);
          append(numbers, stage.u);
          append(numbers, stage.costate);
        }
      }
      place([&] { solver.reset(); });
    }
    return numbers;
  };
  EXPECT_EQ(points_at(here), points_at(on_a_thread_of_its_own));
}

// Ten bounded variables, five rows with two sides, and a diagonal Hessian.
qp::SparseQp small_program(unsigned seed) {
  constexpr int variables = 10, rows = 5;
  std::vector<std::pair<int, int>> diagonal, entries;
  for (int v = 0; v < variables; ++v) diagonal.emplace_back(v, v);
  for (int v = 0; v < variables; ++v) entries.emplace_back(v % rows, v);
  qp::SparseQp qp(SparsityPattern::from_pairs(variables, variables, diagonal),
                  SparsityPattern::from_pairs(rows, variables, entries));
  Random random(seed);
  for (double& entry : qp.hessian) entry = random.uniform(0.5, 2.0);
  for (double& entry : qp.gradient) entry = random.uniform(-3.0, 3.0);
  for (double& entry : qp.rows) entry = random.uniform(0.5, 1.5);
  qp.lower.setConstant(-1.0);
  qp.upper.setConstant(1.0);
  qp.row_lower.setConstant(-0.5);
  qp.row_upper.setConstant(0.5);
  return qp;
}

TEST(PromiseOfQpSolvers, EachCallOfAQpSolverMayComeFromAnotherThread) {
  const auto points_at = [](const Place& place) {
    Numbers numbers;
    for (const unsigned seed : {1, 2, 3, 4, 5}) {
      const qp::SparseQp qp = small_program(seed);
      std::unique_ptr<qp::QpSolver> solver;
      place([&] { solver = qp::make_sparse_qp_solver(qp.hessian_pattern, qp.row_pattern); });
      PrimalDualPoint point{VectorXd::Zero(qp.lower.size()), VectorXd::Zero(qp.row_lower.size()),
                            VectorXd::Zero(qp.lower.size())};
      for (const bool warm : {false, true, false}) {
        qp::QpResult result;
        place([&] { result = solver->solve(qp, point, warm); });
        EXPECT_EQ(result.status, qp::QpStatus::optimal) << seed;
        numbers.insert(numbers.end(), {1.0 * result.iterations, result.objective});
        append(numbers, point.w);
        append(numbers, point.lambda);
        append(numbers, point.z);
      }
      place([&] { solver.reset(); });
    }
    return numbers;
  };
  EXPECT_EQ(points_at(here), points_at(on_a_thread_of_its_own));
}

}  // namespace
}  // namespace saltus
