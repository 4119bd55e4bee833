// The log contains each violation of the controller's problem in a closed loop.
#include "saltus/simulation/loop_log.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/simulation/closed_loop.hpp"

namespace saltus {
namespace {

struct Cart {
  double strength = 1.0;  // m/s^2 per unit of input
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], strength * u[0]};
  }
};

const auto whole_state = [](const auto&, const auto& x) { return x; };
const auto effort = [](const auto&, const auto&, const auto& u) { return u; };

// A cart moves by 1 m and stops within one second.
OptimalControlProblem transfer(double strength = 1.0) {
  Phase<2, 1> go{"go", Cart{strength}, exactly(1.0)};
  go.reach("there", whole_state, std::vector<Bounds>{exactly(1.0), exactly(0.0)})
      .bound_input(0, between(-8.0, 8.0))
      .track("effort", effort, VectorXd::Ones(1));
  OptimalControlProblem problem("transfer");
  problem.start_at({0.0, 0.0}).then(go);
  return problem;
}

LoopLog run_transfer(double strength, const LoopOptions& options) {
  const OptimalControlProblem problem = transfer();
  const ShootingOptions grid{.intervals_per_phase = 20, .integrator = runge_kutta4()};
  ShrinkingHorizonController controller(
      problem, remaining_controllers(problem, grid, [](MultipleShooting rest) {
        return RecedingHorizonController(std::move(rest), {.period = 0.05});
      }));
  PhasedPlant plant(transfer(strength), runge_kutta4());
  return simulate_closed_loop(controller, plant, options);
}

TEST(LoopMisses, CorrectLoopHasNoMisses) {
  const LoopLog log = run_transfer(1.0, {.duration = 2.0});
  EXPECT_TRUE(log.ok()) << log.message;
  EXPECT_TRUE(log.misses.empty());
  EXPECT_NE(log.summary_json().find("\"ok\": true"), std::string::npos);
}

TEST(LoopMisses, MissedEndIsInTheLog) {
  const LoopLog log = run_transfer(0.7, {.duration = 2.0});
  EXPECT_TRUE(log.completed);
  EXPECT_FALSE(log.ok());
  ASSERT_FALSE(log.misses.empty()) << log.message;
  const VectorXd end = log.final_state();
  const LoopMiss& worst = log.misses.front();
  EXPECT_EQ(worst.phase, "go");
  EXPECT_EQ(worst.term, "there");
  EXPECT_TRUE(worst.at_end);
  EXPECT_NEAR(worst.time, 1.0, 1e-6);
  EXPECT_NEAR(worst.amount, std::max(std::abs(end[0] - 1.0), std::abs(end[1])), 1e-9);
  EXPECT_EQ(worst.tolerance, 1e-6);  // no bound is above 1
  EXPECT_NE(log.message.find("'there' is missed by"), std::string::npos) << log.message;
  const std::string json = log.summary_json();
  EXPECT_NE(json.find("\"ok\": false"), std::string::npos) << json;
  EXPECT_NE(json.find("\"term\": \"there\""), std::string::npos) << json;

  LoopOptions wide{.duration = 2.0};
  wide.tolerance.of_term["there"] = 10.0;
  EXPECT_TRUE(run_transfer(0.7, wide).ok());
}

TEST(LoopMisses, TooShortRunIsNotOk) {
  const LoopLog log = run_transfer(1.0, {.duration = 0.5});
  EXPECT_TRUE(log.completed);
  EXPECT_FALSE(log.reached_end);
  EXPECT_FALSE(log.ok());
  EXPECT_NE(log.message.find("before the end of the motion"), std::string::npos) << log.message;
  LoopOptions asked{.duration = 2.0};
  asked.until = [](double t, const VectorRef&) { return t > 0.4; };
  EXPECT_TRUE(run_transfer(1.0, asked).ok()) << "the run ended at its own condition";
}

// A receding horizon has no end constraints. The speed of the plant violates its bound and a row
// with data.
TEST(LoopMisses, RecedingHorizonReportsBoundsAndPathConstraints) {
  Phase<2, 1> hold{"hold", Cart{}, exactly(1.0)};
  hold.bound_input(0, between(-20.0, 20.0))
      .bound_state(1, between(-3.0, 3.0))
      .keep(
          "slow", [](const auto& t, const auto& x) { return x[1] + 0.0 * t; }, at_most(2.0))
      .reach("home", whole_state, between(-0.5, 0.5))
      .track("state", whole_state, VectorXd::Ones(2))
      .track("effort", effort, VectorXd::Constant(1, 0.1));
  OptimalControlProblem problem("hold");
  problem.start_at({0.0, 0.0}).then(hold);
  const auto run = [&](double push) {
    MultipleShooting shooting(problem, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
    RecedingHorizonController controller(std::move(shooting), {.period = 0.1});
    IntegratorPlant plant = nominal_plant(problem, runge_kutta4());
    LoopOptions options{.duration = 1.0};
    options.disturbances.state = [=](double t, const VectorRef&, VectorOut change) {
      if (std::abs(t - 0.3) < 1e-9) change[1] = push;
    };
    return simulate_closed_loop(controller, plant, options);
  };
  EXPECT_TRUE(run(0.5).ok()) << run(0.5).message;
  const LoopLog log = run(4.0);
  EXPECT_TRUE(log.completed) << log.message;
  EXPECT_FALSE(log.ok());
  ASSERT_EQ(log.misses.size(), 2u) << log.message;
  EXPECT_EQ(log.misses[0].term, "slow");
  EXPECT_NEAR(log.misses[0].amount, 2.0, 1e-6);
  EXPECT_NEAR(log.misses[0].time, 0.3, 1e-9);
  EXPECT_FALSE(log.misses[0].at_end);
  EXPECT_EQ(log.misses[0].tolerance, 2e-6);
  EXPECT_EQ(log.misses[1].term, "state 1");
  EXPECT_NEAR(log.misses[1].amount, 1.0, 1e-6);
  EXPECT_EQ(log.misses[1].tolerance, 3e-6);
}

// Without a controller's problem, the problem of the plant defines the violations.
TEST(LoopMisses, FeedbackLawIsJudgedByThePlantProblem) {
  PhasedPlant plant(transfer(), runge_kutta4());
  plant.end_phase_at(0, 1.0);
  const LoopLog log =
      simulate_closed_loop([](double, const VectorRef&, VectorOut u) { u[0] = 9.0; }, plant,
                           {.duration = 1.0, .period = 0.1});
  EXPECT_FALSE(log.ok());
  ASSERT_EQ(log.misses.size(), 2u) << log.message;
  for (const LoopMiss& miss : log.misses)
    EXPECT_NEAR(miss.amount, miss.term == "input 0" ? 1.0 : 9.0, 1e-9) << miss.term;
}

TEST(LoopMisses, HugeBoundDoesNotHideAViolationOfTheOtherBound) {
  const auto speed_of = [](double lower) {
    Phase<1, 1> phase{"go", [](auto, const auto&, const auto& u) { return u; }, exactly(1.0)};
    phase.bound_input(0, between(lower, 1.0));
    OptimalControlProblem problem("one-sided");
    problem.start_at({0.0}).then(phase);
    return problem;
  };
  for (const double lower : {-1.0, -1e10, -1e15}) {
    PhasedPlant plant(speed_of(lower), runge_kutta4());
    plant.end_phase_at(0, 1.0);
    const LoopLog log =
        simulate_closed_loop([](double, const VectorRef&, VectorOut u) { u[0] = 1.5; }, plant,
                             {.duration = 1.0, .period = 0.1});
    ASSERT_EQ(log.misses.size(), 1u) << log.message;
    EXPECT_EQ(log.misses.front().amount, 0.5);
    EXPECT_EQ(log.misses.front().tolerance, 1e-6);
  }
}

TEST(LoopMisses, TolerancesAreChecked) {
  const auto run_with = [](const MissRecord::Tolerance& tolerance) {
    run_transfer(1.0, {.duration = 2.0, .tolerance = tolerance});
  };
  EXPECT_THROW(run_with({.relative = std::nan("")}), DefinitionError);
  EXPECT_THROW(run_with({.relative = -1.0}), DefinitionError);
  EXPECT_THROW(run_with({.of_term = {{"there", std::nan("")}}}), DefinitionError);
  EXPECT_THROW(run_with({.of_term = {{"here", 1.0}}}), DefinitionError);
}

TEST(LoopMisses, TolerancesFollowBoundsAndNominalValues) {
  MissRecord::Tolerance tolerance;
  EXPECT_DOUBLE_EQ(tolerance.of("any", at_most(0.1)), 1e-6);
  EXPECT_DOUBLE_EQ(tolerance.of("any", between(-200.0, 3.0)), 2e-4);
  EXPECT_DOUBLE_EQ(tolerance.of("any", at_most(0.0), 50.0), 5e-5);
  tolerance.of_term["any"] = 0.5;
  EXPECT_EQ(tolerance.of("any", at_most(0.0)), 0.5);
  EXPECT_EQ(tolerance.of("other", at_most(0.0)), 1e-6);
}

}  // namespace
}  // namespace saltus
