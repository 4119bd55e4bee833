// Calls of an observer during a solve, and the interruption of a solve.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

OptimalControlProblem pendulum() {
  const auto dynamics = [](const auto&, const auto& x, const auto& u) {
    return std::decay_t<decltype(x)>{x[1], u[0] - 9.81 * sin(x[0])};
  };
  Phase<2, 1> swing{"swing", dynamics, exactly(1.0)};
  swing.bound_input(0, between(-30.0, 30.0))
      .track(
          "effort", [](const auto&, const auto&, const auto& u) { return u; }, VectorXd::Ones(1))
      .reach(
          "upright", [](const auto&, const auto& x) { return x; },
          std::vector{exactly(3.14159), exactly(0.0)});
  OptimalControlProblem ocp("pendulum");
  ocp.start_at({0, 0}).then(swing);
  return ocp;
}

struct Named {
  const char* name;
  std::unique_ptr<Solver> (*make)();
};
const Named solvers[] = {
    {"SQP on a sparse factor", [] { return make_native_solver(); }},
    {"SQP stage by stage", [] { return make_native_solver({.qp = riccati_qp()}); }},
    {"Ipopt", [] { return make_ipopt(); }},
};

TEST(Observer, ReceivesEveryIteration) {
  for (const Named& named : solvers) {
    SCOPED_TRACE(named.name);
    MultipleShooting shooting(pendulum(),
                              {.intervals_per_phase = 20, .integrator = runge_kutta4()});
    const std::unique_ptr<Solver> solver = named.make();
    std::vector<SolveObserver::Iteration> heard;
    solver->set_observer(
        {.report = [&](const SolveObserver::Iteration& it) { heard.push_back(it); }});
    const Solution watched = solve(shooting, *solver);
    ASSERT_TRUE(watched.ok()) << watched.message;
    ASSERT_EQ(static_cast<int>(heard.size()), watched.iterations + 1);
    for (std::size_t k = 0; k < heard.size(); ++k) EXPECT_EQ(heard[k].number, static_cast<int>(k));
    EXPECT_NEAR(heard.back().cost, watched.cost, 1e-6 * watched.cost);
    EXPECT_LT(heard.back().violation, 1e-7);
    EXPECT_GT(heard.front().violation, 0.1);
    EXPECT_GT(heard[1].step, 0.0);
    EXPECT_GT(heard[1].step_length, 0.0);

    // An observer does not change the result.
    solver->set_observer({});
    const std::unique_ptr<Solver> alone = named.make();
    const Solution unwatched = solve(shooting, *alone);
    EXPECT_EQ(unwatched.cost, watched.cost);
    EXPECT_EQ(unwatched.iterations, watched.iterations);
  }
}

TEST(Observer, StopsASolveWithTheCurrentPoint) {
  for (const Named& named : solvers) {
    SCOPED_TRACE(named.name);
    MultipleShooting shooting(pendulum(),
                              {.intervals_per_phase = 20, .integrator = runge_kutta4()});
    const std::unique_ptr<Solver> solver = named.make();
    int asked = 0;
    solver->set_observer({.should_stop = [&] { return ++asked > 2; }});
    const Solution partial = solve(shooting, *solver);
    EXPECT_EQ(partial.status, SolveStatus::interrupted) << partial.message;
    EXPECT_FALSE(partial.ok());
    EXPECT_EQ(partial.iterations, 2);
    EXPECT_EQ(partial.trajectory.pieces().size(), 20u);
    EXPECT_NE(partial.message.find("interrupted"), std::string::npos) << partial.message;
    solver->set_observer({});
    EXPECT_TRUE(solve(shooting, *solver).ok());
  }
}

// A cost that is 1e6 times as large is scaled down before the solve.
MultipleShooting dear_swing() {
  OptimalControlProblem ocp = pendulum();
  ocp.editable_phase(0).terms.front().weight *= 1e6;
  return MultipleShooting(std::move(ocp),
                          {.intervals_per_phase = 20, .integrator = runge_kutta4()});
}

TEST(Observer, CostsAreUnscaled) {
  MultipleShooting shooting = dear_swing();
  const std::unique_ptr<Solver> solver = make_native_solver();
  double last = 0.0;
  solver->set_observer({.report = [&](const SolveObserver::Iteration& it) { last = it.cost; }});
  const Solution s = solve(shooting, *solver);
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(last, s.cost, 1e-6 * s.cost);
}

// An exception from the observer leaves the solver unchanged.
TEST(Observer, CostsStayUnscaledAfterAnException) {
  MultipleShooting shooting = dear_swing();
  const std::unique_ptr<Solver> solver = make_native_solver();
  double last = 0.0;
  bool throws = true;
  solver->set_observer({.report = [&](const SolveObserver::Iteration& it) {
    last = it.cost;
    if (throws) throw std::runtime_error("enough");
  }});
  EXPECT_THROW(solve(shooting, *solver), std::runtime_error);
  throws = false;
  const Solution s = solve(shooting, *solver);
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(last, s.cost, 1e-6 * s.cost);
}

TEST(Observer, TableRepeatsItsHeader) {
  std::vector<std::string> lines;
  const auto table =
      table_of_iterations([&](const std::string& line) { lines.push_back(line); }, 2);
  for (int k = 0; k < 3; ++k) table({.number = k, .cost = 1.5, .violation = 1e-3, .barrier = 0.1});
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[0], header_of_iterations());
  EXPECT_EQ(lines[3], header_of_iterations());
  EXPECT_EQ(lines[1].size(), lines[0].size());
  EXPECT_NE(lines[4].find("   2   1.5000000e+00"), std::string::npos) << lines[4];
  EXPECT_NE(lines[4].find("-1.0"), std::string::npos) << lines[4];
}

}  // namespace
}  // namespace saltus
