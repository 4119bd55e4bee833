// Tests the output of the controller: with an event inside the tick, after a failed solve, at a
// timeout, and for NaN measurements.
#include "saltus/mpc/receding_horizon.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/late_solver.hpp"

namespace saltus {
namespace {

struct Integrator1 {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return Vec<S, 1>(u[0]);
  }
};

constexpr double step = 0.1;  // s
constexpr int intervals = 5;

// Drive x to zero. After the event, the input is twice as strong.
MultipleShooting gate(double event_time) {
  Phase<1, 1> phase{"gate", Integrator1{}, exactly(step * intervals)};
  phase.bound_input(0, between(-1.0, 1.0), Window{.to = event("open")})
      .bound_input(0, between(-2.0, 2.0), Window{.from = event("open")})
      .minimise("distance", [](auto, auto x, auto u) { return x[0] * x[0] + 1e-3 * u[0] * u[0]; });
  OptimalControlProblem ocp("gate");
  ocp.schedule(Schedule({"closed", "open"}, {{"open", event_time}})).start_at({10.0}).then(phase);
  return MultipleShooting(std::move(ocp),
                          {.intervals_per_phase = intervals, .integrator = zero_order_hold()});
}

// Solves with Ipopt, except in the calls chosen to fail.
class Unreliable final : public Solver {
 public:
  explicit Unreliable(std::vector<bool> fails) : fails_(std::move(fails)) {}
  std::string name() const override { return "unreliable"; }
  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) override {
    NlpResult result = solver_->solve(program, start, warm);
    if (fails_.at(calls_++)) result.status = SolveStatus::infeasible;
    return result;
  }

 private:
  std::vector<bool> fails_;
  std::size_t calls_ = 0;
  std::unique_ptr<Solver> solver_ = make_ipopt();
};

std::unique_ptr<RealTimeSolver> ipopt() { return make_real_time_solver(make_ipopt()); }

// stages: filled directly. riccati: as a sparse program with known stages.
enum class Back { stages, riccati, sparse, ipopt };
std::unique_ptr<RealTimeSolver> back_end(Back which, MultipleShooting& shooting) {
  if (which == Back::ipopt) return ipopt();
  if (which == Back::stages) return make_real_time_iteration(shooting.nlp());
  return make_real_time_iteration(shooting.nlp(),
                                  {.qp = which == Back::riccati ? riccati_qp() : sparse_qp()});
}

RecedingHorizonController controller_for(MultipleShooting shooting, Back which,
                                         ControllerOptions options = {.period = step}) {
  auto solver = back_end(which, shooting);
  return {std::move(shooting), std::move(solver), std::move(options)};
}

const VectorXd far_away = VectorXd::Constant(1, 10.0);
const VectorXd unknown = VectorXd::Constant(1, std::nan(""));

class EveryBackEnd : public ::testing::TestWithParam<Back> {};

TEST_P(EveryBackEnd, HoldsOnePieceWithoutAnEventAndTwoWithOne) {
  RecedingHorizonController controller = controller_for(gate(0.137), GetParam());
  const ControlTick& tick = controller.tick(0.0, far_away);
  ASSERT_EQ(tick.provenance, Provenance::optimal);
  ASSERT_EQ(tick.input.size(), 1u);
  EXPECT_NEAR(tick.input[0].input()[0], -1.0, 1e-6);

  controller.tick(0.1, far_away);
  ASSERT_EQ(tick.input.size(), 2u);
  EXPECT_NEAR(tick.input[0].start, 0.1, 1e-12);
  EXPECT_NEAR(tick.input[0].length, 0.037, 1e-12);
  EXPECT_NEAR(tick.input[0].input()[0], -1.0, 1e-6);
  EXPECT_NEAR(tick.input[1].start, 0.137, 1e-12);
  EXPECT_NEAR(tick.input[0].length + tick.input[1].length, step, 1e-12);
  EXPECT_NEAR(tick.input[1].input()[0], -2.0, 1e-6);

  controller.tick(0.2, far_away);
  ASSERT_EQ(tick.input.size(), 1u);
  EXPECT_NEAR(tick.input[0].input()[0], -2.0, 1e-6);
}

TEST_P(EveryBackEnd, ContinuesThePlanForANanMeasurement) {
  RecedingHorizonController controller = controller_for(gate(0.137), GetParam());
  const ControlTick& tick = controller.tick(0.0, unknown);
  EXPECT_EQ(tick.provenance, Provenance::fallback);
  ASSERT_EQ(tick.input.size(), 1u);
  EXPECT_EQ(tick.input[0].input()[0], 0.0);

  ASSERT_EQ(controller.tick(0.0, far_away).provenance, Provenance::optimal);
  controller.tick(0.1, unknown);
  EXPECT_EQ(tick.provenance, Provenance::shifted);
  ASSERT_EQ(tick.input.size(), 2u);  // the event has not moved
  EXPECT_NEAR(tick.input[0].input()[0], -1.0, 1e-6);
  EXPECT_NEAR(tick.input[1].input()[0], -2.0, 1e-6);
  controller.tick(std::nan(""), far_away);  // one period later
  EXPECT_NEAR(tick.time, 0.2, 1e-12);
  EXPECT_EQ(tick.provenance, Provenance::optimal);
  controller.tick(0.3, VectorXd::Zero(3));
  EXPECT_EQ(tick.provenance, Provenance::shifted);
  // A delayed event also keeps the gate closed for the plan.
  controller.retime("open", 0.95);
  controller.tick(0.4, unknown);
  EXPECT_EQ(tick.provenance, Provenance::shifted);
  for (const HeldInput::Piece& piece : tick.input) EXPECT_GE(piece.input()[0], -1.0);
  controller.retime("open", std::nan(""));
  EXPECT_EQ(controller.tick(0.5, far_away).provenance, Provenance::shifted);
  EXPECT_EQ(controller.tick(0.6, far_away).provenance, Provenance::optimal);
}

// If the input bounds make the problem infeasible, there is no plan. The residuals of the tick are
// infinite.
TEST_P(EveryBackEnd, HasNoPlanBeforeTheFirstSolve) {
  Phase<1, 1> phase{"reach", Integrator1{}, exactly(step * intervals)};
  phase.bound_input(0, between(-1.0, 1.0))
      .track(
          "effort", [](auto, auto, auto u) { return u; }, VectorXd::Ones(1))
      .reach(
          "home", [](auto, auto x) { return x[0]; }, exactly(0.0));
  OptimalControlProblem ocp("reach");
  ocp.start_at({0.0}).then(phase);
  RecedingHorizonController controller = controller_for(
      MultipleShooting(ocp, {.intervals_per_phase = intervals, .integrator = zero_order_hold()}),
      GetParam());
  const ControlTick& tick = controller.tick(0.0, far_away);
  ASSERT_FALSE(is_of_this_tick(tick.provenance)) << describe(tick.provenance);
  EXPECT_EQ(tick.objective, infinity);
  EXPECT_EQ(tick.kkt, infinity);
  EXPECT_EQ(tick.violation, infinity);
  controller.tick(0.1, VectorXd::Zero(1));
  ASSERT_TRUE(is_of_this_tick(tick.provenance)) << describe(tick.status);
  EXPECT_LT(tick.kkt, 1e-6);
  EXPECT_LT(tick.violation, 1e-6);
}

TEST_P(EveryBackEnd, ForcedMissesContinueThePlanAndAreCounted) {
  MultipleShooting shooting = gate(0.137);
  auto solver = std::make_unique<LateSolver>(back_end(GetParam(), shooting),
                                             [](long k) { return k % 3 == 2; });
  RecedingHorizonController controller(std::move(shooting), std::move(solver), {.period = step});
  double x = 10.0;
  for (int k = 0; k < 30; ++k) {
    const ControlTick& tick = controller.tick(step * k, VectorXd::Constant(1, x));
    if (k % 3 == 2) {
      EXPECT_NE(tick.provenance, Provenance::fallback);
      EXPECT_NE(tick.provenance, Provenance::optimal) << k;
      EXPECT_EQ(tick.status, SolveStatus::time_limit);
    } else {
      ASSERT_EQ(tick.provenance, Provenance::optimal) << k;
    }
    ASSERT_TRUE(tick.input.all_finite());
    for (const HeldInput::Piece& piece : tick.input) x += piece.length * piece.input()[0];
  }
  EXPECT_NEAR(x, 4.4, 0.5);  // 0.137 s at 1 / s, the rest at 2 / s
  const LoopStatistics& statistics = controller.statistics();
  EXPECT_EQ(statistics.count(Provenance::optimal), 20);
  EXPECT_EQ(statistics.count(Provenance::feasible) + statistics.count(Provenance::shifted), 10);
  EXPECT_EQ(statistics.all().count(), 30);
}

// Over each horizon, the integral of the input is limited and the ends are linked. Each tick uses
// the plan of the previous one.
TEST_P(EveryBackEnd, EnforcesIntegralAndLinkInEveryTick) {
  const auto problem = [] {
    Phase<1, 1> phase{"budget", Integrator1{}, exactly(step * intervals)};
    phase.minimise("distance", [](auto, auto x, auto u) { return x[0] * x[0] + 0.1 * u[0] * u[0]; })
        .bound_integral(
            "way", [](auto, auto, auto u) { return u[0]; }, at_least(-0.3));
    OptimalControlProblem ocp("budget");
    ocp.start_at({1.0}).then(phase).link(
        "at least a tenth", [](const auto& a, const auto& b) { return b.x[0] - 0.9 * a.x[0]; },
        at_most(0.0), start_of(phase), end_of(phase));
    return MultipleShooting(std::move(ocp),
                            {.intervals_per_phase = intervals, .integrator = runge_kutta4()});
  };
  RecedingHorizonController controller = controller_for(problem(), GetParam());
  MultipleShooting anew = problem();
  VectorXd x = VectorXd::Constant(1, 2.0);  // at first the integral limits the input
  for (int k = 0; k < 12; ++k) {
    anew.start_at(step * k, x);
    const Solution s = solve(anew, *make_ipopt({.tolerance = 1e-9}));
    ASSERT_TRUE(s.ok()) << s.message;
    const ControlTick& tick = controller.tick(step * k, x);
    ASSERT_EQ(tick.provenance, Provenance::optimal) << k;
    EXPECT_NEAR(tick.input[0].input()[0], s.trajectory.input(step * k)[0], 1e-5) << k;
    x[0] += step * tick.input[0].input()[0];
  }
}

TEST(RecedingHorizon, RejectsAFreeStartTime) {
  Phase<1, 1> phase{"any", Integrator1{}, exactly(1.0)};
  phase.minimise("effort", [](auto, auto, auto u) { return u[0] * u[0]; });
  OptimalControlProblem ocp("any time");
  ocp.start_at({1.0}).start_time(between(0.0, 1.0), 0.5).then(phase);
  expect_error<DefinitionError>(
      [&] {
        RecedingHorizonController controller(
            MultipleShooting(ocp, {.intervals_per_phase = 2, .integrator = runge_kutta4()}),
            {.period = step});
      },
      {"give start_time() a number"});
}

INSTANTIATE_TEST_SUITE_P(Solvers, EveryBackEnd,
                         ::testing::Values(Back::stages, Back::riccati, Back::sparse, Back::ipopt),
                         [](const auto& instance) {
                           return instance.param == Back::stages    ? "Stages"
                                  : instance.param == Back::riccati ? "Riccati"
                                  : instance.param == Back::sparse  ? "Sparse"
                                                                    : "Ipopt";
                         });

TEST(RecedingHorizon, ContinuesTheLastPlanAfterAFailedSolve) {
  auto solver = make_real_time_solver(
      std::make_unique<Unreliable>(std::vector<bool>{true, false, true, true}));
  RecedingHorizonController controller(gate(infinity), std::move(solver), {.period = step});
  const VectorXd x = VectorXd::Constant(1, 0.15);
  const ControlTick& tick = controller.tick(0.0, x);
  EXPECT_EQ(tick.provenance, Provenance::fallback);

  controller.tick(0.0, x);
  ASSERT_EQ(tick.provenance, Provenance::optimal);
  const Trajectory plan = controller.report().trajectory;
  controller.tick(step, x);
  EXPECT_EQ(tick.provenance, Provenance::shifted);
  ASSERT_EQ(tick.input.size(), 1u);
  EXPECT_NEAR(tick.input[0].input()[0], plan.input(1.5 * step)[0], 1e-12);

  // After the end of the plan, its last input continues.
  controller.tick(10.0, x);
  EXPECT_EQ(tick.provenance, Provenance::shifted);
  ASSERT_EQ(tick.input.size(), 1u);
  EXPECT_NEAR(tick.input[0].input()[0], plan.input(plan.end_time())[0], 1e-12);
  EXPECT_NEAR(tick.input[0].length, step, 1e-12);
}

// A plan is valid for a limited time. Then the fallback acts until there is a new plan.
TEST(RecedingHorizon, FollowsAPlanNoLongerThanItsLimit) {
  RecedingHorizonController controller =
      controller_for(gate(0.0), Back::stages,
                     {.period = step,
                      .longest_shift = step * intervals,
                      .fallback_input = VectorXd::Constant(1, -1.5)});
  const VectorXd x = VectorXd::Constant(1, 0.15);
  const ControlTick& tick = controller.tick(0.0, x);
  ASSERT_TRUE(is_of_this_tick(tick.provenance));
  for (int k = 1; k <= intervals; ++k) {
    const testing::AllocationCount count;
    controller.tick(step * k, unknown);
    EXPECT_EQ(count.made(), 0);
    EXPECT_EQ(tick.provenance, Provenance::shifted) << k;
  }
  controller.tick(step * (intervals + 1), unknown);
  EXPECT_EQ(tick.provenance, Provenance::fallback);
  EXPECT_EQ(tick.input[0].input()[0], -1.5);
  controller.tick(step * (intervals + 2), x);
  EXPECT_TRUE(is_of_this_tick(tick.provenance));
  controller.tick(step * (intervals + 3), unknown);
  EXPECT_EQ(tick.provenance, Provenance::shifted);
}

TEST(RecedingHorizon, ReportsAnInvalidMeasurement) {
  RecedingHorizonController controller = controller_for(gate(0.0), Back::stages);
  const ControlTick& tick = controller.tick(0.0, unknown);
  EXPECT_TRUE(std::isinf(tick.objective));  // no plan exists, hence no cost
  EXPECT_EQ(controller.report().message, "the measurement is not a number");
  controller.tick(step, VectorXd::Zero(3));
  EXPECT_EQ(controller.report().message, "the measurement has 3 entries, expected 1");
  controller.tick(2 * step, far_away);
  EXPECT_EQ(controller.report().message.find("measurement"), std::string::npos);
  EXPECT_TRUE(std::isfinite(tick.objective));
}

TEST(RecedingHorizon, UsesTheUserFallbackWithinBounds) {
  ControllerOptions options{.period = step, .fallback_input = VectorXd::Constant(1, -1.5)};
  RecedingHorizonController constant = controller_for(gate(0.05), Back::riccati, options);
  const ControlTick& tick = constant.tick(0.0, unknown);
  ASSERT_EQ(tick.input.size(), 2u);
  EXPECT_EQ(tick.input[0].input()[0], -1.0);  // the gate is closed
  EXPECT_EQ(tick.input[1].input()[0], -1.5);

  options.fallback = [](double t, const VectorRef&, VectorOut u) { u[0] = t; };
  RecedingHorizonController function = controller_for(gate(0.0), Back::riccati, options);
  EXPECT_NEAR(function.tick(0.5, unknown).input[0].input()[0], 0.5, 1e-12);
  options.fallback = [](double, const VectorRef& x, VectorOut u) { u[0] = x[0]; };
  RecedingHorizonController nan = controller_for(gate(0.0), Back::riccati, options);
  EXPECT_EQ(nan.tick(0.5, unknown).input[0].input()[0], -1.5);
  options.fallback = [](double, const VectorRef&, VectorOut) { throw std::runtime_error("no"); };
  RecedingHorizonController throws = controller_for(gate(0.0), Back::riccati, options);
  EXPECT_EQ(throws.tick(0.5, unknown).input[0].input()[0], -1.5);
}

TEST(RecedingHorizon, RejectsInvalidOptionsAtSetUp) {
  EXPECT_THROW(controller_for(gate(0.0), Back::ipopt, {.period = 0.0}), DefinitionError);
  // Periods as short as the resolution of one instant.
  for (const double period : {5e-7, 1e-6, 10.0 * same_instant})
    EXPECT_THROW(controller_for(gate(0.0), Back::ipopt, {.period = period}), DefinitionError);
  EXPECT_NO_THROW(controller_for(gate(0.0), Back::ipopt, {.period = 2e-5}));
  EXPECT_THROW(controller_for(gate(0.0), Back::ipopt, {.period = step, .deadline = 0.0}),
               DefinitionError);
  EXPECT_THROW(
      controller_for(gate(0.0), Back::ipopt, {.period = step, .fallback_input = VectorXd::Zero(2)}),
      DefinitionError);
  EXPECT_THROW(controller_for(gate(0.0), Back::ipopt, {.period = step, .deadline = 2 * step}),
               DefinitionError);
  EXPECT_THROW(controller_for(gate(0.0), Back::ipopt, {.period = step * (intervals + 1)}),
               DefinitionError);
  EXPECT_THROW(controller_for(gate(0.0), Back::ipopt, {.period = step, .longest_shift = -1.0}),
               DefinitionError);
}

TEST(RecedingHorizon, PreparationDoesNotChangeTheInput) {
  RecedingHorizonController one = controller_for(gate(0.137), Back::riccati);
  RecedingHorizonController other = controller_for(gate(0.137), Back::riccati);
  for (int k = 0; k < 5; ++k) {
    const VectorXd x = VectorXd::Constant(1, 0.3 - 0.05 * k);
    one.prepare(step * k);
    const ControlTick& prepared = one.feedback(x);
    const ControlTick& at_once = other.tick(step * k, x);
    ASSERT_EQ(prepared.input.size(), at_once.input.size());
    EXPECT_EQ(prepared.input[0].input()[0], at_once.input[0].input()[0]);
    EXPECT_EQ(prepared.iterations, at_once.iterations);
  }
}

TEST(RecedingHorizon, NanTimeMeansThePreparedTime) {
  RecedingHorizonController controller = controller_for(gate(0.137), Back::riccati);
  controller.tick(0.2, far_away);
  const double nan = std::nan("");
  controller.prepare(0.3);
  EXPECT_EQ(controller.tick(nan, far_away).time, 0.3);
  EXPECT_EQ(controller.statistics().prepared_ahead, 1);
  controller.prepare(0.4);
  controller.retime("open", 0.6);  // invalidates the prepared problem but not its time
  EXPECT_EQ(controller.tick(nan, far_away).time, 0.4);
  EXPECT_NEAR(controller.tick(nan, far_away).time, 0.5, 1e-12);
  controller.prepare(nan);
  EXPECT_NEAR(controller.tick(nan, far_away).time, 0.6, 1e-12);
}

// A pendulum, x = (angle, speed): one iteration per tick tracks the optimum.
struct Pendulum {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], sin(x[0]) + u[0]};
  }
};
// The pendulum with a push as data, or without gravity.
template <bool nonlinear>
struct Pushed {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>& p) const {
    return {x[1], (nonlinear ? S(sin(x[0])) : x[0]) + u[0] + p[0]};
  }
};
MultipleShooting pendulum() {
  Phase<2, 1> phase{"pendulum", Pendulum{}, exactly(1.0)};
  phase.bound_input(0, between(-2.0, 2.0))
      .track(
          "upright", [](const auto&, const auto& x) { return x; }, Vec<double, 2>{10.0, 1.0})
      .track(
          "torque", [](const auto&, const auto&, const auto& u) { return u; }, Vec<double, 1>{0.1});
  OptimalControlProblem ocp("pendulum");
  ocp.start_at({0.5, 0.0}).then(phase);
  return MultipleShooting(std::move(ocp),
                          {.intervals_per_phase = 10, .integrator = runge_kutta4()});
}

// Preparation ahead of the tick, with later changes of data. The answer equals that of a controller
// that does all work in the tick.
TEST(RecedingHorizon, PreparesAheadOfDataAndOfTheSameSchedule) {
  for (const bool nonlinear : {false, true}) {
    const auto make = [&] {
      using Swing = Phase<2, 1, 1>;
      Swing phase = nonlinear ? Swing{"swing", Pushed<true>{}, exactly(1.0)}
                              : Swing{"swing", Pushed<false>{}, exactly(1.0)};
      phase.data("push", Vec<double, 1>{0.0})
          .bound_input(0, between(-2.0, 2.0), Window{.to = event("open")})
          .track(
              "upright", [](const auto&, const auto& x) { return x; }, Vec<double, 2>{10.0, 1.0})
          .track(
              "torque", [](const auto&, const auto&, const auto& u) { return u; },
              Vec<double, 1>{0.1});
      OptimalControlProblem ocp("swing");
      ocp.schedule(Schedule({"closed", "open"}, {{"open", 0.537}})).start_at({0.5, 0.0});
      ocp.then(phase);
      return controller_for(MultipleShooting(std::move(ocp), {.intervals_per_phase = 10,
                                                              .integrator = runge_kutta4()}),
                            Back::stages);
    };
    RecedingHorizonController ahead = make(), at_once = make();
    constexpr int ticks = 8, moved = 5;
    for (int k = 0; k < ticks; ++k) {
      const double t = step * k;
      ahead.prepare(t);
      for (RecedingHorizonController* controller : {&ahead, &at_once}) {
        controller->set_data("push", VectorXd::Constant(1, 0.1 * k));
        controller->retime("open", k < moved ? 0.537 : 0.612);
        controller->set_previous_input(VectorXd::Zero(1));
      }
      const VectorXd x = Vec<double, 2>{0.5 - 0.05 * k, 0.1};
      const ControlTick& prepared = ahead.feedback(x);
      EXPECT_EQ(prepared.time, t);  // also after a repeated preparation
      const ControlTick& late = at_once.tick(t, x);
      ASSERT_TRUE(is_of_this_tick(prepared.provenance)) << k;
      EXPECT_EQ(prepared.input[0].input()[0], late.input[0].input()[0]) << k;
      EXPECT_EQ(prepared.iterations, late.iterations) << k;
      EXPECT_GT(prepared.preparation, 0.0);
      // The time of the tick excludes the preparation.
      if (k != moved) {
        EXPECT_EQ(prepared.seconds, prepared.feedback);
      }
      EXPECT_NEAR(late.seconds, late.feedback + late.preparation, 1e-9);
    }
    EXPECT_EQ(ahead.statistics().prepared_ahead, ticks - 1);  // the event moved once
    EXPECT_EQ(at_once.statistics().prepared_ahead, 0);
    EXPECT_EQ(ahead.statistics().preparation.count(), ticks);
  }
}

// Stores its start and succeeds on demand.
class Watching final : public RealTimeSolver {
 public:
  Watching(VectorXd& guess, bool& succeeds) : guess_(&guess), succeeds_(&succeeds) {}
  void prepare(NonlinearProgram&, const NlpPoint& guess) noexcept override { *guess_ = guess.w; }
  RealTimeSolver::Result feedback(NonlinearProgram&, NlpPoint& point, bool,
                                  WallClock::time_point) noexcept override {
    RealTimeSolver::Result result;
    result.status = *succeeds_ ? SolveStatus::optimal : SolveStatus::infeasible;
    point.w.array() += 0.25;  // marks the result of the solver
    return result;
  }
  std::string name() const override { return "watching"; }

 private:
  VectorXd* guess_;
  bool* succeeds_;
};

// The guess is relative to the start of the problem, for any clock time at which the controller
// starts. This includes the guess of free durations.
TEST(RecedingHorizon, StartsWithTheGuessOfTheProblem) {
  Phase<2, 1> swing{"swing", Pendulum{}, between(0.0, 2.0)}, rest{"rest", Pendulum{}, exactly(1.0)};
  swing.guess_duration(0.8).guess_state(
      Guess::interpolate(Vec<double, 2>{0.5, 0.0}, Vec<double, 2>{0.0, 0.1}));
  OptimalControlProblem ocp("swing and rest");
  ocp.start_at({0.5, 0.0}).then(swing).then(rest);
  MultipleShooting shooting(std::move(ocp),
                            {.intervals_per_phase = 4, .integrator = runge_kutta4()});
  const VectorXd given = shooting.initial_guess().w;
  VectorXd guess;
  bool succeeds = false;
  RecedingHorizonController controller(
      std::move(shooting), std::make_unique<Watching>(guess, succeeds), {.period = step});
  for (const double t : {100.0, 100.1}) {
    EXPECT_EQ(controller.tick(t, VectorXd{{0.5, 0.0}}).provenance, Provenance::fallback);
    EXPECT_EQ(guess, given) << t;
  }
}

TEST(RecedingHorizon, NextSolveStartsFromTheAdoptedPlan) {
  VectorXd guess;
  bool succeeds = true;
  RecedingHorizonController controller(pendulum(), std::make_unique<Watching>(guess, succeeds),
                                       {.period = step});
  const VectorXd x{{0.5, 0.0}};
  ASSERT_TRUE(is_of_this_tick(controller.tick(0.0, x).provenance));
  const Trajectory plan = controller.report().trajectory;
  succeeds = false;
  for (const double t : {0.0, 0.0}) controller.tick(t, x);  // every second tick starts anew
  controller.adopt_plan(0.0, plan);
  EXPECT_TRUE(controller.follows_plan());
  controller.tick(0.0, x);
  const VectorXd adopted = controller.shooting().guess_from(plan).w;
  EXPECT_LT((guess - adopted).norm(), 1e-12);  // interpolated at the nodes of the problem
  EXPECT_GT((guess - controller.shooting().initial_guess().w).norm(), 0.1);
}

TEST(RealTimeIteration, OneModelPerTickApproachesTheOptimum) {
  RecedingHorizonController iterated = controller_for(pendulum(), Back::stages);
  RecedingHorizonController converged = controller_for(pendulum(), Back::ipopt);
  ASSERT_FALSE(iterated.shooting().nlp().is_linear_quadratic());
  IntervalProblem interval;
  interval.arguments = {2, 1, 0};
  interval.dynamics = make_function<2, 1, 0>(Pendulum{});
  const auto plant = runge_kutta4()->make(interval);
  Vec<double, 2> x{0.5, 0.0};
  for (int k = 0; k < 30; ++k) {
    const ControlTick& tick = iterated.tick(step * k, x);
    const ControlTick& truth = converged.tick(step * k, x);
    // One step of the real-time iteration may or may not be optimal. Its provenance must say which.
    const bool is_within = tick.violation <= 1e-6, is_optimal = is_within && tick.kkt <= 1e-6;
    ASSERT_EQ(tick.provenance, is_optimal  ? Provenance::optimal
                               : is_within ? Provenance::feasible
                                           : Provenance::step);
    if (k == 0) {
      ASSERT_EQ(tick.provenance, Provenance::step);
    }
    ASSERT_EQ(truth.provenance, Provenance::optimal);
    if (k > 3) {
      EXPECT_NEAR(tick.input[0].input()[0], truth.input[0].input()[0], 2e-3) << k;
    }
    const double w[] = {x[0], x[1], tick.input[0].input()[0], step * k, step};
    ASSERT_EQ(plant->value(w, x.data()), IntegrationStatus::success);
  }
  EXPECT_LT(x.norm(), 0.05);
}

TEST(NoAllocation, OccursInTicksOfLinearQuadraticAndNonlinearProblems) {
  for (const Back which : {Back::stages, Back::riccati, Back::sparse}) {
    RecedingHorizonController controller = controller_for(gate(0.537), which);
    RecedingHorizonController nonlinear = controller_for(pendulum(), which);
    VectorXd x = VectorXd::Constant(1, 0.6);
    VectorXd y = Vec<double, 2>{0.5, 0.0};
    controller.tick(-step, x);
    nonlinear.tick(-step, y);
    const testing::AllocationCount count;
    long failures = 0;
    for (int k = 0; k < 12; ++k) {
      if (k == 5) controller.retime("open", 0.612);
      const ControlTick& tick = controller.tick(step * k, k == 3 ? unknown : x);
      failures += tick.provenance != Provenance::optimal ? 1 : 0;
      nonlinear.prepare(step * k);
      failures += is_of_this_tick(nonlinear.feedback(y).provenance) ? 0 : 1;
      x[0] -= 0.05;
      y *= 0.9;
    }
    EXPECT_EQ(count.made(), 0) << static_cast<int>(which);
    EXPECT_EQ(failures, 1);
  }
}

}  // namespace
}  // namespace saltus
