// Tests that a tick's claims about its plan hold for the nonlinear program, and when they are made.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/late_solver.hpp"

namespace saltus {
namespace {

constexpr double step = 0.1;  // s

// x = (angle, speed) of a pendulum, upright at zero.
template <bool nonlinear>
struct Pendulum {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], (nonlinear ? S(sin(x[0])) : x[0]) + u[0]};
  }
};

// A hard end row prescribes the position of the mass, a nonlinear function of the angle. The
// iteration soon satisfies it. With an additional speed condition (steep) it never does.
template <bool nonlinear>
MultipleShooting pendulum(double steep = 0.0) {
  Phase<2, 1> phase{"pendulum", Pendulum<nonlinear>{}, exactly(10 * step)};
  phase.bound_input(0, between(-12.0, 12.0))
      .track(
          "upright", [](const auto&, const auto& x) { return x; }, Vec<double, 2>{10.0, 1.0})
      .track(
          "torque", [](const auto&, const auto&, const auto& u) { return u; }, Vec<double, 1>{0.1});
  if constexpr (nonlinear)
    phase.reach(
        "place", [steep](const auto&, const auto& x) { return sin(x[0]) + steep * x[1] * x[1]; },
        exactly(steep > 0.0 ? 0.0 : 0.3));
  OptimalControlProblem ocp("pendulum");
  ocp.start_at({0.5, 0.0}).then(phase);
  return MultipleShooting(std::move(ocp),
                          {.intervals_per_phase = 10, .integrator = runge_kutta4()});
}

enum class Back { stages, riccati, sparse };
template <bool nonlinear = true>
RecedingHorizonController controller_for(Back which, ControllerOptions options = {},
                                         double steep = 0.0,
                                         std::function<bool(long)> is_late = {}) {
  MultipleShooting shooting = pendulum<nonlinear>(steep);
  RealTimeIterationOptions iteration;
  if (which != Back::stages) iteration.qp = which == Back::riccati ? riccati_qp() : sparse_qp();
  auto solver = make_real_time_iteration(shooting.nlp(), iteration);
  if (is_late) solver = std::make_unique<LateSolver>(std::move(solver), std::move(is_late));
  options.period = step;
  return {std::move(shooting), std::move(solver), std::move(options)};
}

const VectorXd hanging = Vec<double, 2>{2.8, 0.0};

class TickTruth : public ::testing::TestWithParam<Back> {};

// Compares the claims of a tick about its plan with the program evaluated here.
void expect_true(RecedingHorizonController& controller, const ControlTick& tick) {
  const ControllerOptions limits;
  const Solution plan = controller.report();
  const KktCheck::Residual truth = kkt_residual(controller.shooting().nlp(), plan.point);
  EXPECT_EQ(tick.kkt, truth.scaled());
  EXPECT_EQ(tick.violation, truth.feasibility);
  EXPECT_EQ(tick.objective, plan.cost);
  EXPECT_EQ(tick.status, plan.status);
  if (truth.feasibility > limits.feasibility) {
    EXPECT_EQ(tick.provenance, Provenance::step);
    EXPECT_EQ(tick.status, SolveStatus::step_taken);
    EXPECT_FALSE(plan.ok());
    for (const char* part : {"violates its bounds by", "residual", "violation"})
      EXPECT_NE(plan.message.find(part), std::string::npos) << plan.message;
  } else if (truth.scaled() > limits.optimality) {
    EXPECT_EQ(tick.provenance, Provenance::feasible);
    EXPECT_EQ(tick.status, SolveStatus::feasible);
    EXPECT_TRUE(plan.ok());
    EXPECT_NE(plan.message.find("not optimal yet"), std::string::npos) << plan.message;
  } else {
    EXPECT_EQ(tick.provenance, Provenance::optimal);
    EXPECT_EQ(tick.status, SolveStatus::optimal);
  }
}

TEST_P(TickTruth, ResidualAndViolationMatchTheProgram) {
  RecedingHorizonController controller = controller_for(GetParam());
  std::array<int, provenances> counts{};
  constexpr int ticks = 10;
  for (int k = 0; k < ticks; ++k) {  // the instant is fixed, so the iteration converges
    SCOPED_TRACE(k);
    const ControlTick& tick = controller.tick(0.0, hanging);
    expect_true(controller, tick);
    if (k == 0) {
      EXPECT_GT(tick.violation, 0.1);  // one quadratic model, far from the solution
      EXPECT_GT(tick.kkt, 0.5);
    }
    ++counts[static_cast<std::size_t>(tick.provenance)];
  }
  const LoopStatistics& statistics = controller.statistics();
  for (const Provenance p : {Provenance::step, Provenance::feasible, Provenance::optimal}) {
    EXPECT_GE(counts[static_cast<std::size_t>(p)], 1) << describe(p);
    EXPECT_EQ(statistics.count(p), counts[static_cast<std::size_t>(p)]);
  }
  EXPECT_EQ(statistics.all().count(), ticks);
  EXPECT_EQ(statistics.check.count(), ticks);
}

TEST_P(TickTruth, UselessStepsAreNotCalledOptimal) {
  RecedingHorizonController controller = controller_for(GetParam(), {}, 0.2);
  for (int k = 0; k < 60; ++k) {
    SCOPED_TRACE(k);
    const ControlTick& tick = controller.tick(0.0, hanging);
    expect_true(controller, tick);
    EXPECT_EQ(tick.provenance, Provenance::step);
  }
}

// A plan cut short by the time limit is also checked against the program, and keeps its reason.
TEST_P(TickTruth, InterruptedPlansAreChecked) {
  const ControllerOptions options;
  RecedingHorizonController controller =
      controller_for(GetParam(), options, 0.0, [](long k) { return k > 0; });
  controller.tick(0.0, hanging);
  for (int k = 1; k < 20; ++k) {
    const ControlTick& tick = controller.tick(0.0, hanging);
    EXPECT_FALSE(is_success(tick.status)) << k;
    if (!is_of_this_tick(tick.provenance)) continue;
    const KktCheck::Residual truth =
        kkt_residual(controller.shooting().nlp(), controller.report().point);
    EXPECT_EQ(tick.violation, truth.feasibility) << k;
    EXPECT_EQ(tick.provenance == Provenance::step, truth.feasibility > options.feasibility) << k;
  }
}

TEST_P(TickTruth, InputIsAvailableBeforeTheCheck) {
  std::vector<ControlTick> sent;
  ControllerOptions options;
  options.send = [&](const ControlTick& tick) { sent.push_back(tick); };
  RecedingHorizonController controller = controller_for(GetParam(), options);
  const ControlTick& tick = controller.tick(0.0, hanging);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].provenance, Provenance::step);
  EXPECT_EQ(sent[0].status, SolveStatus::step_taken);
  EXPECT_EQ(sent[0].kkt, infinity);
  EXPECT_EQ(sent[0].violation, infinity);
  EXPECT_EQ(sent[0].check, 0.0);
  EXPECT_EQ(sent[0].input[0].input()[0], tick.input[0].input()[0]);
  EXPECT_EQ(sent[0].seconds, tick.seconds);
  EXPECT_LT(tick.kkt, infinity);
  EXPECT_GT(tick.check, 0.0);
  EXPECT_GE(controller.statistics().check.max(), tick.check);
  EXPECT_EQ(controller.statistics().all().max(), tick.seconds);
  controller.tick(0.1, VectorXd::Constant(2, std::nan("")));  // also sends shifted plans
  ASSERT_EQ(sent.size(), 2u);
  EXPECT_EQ(sent[1].provenance, Provenance::shifted);
  EXPECT_EQ(tick.check, 0.0);
}

// If the program equals its quadratic model, no check is needed.
TEST_P(TickTruth, LinearQuadraticProgramsAreNotCheckedAgain) {
  RecedingHorizonController controller = controller_for<false>(GetParam());
  ASSERT_TRUE(controller.shooting().nlp().is_linear_quadratic());
  const ControlTick& tick = controller.tick(0.0, hanging);
  EXPECT_EQ(tick.provenance, Provenance::optimal);
  EXPECT_EQ(tick.check, 0.0);
  EXPECT_EQ(controller.statistics().check.count(), 0);
  const Solution plan = controller.report();
  EXPECT_LT(plan.kkt.scaled(), 1e-6);
  EXPECT_TRUE(plan.ok()) << plan.message;
}

TEST_P(TickTruth, TheCheckDoesNotAllocate) {
  RecedingHorizonController controller = controller_for(GetParam());
  controller.tick(0.0, hanging);
  const testing::AllocationCount count;
  long checked = 0;
  for (int k = 1; k < 10; ++k) checked += controller.tick(0.0, hanging).check > 0.0 ? 1 : 0;
  EXPECT_EQ(count.made(), 0);
  EXPECT_EQ(checked, 9);
}

INSTANTIATE_TEST_SUITE_P(Solvers, TickTruth,
                         ::testing::Values(Back::stages, Back::riccati, Back::sparse),
                         [](const auto& instance) {
                           return instance.param == Back::stages    ? "Stages"
                                  : instance.param == Back::riccati ? "Riccati"
                                                                    : "Sparse";
                         });

TEST(TickStatus, TrustsAProgramSolver) {
  MultipleShooting shooting = pendulum<true>();
  auto solver = make_real_time_solver(make_ipopt());
  RecedingHorizonController controller(std::move(shooting), std::move(solver), {.period = step});
  const ControlTick& tick = controller.tick(0.0, hanging);
  ASSERT_EQ(tick.provenance, Provenance::optimal) << describe(tick.status);
  EXPECT_EQ(tick.check, 0.0);
  EXPECT_LT(controller.report().kkt.scaled(), 1e-6);
}

// The same pendulum in other units: lengths, forces (torques) and weights (costs).
struct Units {
  double length, force, weight;
};
struct PendulumIn {
  Units unit;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], S(sin(x[0] / unit.length)) * unit.length + u[0] * unit.length / unit.force};
  }
};

TEST(TickStatus, OptimumIsIndependentOfUnits) {
  for (const Units& unit : {Units{1.0, 1.0, 1.0}, Units{1e-3, 1e-3, 1.0}, Units{1e-5, 1e-5, 1.0},
                            Units{1.0, 1.0, 1e-9}, Units{1.0, 1e6, 1.0}}) {
    SCOPED_TRACE(::testing::Message() << unit.length << ", " << unit.force << ", " << unit.weight);
    Phase<2, 1> phase{"pendulum", PendulumIn{unit}, exactly(10 * step)};
    phase.bound_input(0, between(-12.0 * unit.force, 12.0 * unit.force))
        .track(
            "upright", [](const auto&, const auto& x) { return x; },
            Vec<double, 2>{10.0 * unit.weight, unit.weight})
        .track(
            "torque", [](const auto&, const auto&, const auto& u) { return u; },
            Vec<double, 1>{0.1 * unit.weight * std::pow(unit.length / unit.force, 2)});
    OptimalControlProblem ocp("pendulum");
    const VectorXd start = Vec<double, 2>{0.5 * unit.length, 0.0};
    ocp.start_at(start).then(phase);
    const auto shooting = [&] {
      return MultipleShooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
    };
    MultipleShooting whole = shooting();
    const Solution best = solve(whole, *make_native_solver());
    ASSERT_TRUE(best.ok()) << best.message;
    for (const bool is_whole : {false, true}) {
      MultipleShooting mine = shooting();
      auto solver = is_whole ? make_real_time_solver(make_native_solver(), true)
                             : make_real_time_iteration(mine.nlp());
      RecedingHorizonController controller(std::move(mine), std::move(solver), {.period = step});
      for (int k = 0; k < 6; ++k) {
        const ControlTick& tick = controller.tick(0.0, start);
        if (is_whole || (unit.length == 1.0 && unit.force == 1.0 && unit.weight == 1.0 && k > 3)) {
          EXPECT_EQ(tick.provenance, Provenance::optimal) << is_whole << k;
        }
        if (tick.provenance == Provenance::optimal) {
          EXPECT_NEAR(tick.objective / best.cost, 1.0, 1e-4) << is_whole << k;
        }
      }
    }
  }
}

// Tolerances of solvers are absolute. Any point would meet them if the cost is tiny, so a tick
// solves for a multiple of such a cost.
TEST(TickStatus, OptimumOfATinyCostIsRight) {
  for (const double size : {1.0, 1e3, 1e6})
    for (const double weight : {1.0, 1e-6, 1e-12, 1e-16}) {
      Phase<2, 1> phase{"slide",
                        [](auto, auto x, auto u) {
                          return Vec<std::decay_t<decltype(x[1] + u[0])>, 2>{x[1], u[0]};
                        },
                        exactly(2.0)};
      phase
          .minimise("cost", [=](auto, auto x,
                                auto u) { return weight * (x[0] * x[0] + 0.1 * u[0] * u[0]); })
          .bound_input(0, between(-size, size));
      OptimalControlProblem ocp("slide");
      const VectorXd start = Vec<double, 2>{size, 0.0};
      ocp.start_at(start).then(phase);
      const auto shooting = [&] {
        return MultipleShooting(ocp, {.intervals_per_phase = 20, .integrator = runge_kutta4()});
      };
      MultipleShooting whole = shooting();
      const Solution best = solve(whole, *make_native_solver());
      ASSERT_TRUE(best.ok()) << best.message;
      for (const Back which : {Back::stages, Back::riccati, Back::sparse}) {
        SCOPED_TRACE(::testing::Message() << size << ", " << weight << ", " << int(which));
        MultipleShooting mine = shooting();
        RealTimeIterationOptions iteration;
        if (which != Back::stages)
          iteration.qp = which == Back::riccati ? riccati_qp() : sparse_qp();
        auto solver = make_real_time_iteration(mine.nlp(), iteration);
        RecedingHorizonController controller(std::move(mine), std::move(solver), {.period = 0.1});
        for (int k = 0; k < 2; ++k) {  // cold and warm
          const ControlTick& tick = controller.tick(0.0, start);
          EXPECT_EQ(tick.provenance, Provenance::optimal);
          EXPECT_NEAR(tick.objective / best.cost, 1.0, 1e-3);
          EXPECT_NEAR(tick.input[0].input()[0], best.trajectory.input(0.0)[0], 1e-2 * size);
          const Solution plan = controller.report();
          EXPECT_TRUE(plan.ok()) << plan.message;
        }
      }
    }
}

// For large states, rounding stops the solvers of the models before they reach their tolerance.
TEST(TickStatus, AnOptimalPlanIsReportedAsAnOptimum) {
  for (const double size : {1.0, 1e6, 1e8})
    for (const double weight : {1.0, 1e6}) {
      const Units unit{size, size, weight};
      Phase<2, 1> phase{"pendulum", PendulumIn{unit}, exactly(10 * step)};
      phase.minimise("cost", [weight](auto, auto x, auto u) {
        return weight * (x[0] * x[0] + 0.1 * u[0] * u[0]);
      });
      OptimalControlProblem ocp("pendulum");
      const VectorXd start = Vec<double, 2>{0.5 * size, 0.0};
      ocp.start_at(start).then(phase);
      for (const bool is_sparse : {false, true}) {
        SCOPED_TRACE(::testing::Message() << size << ", " << weight << ", " << is_sparse);
        MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
        RealTimeIterationOptions iteration;
        if (is_sparse) iteration.qp = sparse_qp();
        auto solver = make_real_time_iteration(shooting.nlp(), iteration);
        RecedingHorizonController controller(std::move(shooting), std::move(solver),
                                             {.period = step});
        for (int k = 0; k < 10; ++k) {
          if (controller.tick(0.0, start).provenance != Provenance::optimal) continue;
          const Solution plan = controller.report();
          EXPECT_TRUE(plan.ok()) << plan.message;
        }
      }
    }
}

TEST(TickStatus, ChecksTolerances) {
  for (ControllerOptions options :
       {ControllerOptions{.optimality = 0.0}, ControllerOptions{.feasibility = std::nan("")}})
    EXPECT_THROW(controller_for(Back::stages, options), DefinitionError);
}

}  // namespace
}  // namespace saltus
