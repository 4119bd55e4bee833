// Phases that end when a guard crosses zero. The solve finds the time and reports improper
// crossings.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using namespace testing_support;

Phase<2, 1> flight(const std::string& name) {
  Phase<2, 1> phase{name, Ball{}, between(0.05, 2.0)};
  phase.inputs(InputParametrisation::piecewise_linear_continuous)
      .minimise("effort", effort)
      .guess_duration(0.5);
  return phase;
}
Jump bounce(double restitution) {
  return jump<2>("bounce", [restitution](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{x[0], -restitution * x[1]};
  });
}
Solution solve_by_ipopt(const OptimalControlProblem& ocp) {
  MultipleShooting shooting(ocp, {.intervals_per_phase = 8, .integrator = runge_kutta4()});
  return solve(shooting, *make_ipopt({.tolerance = 1e-11}));
}

// From (1, 0) to (1, 0) in one second with one bounce, restitution 0.8, least effort. A flight from
// (q0, v0) to (q1, v1) in T costs 2 a^2/T - 6 a d/T^2 + 6 d^2/T^3 with a = v1 - v0 + g T and
// d = q1 - q0 - v0 T + g T^2/2; the minimum over the time and speed of the impact is below. Ramps
// represent the optimal input exactly.
TEST(EndGuard, FindsTheTimeOfAnImpact) {
  OptimalControlProblem ocp("bounce");
  Phase<2, 1> fall = flight("fall"), rise = flight("rise");
  fall.ends_when("impact", height, Crossing::falling);
  rise.reach("height", height, exactly(1.0)).reach("speed", speed, exactly(0.0));
  ocp.start_at({1, 0}).then(fall).then(rise, bounce(0.8)).total_time(exactly(1.0));
  ocp.costs(CostRule::integrated);
  const Solution s = solve_by_ipopt(ocp);
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.cost, 2.570651595764464, 1e-9);
  EXPECT_NEAR(s.durations[0], 0.470504556810741, 1e-9);
  EXPECT_NEAR(s.trajectory.state_before(s.durations[0])[1], -4.640109107887904, 1e-8);
  ASSERT_EQ(s.crossings.size(), 1u);
  const Solution::GuardCrossing& c = s.crossings.front();
  EXPECT_EQ(c.phase, "fall");
  EXPECT_EQ(c.event, "impact");
  EXPECT_NEAR(c.time, s.durations[0], 1e-12);
  EXPECT_NEAR(c.rate, -4.640109107887904, 1e-8);  // the rate of the height is the speed
  EXPECT_TRUE(c.is_as_declared());
  EXPECT_EQ(s.message, describe(SolveStatus::optimal));
}

// The same event with the opposite direction is an optimum of the program, but not a solution of
// the problem.
TEST(EndGuard, WrongCrossingDirectionIsNoSolution) {
  OptimalControlProblem ocp("wrong way");
  Phase<2, 1> fall = flight("fall");
  fall.bound_input(0, exactly(0.0)).ends_when("impact", height, Crossing::rising);
  const Solution s = solve_by_ipopt(ocp.start_at({1, 0}).then(fall));
  ASSERT_EQ(s.status, SolveStatus::wrong_crossing) << s.message;
  EXPECT_NEAR(s.durations[0], std::sqrt(2.0 / gravity), 1e-9);
  EXPECT_FALSE(s.crossings.front().is_as_declared());
  for (const char* part : {"'impact'", "'fall'", "0.45152", "wrong direction", "rising"})
    EXPECT_NE(s.message.find(part), std::string::npos) << part << " is not in: " << s.message;
}

// Thrown upward with a speed that just reaches the ceiling.
TEST(EndGuard, ReportsGrazing) {
  OptimalControlProblem ocp("grazing");
  Phase<2, 1> climb = flight("climb");
  climb.bound_input(0, exactly(0.0))
      .ends_when(
          "ceiling", [](const auto&, const auto& x) { return x[0] - 1.0; }, Crossing::rising);
  ocp.start_within({exactly(0.0), unbounded()}, Vec<double, 2>{0.0, 4.0});
  climb.minimise_at_end("energy", [](const auto&, const auto& x) { return x[1] * x[1]; });
  const Solution s = solve_by_ipopt(ocp.then(climb));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_TRUE(s.crossings.front().grazes) << s.crossings.front().rate;
  EXPECT_NE(s.message.find("event 'ceiling'"), std::string::npos) << s.message;
  EXPECT_NE(s.message.find("grazes"), std::string::npos) << s.message;
}

// A later crossing of the same surface also has guard = 0. The sine decreases through zero at pi
// and at 3 pi.
TEST(EndGuard, PreviouslyCrossedGuardIsNoSolution) {
  const auto still = [](const auto&, const auto& x) { return std::decay_t<decltype(x)>(0.0 * x); };
  Phase<1, 0> wait{"wait", still, between(0.1, 12.0)};
  wait.ends_when(
          "noon", [](const auto& t, const auto& x) { return sin(t) + 0.0 * x[0]; },
          Crossing::falling)
      .guess_duration(9.0);
  OptimalControlProblem ocp("later");
  const Solution s = solve_by_ipopt(ocp.start_at({0}).then(wait));
  ASSERT_EQ(s.status, SolveStatus::wrong_crossing) << s.message;
  EXPECT_NEAR(s.durations[0], 3.0 * M_PI, 1e-8);  // the crossing near the guess, not the first
  EXPECT_GT(s.crossings.front().early_amount, 0.1);
  EXPECT_NE(s.message.find("not the first"), std::string::npos) << s.message;
}

// x' = rate, for every x.
struct Drift {
  double rate;
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x) const {
    return Vec<S, 1>(rate + 0.0 * x[0]);
  }
};
auto level(double at) {
  return [at](const auto&, const auto& x) { return x[0] - at; };
}

// A room at 20 degrees is heated by one degree per second to 22, and then cooled to 18.
TEST(EndGuard, PhaseWithModesUsesTheActiveMode) {
  const auto heat = [](double rate) {
    return [rate](const auto&, const auto& x) {
      return std::decay_t<decltype(x)>{rate + 0.0 * x[0], 0.0 * x[1]};
    };
  };
  Automaton<2> thermostat;
  thermostat.mode("heat", heat(1.0)).mode("cool", heat(-1.0)).store_mode_in(1);
  thermostat.event("hot", "heat", "cool", level(22.0), Crossing::rising)
      .event("cold", "cool", "heat", level(16.0), Crossing::falling);
  Phase<2, 0> room{"room", thermostat, between(3.0, 7.0)};
  room.ends_when("is 18", level(18.0), Crossing::falling)
      .guess_duration(5.5)
      .guess_state(Guess::simulate());
  OptimalControlProblem ocp("thermostat");
  const Solution s = solve_by_ipopt(ocp.start_at({20.0, 0.0}).then(room));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.durations[0], 6.0, 1e-8);
  EXPECT_NEAR(s.crossings.front().rate, -1.0, 1e-8);
  EXPECT_TRUE(s.crossings.front().is_as_declared()) << s.message;
}

// Up for one second, then down. The field at the end differs from the first one.
TEST(EndGuard, SwitchedPhaseUsesTheActiveField) {
  const auto clock = [](const auto& t, const auto&) { return t - 1.0; };
  Phase<1, 0> there{"there", Drift{1.0}, between(1.2, 3.0)};
  there.switch_at("turn", clock, Drift{-1.0})
      .ends_when("back", level(0.5), Crossing::falling)
      .guess_duration(1.7)
      .guess_state(Guess::simulate());
  OptimalControlProblem ocp("there and back");
  const Solution s = solve_by_ipopt(ocp.start_at({0.0}).then(there));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.durations[0], 1.5, 1e-8);
  EXPECT_NEAR(s.crossings.front().rate, -1.0, 1e-8);
  EXPECT_TRUE(s.crossings.front().is_as_declared()) << s.message;
}

// The first mode is at rest, and the second mode moves to the guard.
TEST(EndGuard, DependsOnAnyMode) {
  const auto clock = [](const auto& t, const auto& x) { return t - 1.0 + 0.0 * x[0]; };
  Automaton<1> late;
  late.mode("rest", Drift{0.0}).mode("move", Drift{1.0});
  late.event("go", "rest", "move", clock, Crossing::rising);
  Phase<1, 0> phase{"late", late, between(1.5, 9.0)};
  phase.ends_when("there", level(3.0), Crossing::rising).guess_duration(3.5);
  OptimalControlProblem ocp("late");
  EXPECT_NO_THROW(ocp.start_at({0.0}).then(phase).check());
}

// Formulas depend on absolute time. A field that changes sign at 10 s does so within the second
// phase.
TEST(EndGuard, IsTestedAtTheTimesOfItsPhase) {
  const auto turning = [](const auto& t, const auto& x) {
    return std::decay_t<decltype(x)>(select(t - 10.0, 0.0 * t - 1.0, 0.0 * t + 1.0));
  };
  const auto falls = [&](Bounds first) {
    Phase<1, 0> a{"first", Drift{1.0}, first}, b{"second", turning, between(0.1, 5.0)};
    b.ends_when("falls", level(10.0), Crossing::falling);
    OptimalControlProblem ocp("turning");
    ocp.start_at({0.0}).then(a.guess_duration(12.0)).then(b).check();
  };
  EXPECT_NO_THROW(falls(exactly(12.0)));
  EXPECT_NO_THROW(falls(at_least(1.0)));
  EXPECT_THROW(falls(exactly(2.0)), DefinitionError);  // it increases throughout
}

// Present values of data may change later.
TEST(EndGuard, MayDependOnData) {
  const auto blown = [](const auto&, const auto&, const auto&, const auto& p) { return p[0]; };
  for (const double wind : {0.0, -1.0}) {
    Phase<1, 0, 1> sail{"sail", blown, between(0.1, 10.0)};
    sail.data("wind", Vec<double, 1>(wind)).ends_when("there", level(1.0), Crossing::rising);
    OptimalControlProblem ocp("sail");
    EXPECT_NO_THROW(ocp.start_at({0.0}).then(sail).check()) << wind;
  }
}

// Two ways of moving, of which only the fast one is worth its time. The slow phase has zero length.
TEST(FreeDurations, ReportsAVanishedPhase) {
  const auto at_speed = [](double rate) {
    return
        [rate](const auto&, const auto& x) { return std::decay_t<decltype(x)>(rate + 0.0 * x[0]); };
  };
  Phase<1, 0> slow{"slow", at_speed(1.0), between(0.0, 5.0)};
  Phase<1, 0> fast{"fast", at_speed(2.0), between(0.0, 5.0)};
  const auto time = [](const auto& t, const auto&) { return t; };
  fast.minimise_at_end("time", time)
      .reach(
          "goal", [](const auto&, const auto& x) { return x[0]; }, exactly(3.0));
  OptimalControlProblem ocp("two speeds");
  const Solution s = solve_by_ipopt(ocp.start_at({0}).then(slow).then(fast));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.durations[0], 0.0, 1e-6);
  EXPECT_NE(s.message.find("because their duration is zero: phase 'slow'"), std::string::npos)
      << s.message;
  EXPECT_EQ(s.message.find("zero: phase 'slow', phase 'fast'"), std::string::npos) << s.message;
}

// A swing foot at 0.02 m moves down at 0.8 m/s. It is below the ground for 0.1 s before it lands at
// the end. The earlier touch-down is detected even if no node lies within that time.
TEST(EndGuard, DetectsAnEarlierCrossingBetweenNodes) {
  for (const int n : {4, 5, 30}) {
    Phase<2, 0> swing{"swing",
                      [](const auto& t, const auto& x) {
                        return std::decay_t<decltype(x)>{x[1], 10.0 - 24.0 * t};
                      },
                      between(0.1, 3.0)};
    swing
        .ends_when(
            "touch-down", [](const auto&, const auto& x) { return x[0]; }, Crossing::falling)
        .guess_duration(1.0);
    OptimalControlProblem ocp("swing");
    ocp.start_at({0.02, -0.8}).then(swing);
    MultipleShooting shooting(ocp, {.intervals_per_phase = n, .integrator = runge_kutta4()});
    const Solution s = solve(shooting, *make_ipopt());
    EXPECT_EQ(s.status, SolveStatus::wrong_crossing) << n << " intervals: " << s.message;
    EXPECT_LT(s.crossings.front().early_time, 0.2);
  }
}

}  // namespace
}  // namespace saltus
