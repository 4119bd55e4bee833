// A plant with phases: each phase ends at its guard or at the time in the plan, and the plant
// reports the cost.
#include "saltus/simulation/plants.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/simulation/closed_loop.hpp"
#include "saltus/solver/native_solver.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using namespace testing_support;

// The ball falls to the ground, loses a fifth of its speed, and rises for some time.
OptimalControlProblem bounce(bool with_ceiling = false) {
  Phase<2, 1> fall{"fall", Ball{}, between(0.1, 0.9)}, rise{"rise", Ball{}, between(0.1, 0.9)};
  fall.ends_when("impact", height, Crossing::falling).minimise("effort", effort);
  if (with_ceiling) rise.keep("ceiling", height, at_most(0.3));
  rise.minimise("effort", effort)
      .reach("back", height, exactly(1.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("height", height);
  for (auto* phase : {&fall, &rise}) phase->guess_duration(0.5);
  const auto map = [](const auto&, const auto& x) { return decltype(x.eval()){x[0], -0.8 * x[1]}; };
  OptimalControlProblem ocp("bounce");
  ocp.start_at({1, 0}).then(fall).then(rise, jump<2>("bounce", map)).total_time(exactly(1.0));
  return ocp;
}

TEST(PhasedPlant, GuardEndsAPhaseAtItsZero) {
  PhasedPlant plant(bounce(), runge_kutta4());
  const VectorXd none = VectorXd::Zero(1);
  plant.end_phase_at(0, 0.1);  // ignored: the guard decides
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(plant.advance(none, 0.1)) << plant.failure();
  const double impact = std::sqrt(2.0 / gravity);
  const std::vector<HybridEvent> events = plant.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].name, "impact");
  EXPECT_EQ(events[0].kind, HybridEvent::Kind::jumps);
  EXPECT_NEAR(events[0].time, impact, 1e-12);  // quadratic in time: order four is exact
  EXPECT_NEAR(events[0].before[1], -gravity * impact, 1e-12);
  EXPECT_NEAR(events[0].after[1], 0.8 * gravity * impact, 1e-12);
  EXPECT_EQ(plant.phase(), 1);
  EXPECT_EQ(plant.mode(), "rise");
  const double since = 0.5 - impact;
  EXPECT_NEAR(plant.state()[0], 0.8 * gravity * impact * since - 0.5 * gravity * since * since,
              1e-12);
}

// A cost is not defined outside its window, because the root of a negative number is NaN.
TEST(PhasedPlant, EvaluatesACostInItsWindowOnly) {
  Phase<2, 1> fall{"fall", Ball{}, exactly(0.4)};
  const auto root = [](const auto& t, const auto&) { return sqrt(t - 0.1); };
  fall.minimise("late", root, Window{.from = 0.2});
  OptimalControlProblem ocp("fall");
  PhasedPlant plant(ocp.start_at({1, 0}).then(fall), runge_kutta4());
  for (int k = 0; k < 4; ++k) ASSERT_TRUE(plant.advance(VectorXd::Zero(1), 0.1)) << plant.failure();
  constexpr double by_runge_kutta = 1e-5;  // h^5 f'''' / 2880 per interval of 0.1 s
  EXPECT_NEAR(plant.cost(), (std::pow(0.3, 1.5) - std::pow(0.1, 1.5)) / 1.5, by_runge_kutta);
}

// A failed integration leaves the plant at the start of the piece.
TEST(PhasedPlant, KeepsItsStateIfAPieceFails) {
  const auto root = [](const auto&, const auto& x, const auto& u) {
    using std::sqrt;
    return std::decay_t<decltype(x)>{sqrt(-1.0 - x[0] * x[0]), u[0]};
  };
  Phase<2, 1> first{"first", Cart{}, between(0.1, 0.9)}, second{"second", root, exactly(1.0)};
  first.minimise("effort", effort).guess_duration(0.5);
  OptimalControlProblem ocp("into nothing");
  ocp.start_at({1, 0}).then(first).then(second);
  PhasedPlant plant(ocp, runge_kutta4());
  plant.end_phase_at(0, 0.5);
  EXPECT_FALSE(plant.advance(VectorXd::Ones(1), 1.0));
  EXPECT_NE(plant.failure(), "");
  EXPECT_EQ(plant.time(), 0.0);
  EXPECT_EQ(plant.phase(), 0);
  EXPECT_EQ(plant.cost(), 0.0);
  EXPECT_TRUE(plant.take_events().empty());
  ASSERT_TRUE(plant.advance(VectorXd::Ones(1), 0.4));  // a shorter piece
  EXPECT_EQ(plant.time(), 0.4);
  EXPECT_NEAR(plant.state()[1], 0.4, 1e-12);
}

TEST(PhasedPlant, RejectsBackwardTime) {
  PhasedPlant plant(bounce(), runge_kutta4());
  EXPECT_FALSE(plant.advance(VectorXd::Zero(plant.inputs()), -0.1));
  EXPECT_NE(plant.failure().find("-0.1 s"), std::string::npos) << plant.failure();
  EXPECT_EQ(plant.time(), 0.0);
}

TEST(PhasedPlant, EndsAtThePlannedTimeWithCostsAndMisses) {
  PhasedPlant plant(bounce(true), runge_kutta4());
  const VectorXd thrust = VectorXd::Constant(1, 2.0);
  ASSERT_TRUE(plant.advance(thrust, 0.7));
  plant.end_phase_at(1, 0.85);
  ASSERT_TRUE(plant.advance(thrust, 0.3));
  ASSERT_TRUE(plant.is_over());
  EXPECT_EQ(plant.over_since(), 0.85);
  EXPECT_NEAR(plant.time(), 1.0, 1e-12);
  const double end = plant.state()[0];
  EXPECT_NEAR(plant.cost(), 0.85 * 2.0 + end, 1e-12);
  for (const PhasedPlant::Miss& miss : plant.end_misses())
    if (miss.term == "back")
      EXPECT_NEAR(miss.amount, 1.0 - end, 1e-12);
    else if (miss.term == "impact")  // value of the guard, zero except for rounding
      EXPECT_LT(miss.amount, 1e-12);
    else
      EXPECT_EQ(miss.term, "at rest");
  ASSERT_EQ(plant.path_misses().size(), 1u);
  EXPECT_NEAR(plant.path_misses()[0].amount, end - 0.3, 1e-12);
  plant.disturb(VectorXd::Ones(2));  // the plant has ended
  EXPECT_EQ(plant.state()[0], end);
}

TEST(PhasedPlant, DisturbanceAcrossTheGuardEndsThePhase) {
  PhasedPlant plant(bounce(), runge_kutta4());
  ASSERT_TRUE(plant.advance(VectorXd::Zero(1), 0.2));
  plant.disturb(VectorXd{{-2.0, 0.0}});
  ASSERT_TRUE(plant.advance(VectorXd::Zero(1), 0.01));
  EXPECT_EQ(plant.phase(), 1);
  EXPECT_EQ(plant.take_events().at(0).time, 0.2);
  EXPECT_TRUE(plant.path_misses().empty());
}

TEST(PhasedPlant, DisturbanceAcrossTheGuardAndBackChangesNothing) {
  PhasedPlant plant(bounce(), runge_kutta4());
  ASSERT_TRUE(plant.advance(VectorXd::Zero(1), 0.2));
  plant.disturb(VectorXd{{-2.0, 0.0}});
  plant.disturb(VectorXd{{2.0, 0.0}});
  ASSERT_TRUE(plant.advance(VectorXd::Zero(1), 0.01));
  EXPECT_EQ(plant.phase(), 0);
}

// x' = 1, up to 1, then up to 2, then further. A jump takes x from 1 to 1 + hop.
double end_of_the_second(double hop) {
  const auto ramp = [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; };
  const auto level = [](double at) {
    return [at](const auto&, const auto& x) { return x[0] - at; };
  };
  Phase<1, 0> a{"a", ramp, between(0.1, 2.0)}, b{"b", ramp, between(0.0, 2.0)},
      c{"c", ramp, between(0.1, 9.0)};
  a.ends_when("one", level(1.0), Crossing::rising).guess_duration(1.0);
  b.ends_when("two", level(2.0), Crossing::rising).guess_duration(1.0);
  OptimalControlProblem ocp("hop");
  ocp.start_at({0.0}).then(a).then(
      b, jump<1>("hop", [hop](const auto&, const auto& x) { return x[0] + hop; }));
  ocp.then(c.guess_duration(1.0));
  PhasedPlant plant(ocp, runge_kutta4());
  for (int k = 0; k < 30; ++k) plant.advance(VectorXd(0), 0.1);
  const std::vector<HybridEvent> events = plant.take_events();
  if (events.size() == 2) return events[1].time;
  return infinity;
}

TEST(PhasedPlant, PhaseStartingBeyondItsGuardEndsImmediately) {
  EXPECT_NEAR(end_of_the_second(0.5), 1.5, 1e-12);
  EXPECT_NEAR(end_of_the_second(1.0), 1.0, 1e-12);
  EXPECT_NEAR(end_of_the_second(1.5), 1.0, 1e-12);
}

// The ball starts upward from the ground, or slightly below it because of rounding.
TEST(PhasedPlant, BallFliesUntilItLands) {
  for (const double height_at_first : {0.0, -1e-17, 1e-17}) {
    Phase<2, 1> fly{"fly", Ball{}, between(0.1, 2.0)}, rest{"rest", Ball{}, between(0.1, 2.0)};
    fly.ends_when("impact", height, Crossing::falling).guess_duration(0.5);
    OptimalControlProblem ocp("throw");
    ocp.start_at({height_at_first, gravity / 4.0}).then(fly).then(rest.guess_duration(0.5));
    PhasedPlant plant(ocp, runge_kutta4());
    for (int k = 0; k < 6; ++k) ASSERT_TRUE(plant.advance(VectorXd::Zero(1), 0.1));
    const std::vector<HybridEvent> events = plant.take_events();
    ASSERT_EQ(events.size(), 1u) << height_at_first;
    EXPECT_NEAR(events[0].time, 0.5, 1e-12);
  }
}

// A throw from the ground, with and without rounding. It may end within one piece.
TEST(PhasedPlant, ShortHopEndsOnTheGround) {
  for (const double height_at_first : {0.0, 1e-17, -1e-17, 1e-12})
    for (const double flight : {0.02, 0.05, 0.08, 0.1, 0.13, 0.2, 0.3}) {
      Phase<2, 1> fly{"fly", Ball{}, between(0.01, 2.0)}, rest{"rest", Cart{}, between(0.1, 2.0)};
      fly.ends_when("land", height, Crossing::falling).guess_duration(0.1);
      const auto stop = [](const auto&, const auto& x) { return decltype(x.eval()){x[0], 0.0}; };
      OptimalControlProblem ocp("hop");
      ocp.start_at({height_at_first, 0.5 * gravity * flight})
          .then(fly)
          .then(rest.guess_duration(0.5), jump<2>("stop", stop));
      PhasedPlant plant(ocp, runge_kutta4());
      for (int k = 0; k < 5; ++k) ASSERT_TRUE(plant.advance(VectorXd::Zero(1), 0.1));
      const std::vector<HybridEvent> events = plant.take_events();
      ASSERT_EQ(events.size(), 1u) << height_at_first << ' ' << flight;
      // 1e-12 m at 0.1 m/s; quadratic in time, so that order four is exact.
      EXPECT_NEAR(events[0].time, flight, 2e-11) << height_at_first;
      EXPECT_NEAR(plant.state()[0], 0.0, 1e-12);
    }
}

// The ball returns from half a metre below the ground, or turns before it gets there.
TEST(PhasedPlant, StartBeyondTheGuardReturnsOrEndsAtTheTurn) {
  const auto run = [](double pull) {
    const auto field = [pull](const auto&, const auto& x, const auto&) {
      return decltype(x.eval()){x[1], pull + 0.0 * x[0]};
    };
    Phase<2, 1> rise{"rise", field, between(0.01, 5.0)}, rest{"rest", Cart{}, between(0.1, 2.0)};
    rise.ends_when("down", height, Crossing::falling).guess_duration(0.5);
    OptimalControlProblem ocp("below");
    ocp.start_at({-0.5, 1.0}).then(rise).then(rest.guess_duration(0.5));
    PhasedPlant plant(ocp, runge_kutta4());
    for (int k = 0; k < 40; ++k) EXPECT_TRUE(plant.advance(VectorXd::Zero(1), 0.1));
    const std::vector<HybridEvent> events = plant.take_events();
    return events.size() == 1 ? events[0].time : infinity;
  };
  EXPECT_NEAR(run(-0.75), (1.0 + std::sqrt(0.25)) / 0.75, 1e-12);
  EXPECT_NEAR(run(-2.0), 0.5, 1e-12);  // at -0.25 m
}

OptimalControlProblem standing(double x0 = 0.0) {
  Phase<2, 1> stand{"stand", Cart{}, between(0.01, 5.0)}, fly{"fly", Ball{}, between(0.01, 5.0)};
  stand.ends_when("lift-off", height, Crossing::rising).guess_duration(0.5);
  OptimalControlProblem ocp("standing");
  ocp.start_at({x0, 0.0}).then(stand).then(fly.guess_duration(0.5));
  return ocp;
}

TEST(PhasedPlant, RestOnTheGuardLastsUntilAPush) {
  PhasedPlant by_force(standing(), runge_kutta4());
  for (const double u : {0.0, -0.0, 0.0}) by_force.advance(VectorXd{{u}}, 0.1);
  EXPECT_EQ(by_force.phase(), 0);
  ASSERT_TRUE(by_force.advance(VectorXd{{5.0}}, 0.1));
  EXPECT_EQ(by_force.phase(), 1);
  EXPECT_NEAR(by_force.take_events().at(0).time, 0.3, 1e-12);
  for (const double lift : {0.0, 0.1}) {
    PhasedPlant by_kick(standing(), runge_kutta4());
    ASSERT_TRUE(by_kick.advance(VectorXd::Zero(1), 0.1));
    by_kick.disturb(VectorXd{{lift, 1.0}});
    ASSERT_TRUE(by_kick.advance(VectorXd::Zero(1), 0.1));
    EXPECT_EQ(by_kick.phase(), 1) << lift;
    EXPECT_NEAR(by_kick.take_events().at(0).time, 0.1, 1e-12);
    EXPECT_NEAR(by_kick.state()[1], 1.0 - 0.1 * gravity, 1e-12);
  }
}

TEST(PhasedPlant, NanGuardIsAFailure) {
  const auto ramp = [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; };
  const auto root = [](const auto&, const auto& x) {
    using std::sqrt;
    return -sqrt(0.25 - x[0]);
  };
  Phase<1, 0> a{"a", ramp, between(0.01, 9.0)}, b{"b", ramp, between(0.01, 9.0)};
  a.ends_when("edge", root, Crossing::rising).guess_duration(0.2);
  OptimalControlProblem ocp("edge");
  ocp.start_at({0.0}).then(a).then(b.guess_duration(0.2));
  PhasedPlant plant(ocp, runge_kutta4());
  ASSERT_TRUE(plant.advance(VectorXd(0), 0.2));
  EXPECT_FALSE(plant.advance(VectorXd(0), 0.1));
  EXPECT_EQ(plant.failure(), "the guard of phase 'a' is not finite at t = 0.3 s");
  EXPECT_EQ(plant.time(), 0.2);
}

// x' is the sum of the inputs. The phases have 1, 3 and 2 inputs.
template <int nu>
Phase<1, nu> summing(const char* name) {
  const auto sum = [](const auto&, const auto& x, const auto& u) { return u.sum() + 0.0 * x[0]; };
  return Phase<1, nu>{name, sum, between(0.01, 5.0)}.guess_duration(0.2);
}

TEST(PhasedPlant, FeedbackLawSetsInputsOfTheCurrentPhase) {
  const auto level = [](double at) {
    return [at](const auto&, const auto& x) { return x[0] - at; };
  };
  Phase<1, 1> a = summing<1>("a");
  Phase<1, 3> b = summing<3>("b");
  a.ends_when("one", level(0.25), Crossing::rising);
  b.ends_when("two", level(1.0), Crossing::rising);
  OptimalControlProblem ocp("sums");
  ocp.start_at({0.0}).then(a).then(b).then(summing<2>("c"));
  PhasedPlant plant(ocp, runge_kutta4());
  std::vector<Eigen::Index> sizes;
  const FeedbackLaw ones = [&](double, const VectorRef&, VectorOut u) {
    EXPECT_EQ(u.size(), plant.inputs());
    if (sizes.empty() || sizes.back() != u.size()) sizes.push_back(u.size());
    u.setOnes();
  };
  const LoopLog log = simulate_closed_loop(ones, plant, {.duration = 1.0, .period = 0.1});
  ASSERT_TRUE(log.completed) << log.message;
  EXPECT_EQ(sizes, (std::vector<Eigen::Index>{1, 3, 2}));
  for (const Sample& sample : log.recording.samples)
    EXPECT_EQ(sample.input, VectorXd::Ones(sample.input.size())) << sample.time;
}

// At the present time of 1.7e9 s, neighbouring floating-point numbers are 2.4e-7 s apart.
TEST(PhasedPlant, AccumulatesLargeTimes) {
  constexpr double start = 1.7e9;
  const auto ramp = [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; };
  Phase<1, 0> a{"a", ramp, between(0.01, 9.0)}, b{"b", ramp, between(0.01, 9.0)};
  a.ends_when(
      "half", [](const auto&, const auto& x) { return x[0] - 0.5; }, Crossing::rising);
  OptimalControlProblem ocp("ramp");
  ocp.start_at({0.0}).then(a.guess_duration(0.5)).then(b.guess_duration(0.5)).start_time(start);
  PhasedPlant phased(ocp, runge_kutta4());
  IntervalProblem problem;
  problem.arguments = {1, 0, 0};
  problem.dynamics = make_function<1, 0, 0>(ramp);
  IntegratorPlant plain(problem, runge_kutta4(), VectorXd{{0.0}}, {}, start);
  for (LoopPlant* plant : {static_cast<LoopPlant*>(&phased), static_cast<LoopPlant*>(&plain)}) {
    const auto advance = [&](int pieces, double length) {
      for (int k = 0; k < pieces; ++k) ASSERT_TRUE(plant->advance(VectorXd(0), length));
    };
    advance(1000, 1e-3);
    EXPECT_NEAR(plant->state()[0], 1.0, 1e-12) << plant->name();
    EXPECT_EQ(plant->time(), start + 1.0);
    advance(1000, 1e-7);
    EXPECT_NEAR(plant->state()[0], 1.0001, 1e-12);  // a thousand roundings of 1
    EXPECT_EQ(plant->time(), start + 1.0001);
  }
  const std::vector<HybridEvent> events = phased.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_NEAR(events[0].time, start + 0.5, 2.5e-7);
}

TEST(PhasedPlant, RejectsAnInputOfWrongSize) {
  PhasedPlant plant(bounce(), runge_kutta4());
  for (const int size : {0, 2})
    EXPECT_THROW(plant.advance(VectorXd::Zero(size), 0.1), DefinitionError);
  EXPECT_EQ(plant.time(), 0.0);
  EXPECT_TRUE(plant.advance(VectorXd::Zero(1), 0.1));
}

TEST(PhasedPlant, RejectsEventsInsideAPhase) {
  Phase<2, 1> phase{"fall", Ball{}, exactly(1.0)};
  phase.on("impact", height, Crossing::falling, [](auto, auto x, auto) { return x; });
  OptimalControlProblem ocp("fall");
  EXPECT_THROW(PhasedPlant(ocp.start_at({1, 0}).then(phase), runge_kutta4()), DefinitionError);
  EXPECT_THROW(PhasedPlant(bounce(), nullptr), DefinitionError);
}

TEST(ShrinkingLoop, CatchesADisturbedBall) {
  const OptimalControlProblem problem = bounce();
  const auto controller = [&] {
    return ShrinkingHorizonController(
        problem,
        remaining_controllers(problem, {.intervals_per_phase = 6, .integrator = runge_kutta4()},
                              [](MultipleShooting rest) {
                                return RecedingHorizonController(
                                    std::move(rest), make_real_time_solver(make_native_solver()),
                                    {.period = 0.05});
                              }));
  };
  LoopOptions options{.duration = 2.0, .plan_every = 5};
  // One disturbance during the fall: three centimetres downward.
  options.disturbances.state = [](double t, const VectorRef&, VectorOut added) {
    if (std::abs(t - 0.2) < 1e-9) added[0] = -0.03;
  };
  ShrinkingHorizonController loop = controller();
  PhasedPlant plant(problem, runge_kutta4());
  const LoopLog log = simulate_closed_loop(loop, plant, options);
  ASSERT_TRUE(log.completed) << log.message;
  ASSERT_TRUE(plant.is_over());
  EXPECT_NEAR(plant.over_since(), 1.0, 1e-6);
  EXPECT_EQ(log.count(Provenance::fallback), 0);
  EXPECT_NEAR(plant.state()[0], 1.0, 1e-3);  // the plant holds the input, and the plan has ramps
  EXPECT_NEAR(plant.state()[1], 0.0, 1e-2);
  ASSERT_EQ(log.recording.events.size(), 2u);
  EXPECT_EQ(log.recording.events[0].mode_after, "rise");
  EXPECT_EQ(log.recording.events[1].name, "end");
  EXPECT_GE(log.plans.size(), 3u);
  PhasedPlant other(problem, runge_kutta4());
  ShrinkingHorizonController first = controller();
  const LoopLog undisturbed =
      simulate_closed_loop(first, other, {.duration = 2.0, .plan_every = 0});
  EXPECT_LT(undisturbed.ticks.size(), 22u);
  EXPECT_GT(plant.cost(), other.cost());  // the cost of the disturbance
}

// One metre from rest to rest in minimum time, 2 s: full throttle, then full brake.
OptimalControlProblem dash() {
  const auto clock = [](const auto& t, const auto&) { return t; };
  Phase<2, 1> throttle{"throttle", Cart{}, between(0.1, 5.0)},
      brake{"brake", Cart{}, between(0.1, 5.0)};
  for (auto* phase : {&throttle, &brake})
    phase->bound_input(0, between(-1.0, 1.0)).guess_duration(1.1);
  brake.reach("there", height, exactly(1.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("time", clock);
  OptimalControlProblem ocp("dash");
  ocp.start_at({0, 0}).then(throttle).then(brake);
  return ocp;
}

// With one input left, 2e-6 m at 4e-5 m/s take a tenth of a second more, if a solver finds that
// plan.
TEST(ShrinkingLoop, HasNoTickAtTheEnd) {
  const OptimalControlProblem problem = dash();
  ShrinkingHorizonController loop(
      problem,
      remaining_controllers(problem, {.intervals_per_phase = 1, .integrator = runge_kutta4()},
                            [](MultipleShooting rest) {
                              return RecedingHorizonController(
                                  std::move(rest), make_real_time_solver(make_native_solver()),
                                  {.period = 0.04});
                            }));
  PhasedPlant plant(problem, runge_kutta4());
  LoopOptions options{.duration = 6.0};
  options.disturbances.state = [](double t, const VectorRef&, VectorOut added) {
    if (std::abs(t - 1.96) < 1e-9) added[1] = -4e-5;  // the plan ends 40 us later
    if (std::abs(t - 2.0) < 1e-9) added[0] = -2e-6;
  };
  const LoopLog log = simulate_closed_loop(loop, plant, options);
  ASSERT_TRUE(log.completed) << log.message;
  ASSERT_TRUE(plant.is_over());
  EXPECT_EQ(log.ticks.size(), 50u);
  EXPECT_NEAR(plant.over_since(), 2.0, 1e-4);
  EXPECT_NEAR(plant.state()[0], 1.0, 1e-5);
}

}  // namespace
}  // namespace saltus
