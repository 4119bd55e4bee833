// Tests the table of docs/promise.md with a controller: operations of other threads during a tick,
// and threads that may call its members. The inputs equal those of an undisturbed controller bit by
// bit, and the ticks do not allocate.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/mpc/shrinking_horizon.hpp"
#include "saltus/simulation/loop_log.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/replay.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/sanitized.hpp"

namespace saltus {
namespace {

constexpr int ticks = test::sanitized ? 60 : 400;
constexpr double period = 0.02;  // s

struct Pendulum {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 20.0 * sin(x[0])};
  }
};

// An integrated cost: its working memory belongs to the integrator.
OptimalControlProblem pendulum() {
  Phase<2, 1> phase{"pendulum", Pendulum{}, exactly(1.0)};
  phase
      .track(
          "state", [](const auto&, const auto& x) { return x; }, Vec<double, 2>{1.0, 1.0})
      .track(
          "torque", [](const auto&, const auto&, const auto& u) { return u; }, Vec<double, 1>{0.01})
      .bound_input(0, between(-30.0, 30.0));
  OptimalControlProblem problem("pendulum");
  problem.costs(CostRule::integrated).start_at({1.0, 0.0}).then(phase);
  return problem;
}

// An algebraic state in dynamics, cost and bound, for formulas that need working memory.
OptimalControlProblem with_algebraic_state() {
  Phase<2, 1, 0, 1> phase{
      "algebraic",
      [](const auto&, const auto& x, const auto& z, const auto&) {
        return std::decay_t<decltype(x)>{x[1], z[0]};
      },
      [](const auto&, const auto& x, const auto& z, const auto& u) {
        using S = std::decay_t<decltype(z[0])>;
        return Vec<S, 1>(z[0] + 0.1 * z[0] * z[0] * z[0] - u[0] + 20.0 * sin(x[0]));
      },
      Vec<double, 1>{0.0}, exactly(1.0)};
  phase
      .track(
          "state", [](const auto&, const auto& x, const auto&) { return x; },
          Vec<double, 2>{1.0, 1.0})
      .minimise("acceleration",
                [](const auto&, const auto&, const auto& z, const auto& u) {
                  return 1e-3 * z[0] * z[0] + 1e-2 * u[0] * u[0];
                })
      .bound_input(0, between(-30.0, 30.0));
  OptimalControlProblem problem("algebraic");
  problem.start_at({1.0, 0.0}).then(phase);
  return problem;
}

struct Case {
  std::string name;
  std::function<OptimalControlProblem()> problem;
  IntegratorChoice scheme;
};

RecedingHorizonController controller_of(const Case& c) {
  return {MultipleShooting(c.problem(), {.intervals_per_phase = 10, .integrator = c.scheme}),
          {.period = period}};
}

VectorXd measured(int k) { return VectorXd{{std::cos(0.1 * k), std::sin(0.07 * k)}}; }

struct LoopRun {
  std::vector<double> inputs;
  std::vector<Provenance> provenances;
  long allocations = 0;
};

// Runs the ticks from the second on while another thread calls `beside` repeatedly with the number
// of the call.
LoopRun run_with(const Case& c, const std::function<void(RecedingHorizonController&)>& before,
                 const std::function<void(int)>& beside) {
  RecedingHorizonController controller = controller_of(c);
  controller.tick(0.0, measured(0));
  before(controller);
  std::atomic<bool> stops = false;
  std::atomic<int> calls = 0;
  std::thread other([&] {
    while (beside && !stops) beside(calls++);
  });
  while (beside && calls == 0) std::this_thread::yield();
  LoopRun run;
  for (int k = 1; k < ticks; ++k) {
    const VectorXd state = measured(k);
    const testing::AllocationCount count;
    const ControlTick& tick = controller.tick(period * k, state);
    run.allocations += count.made_by_this_thread();
    run.inputs.push_back(tick.input[0].input()[0]);
    run.provenances.push_back(tick.provenance);
  }
  stops = true;
  other.join();
  return run;
}

class ConcurrentReaders : public ::testing::TestWithParam<Case> {
 protected:
  void expect_undisturbed(const std::function<void(RecedingHorizonController&)>& before,
                          const std::function<void(int)>& beside) {
    const LoopRun alone = run_with(GetParam(), before, nullptr);
    const LoopRun together = run_with(GetParam(), before, beside);
    EXPECT_EQ(alone.inputs, together.inputs);
    EXPECT_EQ(alone.provenances, together.provenances);
    EXPECT_EQ(alone.allocations, 0);
    EXPECT_EQ(together.allocations, 0);
  }
};

// Reads all quantities of a plan.
void read(const Solution& solution, const OptimalControlProblem& problem, int k) {
  const Trajectory& plan = solution.trajectory;
  const double t = plan.start_time() + (plan.end_time() - plan.start_time()) * (k % 97) / 97.0;
  EXPECT_TRUE(plan.state(t).allFinite());
  EXPECT_TRUE(plan.state_before(t).allFinite());
  EXPECT_TRUE(plan.input(t).allFinite());
  EXPECT_TRUE(plan.algebraic(t).allFinite());
  if (k % 10 != 0) return;
  std::ostringstream text;
  plan.write_csv(text, 2);
  EXPECT_FALSE(record(problem, plan, 2).samples.empty());
  EXPECT_TRUE(replay(problem, plan, runge_kutta8()).completed);
}

TEST_P(ConcurrentReaders, AReportIsRead) {
  Solution report;
  OptimalControlProblem problem;
  expect_undisturbed(
      [&](RecedingHorizonController& c) {
        report = c.report();
        problem = c.problem();
      },
      [&](int k) { read(report, problem, k); });
}

TEST_P(ConcurrentReaders, CopiesOfAReportAreReadByThreeThreads) {
  Solution report;
  OptimalControlProblem problem;
  expect_undisturbed(
      [&](RecedingHorizonController& c) {
        report = c.report();
        problem = c.problem();
      },
      [&](int) {
        std::vector<std::jthread> readers;
        for (int i = 0; i < 3; ++i)
          readers.emplace_back([&, i, copy = report] {
            for (int k = 0; k < 20; ++k) read(i == 0 ? report : copy, problem, k);
          });
      });
}

TEST_P(ConcurrentReaders, TheFormulasOfTheProblemAreEvaluated) {
  Solution report;
  OptimalControlProblem problem;
  expect_undisturbed(
      [&](RecedingHorizonController& c) {
        report = c.report();
        problem = current_problem(c.shooting());
      },
      [&](int) {
        const PhaseDefinition& phase = problem.phases().front();
        VectorXd z = VectorXd::Constant(phase.sizes.size(), 0.3);
        EXPECT_TRUE(phase.dynamics(z).allFinite());
        EXPECT_TRUE(phase.dynamics.dense_jacobian(z).allFinite());
        for (const Term& term : phase.terms) EXPECT_TRUE(term.function(z).allFinite());
        const IntervalProblem& interval = report.trajectory.phases().front().integrator->problem();
        EXPECT_TRUE(interval.dynamics(z).allFinite());
        if (interval.running_cost) {
          EXPECT_TRUE(interval.running_cost(z).allFinite());
        }
      });
}

// Another controller of the same problem, and plans made from copies of the problem.
TEST_P(ConcurrentReaders, AnotherControllerOfTheProblemTicks) {
  OptimalControlProblem problem;
  expect_undisturbed(
      [&](RecedingHorizonController& c) { problem = current_problem(c.shooting()); },
      [&](int) {
        RecedingHorizonController other{
            MultipleShooting(problem, {.intervals_per_phase = 5, .integrator = GetParam().scheme}),
            {.period = period}};
        for (int k = 0; k < 5; ++k)
          EXPECT_TRUE(is_of_this_tick(other.tick(period * k, measured(0)).provenance));
      });
}

TEST_P(ConcurrentReaders, CopiesOfTicksAndStatisticsAreRead) {
  ControlTick tick;
  LoopStatistics statistics;
  expect_undisturbed(
      [&](RecedingHorizonController& c) {
        statistics = c.statistics();
        tick = c.tick(0.0, measured(0));
      },
      [&](int) {
        EXPECT_TRUE(tick.input.all_finite());
        EXPECT_EQ(statistics.all().count(), 1);
      });
}

// Each tick uses new threads: one calls prepare(), another feedback(), a third set_data() and the
// report.
TEST_P(ConcurrentReaders, EachCallComesFromAnotherThread) {
  RecedingHorizonController here = controller_of(GetParam()), moving = controller_of(GetParam());
  for (int k = 0; k < 20; ++k) {
    const VectorXd state = measured(k);
    here.prepare(period * k);
    const double expected = here.feedback(state).input[0].input()[0];
    long allocations = 0;
    double found = 0.0;
    std::thread([&] {
      const testing::AllocationCount count;
      moving.prepare(period * k);
      allocations += count.made_by_this_thread();
    }).join();
    std::thread([&] {
      const testing::AllocationCount count;
      found = moving.feedback(state).input[0].input()[0];
      allocations += count.made_by_this_thread();
    }).join();
    EXPECT_EQ(allocations, 0) << "tick " << k;
    EXPECT_EQ(found, expected) << "tick " << k;
    std::thread([&] {
      EXPECT_TRUE(moving.report().trajectory.state(period * k).allFinite());
    }).join();
  }
}

// The controller moves from thread to thread.
TEST_P(ConcurrentReaders, AControllerIsMovedToAnotherThread) {
  RecedingHorizonController here = controller_of(GetParam()), moving = controller_of(GetParam());
  const double expected = here.tick(0.0, measured(0)).input[0].input()[0];
  double found = 0.0;
  std::thread([&found, c = std::move(moving)]() mutable {
    found = c.tick(0.0, measured(0)).input[0].input()[0];
  }).join();
  EXPECT_EQ(found, expected);
}

INSTANTIATE_TEST_SUITE_P(
    Programs, ConcurrentReaders,
    ::testing::Values(Case{"RungeKutta", pendulum, runge_kutta4({.steps = 2})},
                      Case{"Radau", pendulum, radau_iia({.stages = 2, .steps = 1})},
                      Case{"Algebraic", with_algebraic_state, runge_kutta4({.steps = 1})},
                      Case{"AlgebraicRadau", with_algebraic_state,
                           radau_iia({.stages = 2, .steps = 1})}),
    [](const auto& c) { return c.param.name; });

// Plans of a shrinking horizon come from several controllers.
TEST(ShrinkingConcurrentReaders, AReportIsReadWhileLaterPhasesTick) {
  const auto controller_of_two = [] {
    Phase<2, 1> first{"first", Pendulum{}, exactly(0.4)},
        second{"second", Pendulum{}, exactly(0.4)};
    for (Phase<2, 1>* phase : {&first, &second})
      phase
          ->track(
              "state", [](const auto&, const auto& x) { return x; }, Vec<double, 2>{1.0, 1.0})
          .bound_input(0, between(-30.0, 30.0));
    OptimalControlProblem problem("two");
    problem.costs(CostRule::integrated).start_at({1.0, 0.0}).then(first).then(second);
    return ShrinkingHorizonController(
        problem, remaining_controllers(
                     problem, {.intervals_per_phase = 10, .integrator = runge_kutta4()},
                     [](MultipleShooting rest) {
                       return RecedingHorizonController(std::move(rest), {.period = period});
                     }));
  };
  const auto inputs_with = [&](bool logs) {
    ShrinkingHorizonController controller = controller_of_two();
    controller.tick(0.0, measured(0));
    const Solution report = controller.report();
    const OptimalControlProblem problem = controller.rest();
    std::atomic<bool> stops = false;
    std::thread other([&] {
      for (int k = 0; logs && !stops; ++k) read(report, problem, k);
    });
    std::vector<double> inputs;
    for (int k = 1; k < 38; ++k) {
      if (k == 20) controller.enter(1, period * k);
      inputs.push_back(controller.tick(period * k, measured(k)).input[0].input()[0]);
    }
    stops = true;
    other.join();
    return inputs;
  };
  EXPECT_EQ(inputs_with(false), inputs_with(true));
}

}  // namespace
}  // namespace saltus
