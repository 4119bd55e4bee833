// Tests a shrinking horizon: the remaining problem equals a directly defined problem, and the plan
// continues from phase to phase.
#include "saltus/mpc/shrinking_horizon.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/solver/native_solver.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using testing_support::Cart;
using testing_support::position;
using testing_support::speed;

const auto force = [](const auto&, const auto&, const auto& u) { return u; };

// From rest to rest over 1 m within `duration`, through a point at 0.3 m.
OptimalControlProblem by_way_of(Bounds first, Bounds second, Bounds total) {
  Phase<2, 1> out{"out", Cart{}, first}, in{"in", Cart{}, second};
  out.reach("gate", position, exactly(0.3)).guess_duration(0.4);
  in.reach("there", position, exactly(1.0)).reach("at rest", speed, exactly(0.0));
  in.guess_duration(0.6);
  for (auto* phase : {&out, &in})
    phase->track("effort", force, VectorXd::Ones(1)).bound_input(0, between(-30.0, 30.0));
  OptimalControlProblem ocp("by way of a gate");
  ocp.start_at({0, 0}).then(out).then(in).total_time(total);
  return ocp;
}
const ShootingOptions grid{.intervals_per_phase = 8, .integrator = runge_kutta4()};

RecedingHorizonController optimising(MultipleShooting rest) {
  return {std::move(rest),
          make_real_time_solver(make_native_solver({.tolerance = 1e-9})),
          {.period = 0.05}};
}

TEST(RemainingProblem, EqualsTheDirectDefinition) {
  const Bounds any = between(0.1, 0.9);
  MultipleShooting shortened(by_way_of(any, any, exactly(1.0)), grid);
  shortened.set_remaining(between(0.05, 0.85), exactly(0.95));
  shortened.start_at(0.05, VectorXd{{0.01, 0.3}});
  const Solution left = solve(shortened, *make_native_solver({.tolerance = 1e-10}));

  OptimalControlProblem written = by_way_of(between(0.05, 0.85), any, exactly(0.95));
  MultipleShooting anew(written.start_time(0.05).start_at({0.01, 0.3}), grid);
  const Solution known = solve(anew, *make_native_solver({.tolerance = 1e-10}));
  ASSERT_TRUE(left.ok() && known.ok()) << left.message << known.message;
  EXPECT_NEAR(left.cost, known.cost, 1e-7);  // costs of about 6, gradient tolerance 1e-10
  EXPECT_NEAR(left.durations[0], known.durations[0], 1e-6);
  EXPECT_NEAR(left.trajectory.end_time(), 1.0, 1e-9);
}

TEST(RemainingProblem, ShortensAFixedPhase) {
  MultipleShooting shooting(by_way_of(exactly(0.4), exactly(0.6), {}), grid);
  EXPECT_THROW(shooting.set_remaining(between(0.1, 0.2), {}), DefinitionError);
  EXPECT_THROW(shooting.set_remaining(exactly(-0.1), {}), DefinitionError);
  shooting.set_remaining(exactly(0.3), {});
  shooting.start_time(0.1);
  const Solution s = solve(shooting, *make_native_solver());
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.durations[0], 0.3, 1e-12);
  EXPECT_NEAR(s.trajectory.end_time(), 1.0, 1e-12);
}

TEST(RemainingProblem, StartsWithTheNextPhase) {
  const OptimalControlProblem whole = by_way_of(between(0.1, 0.9), between(0.1, 0.9), exactly(1.0));
  const OptimalControlProblem rest = whole.after(1);
  ASSERT_EQ(rest.phases().size(), 1u);
  EXPECT_EQ(rest.phases()[0].name, "in");
  EXPECT_TRUE(rest.total_time().is_equality());
  EXPECT_NO_THROW(rest.check());
  EXPECT_EQ(whole.after(0).phases().size(), 2u);
  EXPECT_THROW(whole.after(2), DefinitionError);
  OptimalControlProblem closed = whole;
  EXPECT_THROW(closed.close().after(1), DefinitionError);
}

TEST(RemainingProblem, RejectsAFreePhaseShorterThanItsWindow) {
  Phase<2, 1> drive{"drive", Cart{}, between(0.5, 2.0)};
  drive.keep("slow at first", speed, at_most(1.0), Window{.to = 0.3}).guess_duration(1.0);
  OptimalControlProblem ocp("drive");
  ocp.start_at({0, 0}).then(drive);
  MultipleShooting shooting(std::move(ocp), grid);
  shooting.set_remaining(between(0.4, 1.9), {});
  expect_error<DefinitionError>([&] { shooting.set_remaining(between(0.2, 1.7), {}); },
                                {"term 'slow at first'"});
}

// Limits at nodes have no separate slot. If the nodes moved away from one, the interval around it
// would be in neither window, and its input would be unbounded.
TEST(RemainingProblem, KeepsWindowLimitsOfAFixedPhase) {
  const auto slow_at_first = [](double limit, Clock clock) {
    Phase<1, 1> go{
        "go", [](const auto&, const auto&, const auto& u) { return std::decay_t<decltype(u)>{u}; },
        exactly(1.0)};
    go.bound_input(0, between(0.0, 1.0), Window{.to = limit, .clock = clock})
        .bound_input(0, between(0.0, 2.0), Window{.from = limit, .clock = clock})
        .minimise_at_end("far", [](const auto&, const auto& x) { return -x[0]; });
    OptimalControlProblem ocp("go");
    ocp.start_at({0.0}).then(go);
    return MultipleShooting(std::move(ocp),
                            {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  };
  MultipleShooting on_a_node = slow_at_first(0.3, Clock::phase);
  expect_error<DefinitionError>([&] { on_a_node.set_remaining(exactly(0.95), {}); },
                                {"phase 'go', input 0", "limit at 0.3 s", "event"});
  const auto expect_furthest = [](MultipleShooting& shooting, double limit, double duration) {
    shooting.set_remaining(exactly(duration), {});
    const Solution s = solve(shooting, *make_native_solver());
    ASSERT_TRUE(s.ok()) << s.message;
    const double slow = std::min(limit, duration);
    EXPECT_NEAR(-s.cost, slow + 2.0 * (duration - slow), 1e-6) << limit << " of " << duration;
  };
  for (const double duration : {1.0, 0.5, 0.3, 0.2}) expect_furthest(on_a_node, 0.3, duration);
  MultipleShooting between_nodes = slow_at_first(0.31, Clock::phase);
  MultipleShooting absolute = slow_at_first(0.3, Clock::absolute);
  for (const double duration : {1.0, 0.95, 0.77, 0.25}) {
    expect_furthest(between_nodes, 0.31, duration);
    expect_furthest(absolute, 0.3, duration);
  }
}

// The used part of an integral or a link is unknown when a phase is partly over. A window relative
// to the start of the phase would move with every tick.
TEST(ShrinkingHorizon, RejectsIntegralsLinksAndWindowsByName) {
  const auto message = [](const OptimalControlProblem& problem) -> std::string {
    return error_of<DefinitionError>(
        [&] {
          remaining_controllers(problem, {.intervals_per_phase = 4, .integrator = runge_kutta4()},
                                [](MultipleShooting shooting) {
                                  return RecedingHorizonController(std::move(shooting),
                                                                   ControllerOptions{});
                                });
        },
        "");
  };
  Phase<2, 1> drive{"drive", Cart{}, exactly(1.0)};
  drive.track("effort", force, VectorXd::Ones(1));
  OptimalControlProblem linked("linked"), limited("limited");
  linked.start_at({0, 0}).then(drive).link(
      "return", [](const auto& end) { return end.x[0]; }, exactly(0.0), end_of(drive));
  EXPECT_NE(message(linked).find("link 'return'"), std::string::npos) << message(linked);
  limited.start_at({0, 0}).then(Phase<2, 1>(drive).bound_integral("way", speed, at_most(1.0)));
  EXPECT_NE(message(limited).find("integral 'way'"), std::string::npos) << message(limited);
  for (const Window& window : {Window{.from = 0.5}, Window{.from = 0.0, .to = 0.3}}) {
    OptimalControlProblem windowed("windowed");
    windowed.start_at({0, 0}).then(Phase<2, 1>(drive).bound_input(0, between(-1.0, 1.0), window));
    EXPECT_NE(message(windowed).find("phase 'drive', input 0"), std::string::npos)
        << message(windowed);
  }
  for (const Window& window : {Window{.from = 0.0}, Window{.to = 0.3, .clock = Clock::absolute}}) {
    OptimalControlProblem windowed("windowed");
    windowed.start_at({0, 0}).then(Phase<2, 1>(drive).bound_input(0, between(-1.0, 1.0), window));
    EXPECT_EQ(message(windowed), "");
  }
}

TEST(ShrinkingHorizon, EndStaysFixedAndPhasesFollow) {
  const OptimalControlProblem problem =
      by_way_of(between(0.1, 0.9), between(0.1, 0.9), exactly(1.0));
  ShrinkingHorizonController controller(problem, remaining_controllers(problem, grid, optimising));
  controller.tick(0.0, VectorXd{{0.0, 0.0}});
  const Solution plan = controller.report();
  ASSERT_TRUE(plan.ok()) << plan.message;
  const double gate = controller.end_of_phase(0);
  EXPECT_NEAR(controller.end_of_phase(1), 1.0, 1e-9);
  // Along the plan the optimum is unchanged, except for the finer grid.
  controller.tick(0.1, plan.trajectory.state(0.1));
  EXPECT_NEAR(controller.end_of_phase(0), gate, 2e-3);
  EXPECT_NEAR(controller.end_of_phase(1), 1.0, 1e-9);
  controller.enter(1, gate);
  EXPECT_EQ(controller.definition().name, "in");
  const VectorXd state = plan.trajectory.state(0.6);
  const ControlTick& tick = controller.tick(0.6, state);
  EXPECT_EQ(tick.provenance, Provenance::optimal);
  // The least-effort input to rest at 1 m is linear in time. The first of eight pieces has the
  // value at its middle.
  const double T = 1.0 - 0.6, missing = 1.0 - state[0],
               begin = 6.0 * missing / (T * T) - 4.0 * state[1] / T,
               end = -6.0 * missing / (T * T) + 2.0 * state[1] / T;
  // The error of a piecewise constant input is of second order in the number of pieces.
  EXPECT_NEAR(tick.input[0].input()[0], begin + (end - begin) / 16.0, std::abs(end - begin) / 64.0);
  EXPECT_NEAR(controller.end_of_phase(1), 1.0, 1e-9);
  EXPECT_THROW(controller.enter(0, 0.7), DefinitionError);
  EXPECT_THROW(controller.enter(2, 0.7), DefinitionError);
  EXPECT_THROW(ShrinkingHorizonController(problem, {}), DefinitionError);
}

// Finds no solution and takes no time.
class Idle final : public RealTimeSolver {
 public:
  void prepare(NonlinearProgram&, const NlpPoint&) noexcept override {}
  RealTimeSolver::Result feedback(NonlinearProgram&, NlpPoint&, bool,
                                  WallClock::time_point) noexcept override {
    RealTimeSolver::Result nothing;
    nothing.status = SolveStatus::time_limit;
    return nothing;
  }
  std::string name() const override { return "idle"; }
};

TEST(ShrinkingHorizon, NewPhaseContinuesThePlan) {
  const OptimalControlProblem problem = by_way_of(exactly(0.4), exactly(0.6), {});
  const auto idle_after_the_gate = [](MultipleShooting rest) {
    if (rest.problem().phases().size() == 2) return optimising(std::move(rest));
    return RecedingHorizonController(std::move(rest), std::make_unique<Idle>(), {.period = 0.05});
  };
  ShrinkingHorizonController controller(problem,
                                        remaining_controllers(problem, grid, idle_after_the_gate));
  controller.tick(0.0, VectorXd{{0.0, 0.0}});
  const Solution plan = controller.report();
  ASSERT_TRUE(plan.ok()) << plan.message;
  controller.enter(1, 0.4);
  const ControlTick& tick = controller.tick(0.45, plan.trajectory.state(0.45));
  EXPECT_EQ(tick.provenance, Provenance::shifted);
  const double middle = 0.45 + 0.5 * (1.0 - 0.45) / 8;  // middle of the first remaining interval
  EXPECT_NEAR(tick.input[0].input()[0], plan.trajectory.input(middle)[0], 1e-9);
}

RecedingHorizonController idle(MultipleShooting rest) {
  return RecedingHorizonController(std::move(rest), std::make_unique<Idle>(), {.period = 0.05});
}

TEST(ShrinkingHorizon, PlanPassesPhasesWithoutATick) {
  const OptimalControlProblem problem = by_way_of(exactly(0.4), exactly(0.6), {});
  const Solution plan =
      solve(*std::make_unique<MultipleShooting>(problem, grid), *make_native_solver());
  ASSERT_TRUE(plan.ok()) << plan.message;
  for (const bool is_adopted : {true, false}) {
    std::vector<RecedingHorizonController> rests = remaining_controllers(problem, grid, idle);
    if (is_adopted) rests.front().adopt_plan(0.0, plan.trajectory);
    ShrinkingHorizonController controller(problem, std::move(rests));
    if (!is_adopted) controller.tick(0.0, VectorXd{{0.0, 0.0}});
    controller.enter(1, 0.4);
    const ControlTick& tick = controller.tick(0.45, plan.trajectory.state(0.45));
    EXPECT_EQ(tick.provenance, is_adopted ? Provenance::shifted : Provenance::fallback);
    if (!is_adopted) continue;
    const double middle = 0.45 + 0.5 * (1.0 - 0.45) / 8;
    EXPECT_NEAR(tick.input[0].input()[0], plan.trajectory.input(middle)[0], 1e-9);
  }
}

TEST(ShrinkingHorizon, TicksDoNotAllocate) {
  const OptimalControlProblem problem = by_way_of(exactly(0.4), exactly(0.6), {});
  ShrinkingHorizonController controller(
      problem,
      remaining_controllers(problem, {.intervals_per_phase = 8, .integrator = zero_order_hold()},
                            [](MultipleShooting rest) {
                              return RecedingHorizonController(std::move(rest), {.period = 0.05});
                            }));
  VectorXd state{{0.0, 0.0}};
  controller.tick(0.0, state);
  const testing::AllocationCount count;
  for (int k = 1; k < 7; ++k) controller.tick(0.05 * k, state);
  EXPECT_EQ(count.made(), 0);
}

}  // namespace
}  // namespace saltus
