// A plan on the grid of the next solve. On its own grid it is unchanged, and later it is the
// remaining part, also with several phases and free durations.
#include "saltus/transcription/plan_shift.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/optimum_check.hpp"
#include "saltus/transcription/shooting_program.hpp"
#include "tests/problems/two_gears.hpp"
#include "tests/support/event_problems.hpp"
#include "tests/support/point_mass.hpp"
#include "tests/support/walking_problem.hpp"

namespace saltus {
namespace {

using namespace testing_support;

std::unique_ptr<Solver> sqp() { return make_native_solver({.tolerance = 1e-9}); }

MultipleShooting gears() {
  OptimalControlProblem car = two_gears::problem();
  return {car, {.intervals_per_phase = 20, .integrator = runge_kutta4()}};
}

// A plan, and the same plan shifted by `elapsed`.
struct Moved {
  Solution plan;
  NlpPoint guess;
};
Moved move_on(MultipleShooting& shooting, double elapsed) {
  Moved m{solve(shooting, *sqp()), {}};
  EXPECT_TRUE(m.plan.ok()) << m.plan.message;
  PlanShift shift(shooting.program());
  shift.remember(shooting.program(), m.plan.point.w);
  const double start = m.plan.trajectory.start_time() + elapsed;
  shooting.start_at(start, m.plan.trajectory.state(start));
  shift.apply(shooting.program(), m.plan.point, m.guess);
  return m;
}

void expect_near(const VectorXd& a, const VectorXd& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (int i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], tolerance) << i;
}

TEST(PlanShift, IsExactOnTheSameGrid) {
  MultipleShooting car = gears();
  const Moved m = move_on(car, 0.0);
  // Rounding of the durations, which are computed from instants.
  constexpr double rounding = 1e-11;
  expect_near(m.guess.w, m.plan.point.w, rounding);
  expect_near(m.guess.lambda, m.plan.point.lambda, rounding);
  // Multipliers of sides that do not exist are not copied.
  expect_near(m.guess.z, m.plan.point.z, 1e-8);

  MultipleShooting walk = walking_problem(walking_schedule());
  const Moved n = move_on(walk, 0.0);
  EXPECT_LT(kkt_residual(walk.nlp(), n.guess).scaled(), 1e-8);
}

// Slacks and their multipliers are shifted too.
TEST(PlanShift, SlacksMoveInTime) {
  for (const Penalty& penalty :
       {soft("slow", 0.4), soft("slow", 2.0, Penalty::L2), huber("slow", 0.4, 0.1)}) {
    Phase<2, 1> phase{"drive", Cart{}, exactly(1.0)};
    phase.minimise("effort", effort)
        .keep("slow", speed, between(-0.1, 0.2), {}, penalty)
        .reach("there", position, exactly(0.25));
    OptimalControlProblem ocp("cart");
    ocp.start_at(Vec<double, 2>(0.0, 0.0)).then(phase);
    MultipleShooting cart(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
    const Moved m = move_on(cart, 0.1);  // by one interval
    double change = 0.0;
    for (const auto& to : cart.program().row_instances())
      for (const auto& from : cart.program().row_instances())
        for (const auto slacks :
             {&shooting::RowInstance::slack_below, &shooting::RowInstance::slack_above,
              &shooting::RowInstance::slack_free}) {
          const int node = to.block.point.node;
          if (to.slack_below.empty() || node < 1 || node >= 9 ||
              from.block.point.node != node + 1 || from.term != to.term)
            continue;
          const int a = (to.*slacks)[0], b = (from.*slacks)[0];
          if (a < 0) continue;
          EXPECT_NEAR(m.guess.w[a], m.plan.point.w[b], 1e-9) << node;
          EXPECT_NEAR(m.guess.z[a], m.plan.point.z[b], 1e-9) << node;
          change = std::max(change, std::abs(m.guess.z[a] - m.plan.point.z[a]));
        }
    EXPECT_GT(change, 1e-3);  // the shift distinguishes the two
  }
}

TEST(PlanShift, HorizonIsUnchangedUntilAnEventEnters) {
  MultipleShooting walk = walking_problem(walking_schedule());
  PlanShift shift(walk.program());
  const VectorXd w = walk.initial_guess().w;
  const double start = walk.data().start_time;
  EXPECT_FALSE(shift.is_same_horizon(walk.program(), w));  // no plan was stored
  shift.remember(walk.program(), w);
  EXPECT_TRUE(shift.is_same_horizon(walk.program(), w));
  walk.start_time(start + 0.03);  // the events are nearer by that time
  EXPECT_FALSE(shift.is_same_horizon(walk.program(), w));

  Phase<2, 1> phase{"drive", Cart{}, exactly(1.0)};
  phase.minimise("effort", effort).bound_input(0, between(-1.0, 1.0));
  OptimalControlProblem ocp("cart");
  ocp.start_at(Vec<double, 2>(0.0, 0.0)).then(phase);
  MultipleShooting cart(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  PlanShift moving(cart.program());
  const VectorXd plan = cart.initial_guess().w;
  moving.remember(cart.program(), plan);
  cart.start_at(0.37, Vec<double, 2>(0.1, 0.2));
  EXPECT_TRUE(moving.is_same_horizon(cart.program(), plan));
}

TEST(PlanShift, FreePhasesKeepTheirEndAndTheRestIsNearOptimal) {
  constexpr double elapsed = 0.3;  // s
  MultipleShooting car = gears();
  const NlpPoint cold = car.initial_guess();
  const Moved m = move_on(car, elapsed);
  const auto duration = [&](int j) {
    return m.guess.w[car.layout().duration(j)] * car.problem().phases()[j].nominal_duration;
  };
  EXPECT_NEAR(duration(0), m.plan.durations[0] - elapsed, 1e-9);
  EXPECT_NEAR(duration(1), m.plan.durations[1], 1e-9);

  const Solution warm = solve(car, *sqp(), m.guess);
  const Solution anew = solve(car, *sqp());
  ASSERT_TRUE(warm.ok() && anew.ok());
  EXPECT_NEAR(warm.cost, anew.cost, 1e-7 * anew.cost);
  RecordProperty("warm_iterations", warm.iterations);
  EXPECT_LT(warm.iterations, anew.iterations);
  // The costates of the rest of a plan equal those of the new plan, except for the change of the
  // grid, which divides the first phase into other intervals.
  const double scale = warm.point.lambda.cwiseAbs().maxCoeff();
  for (const shooting::IntervalInstance& instance : car.program().interval_instances())
    for (int i = 0; i < 2; ++i)
      EXPECT_NEAR(m.guess.lambda[instance.first_row + i], warm.point.lambda[instance.first_row + i],
                  0.02 * scale)
          << instance.phase << " " << instance.interval;
}

// The rest of a free duration has intervals of a different length. Multipliers of constraints over
// an interval scale with its length.
TEST(PlanShift, InputMultipliersScaleWithIntervals) {
  Phase<2, 1> phase{"drive", Cart{}, between(0.2, 5.0)};
  phase.bound_input(0, between(-1.0, 3.0))
      .keep(
          "push", [](auto, auto, auto u) { return u[0]; }, at_most(1.0))
      .reach("there", position, exactly(1.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise("effort", [](auto, auto, auto u) { return 0.1 * u[0] * u[0]; })
      .minimise_at_end("time", [](auto t, auto) { return t; });
  OptimalControlProblem ocp("cart");
  ocp.start_at(Vec<double, 2>(0.0, 0.0)).then(phase);
  constexpr int intervals = 20;
  MultipleShooting cart(ocp, {.intervals_per_phase = intervals, .integrator = runge_kutta4()});
  constexpr double elapsed = 0.5;  // s; the phase takes 2 s
  const Moved m = move_on(cart, elapsed);
  const Layout& layout = cart.layout();
  const double old_length = m.plan.durations[0] / intervals,
               length = (m.plan.durations[0] - elapsed) / intervals;
  ASSERT_LT(length, 0.8 * old_length);
  const auto old_interval = [&](int k) {
    return static_cast<int>((elapsed + (k + 0.5) * length) / old_length);
  };
  double at_bounds = 0.0, at_rows = 0.0;
  for (int k = 0; k < intervals; ++k) {
    const double z = m.guess.z[layout.input(0, k)],
                 before = m.plan.point.z[layout.input(0, old_interval(k))];
    EXPECT_NEAR(z / length, before / old_length, 1e-9) << k;
    at_bounds = std::max(at_bounds, std::abs(z));
  }
  for (const auto& to : cart.program().row_instances())
    for (const auto& from : cart.program().row_instances()) {
      const int k = to.block.point.interval;
      if (k < 0 || from.term != to.term || from.block.point.interval != old_interval(k)) continue;
      const double multiplier = m.guess.lambda[to.first_row];
      EXPECT_NEAR(multiplier / length, m.plan.point.lambda[from.first_row] / old_length, 1e-9) << k;
      at_rows = std::max(at_rows, std::abs(multiplier));
    }
  // Some of the multipliers that are compared are not small.
  EXPECT_GT(at_bounds, 1e-3);
  EXPECT_GT(at_rows, 1e-3);
}

TEST(PlanShift, MultipliersMoveInTime) {
  Phase<2, 1> phase{"drive", Cart{}, exactly(1.0)};
  phase.minimise("effort", effort)
      .keep("slow", speed, at_most(0.3))
      .reach("there", position, exactly(0.25));
  OptimalControlProblem ocp("cart");
  ocp.start_at(Vec<double, 2>(0.0, 0.0)).then(phase);
  MultipleShooting cart(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  const Moved m = move_on(cart, 0.1);  // by one interval
  const auto& intervals = cart.program().interval_instances();
  double change = 0.0;
  for (int k = 0; k < 9; ++k)
    for (int i = 0; i < 2; ++i) {
      const double costate = m.guess.lambda[intervals[k].first_row + i];
      EXPECT_NEAR(costate, m.plan.point.lambda[intervals[k + 1].first_row + i], 1e-9) << k;
      change =
          std::max(change, std::abs(costate - m.plan.point.lambda[intervals[k].first_row + i]));
    }
  EXPECT_GT(change, 0.1);  // the shift distinguishes the two
  int pressed = 0;
  for (const auto& to : cart.program().row_instances())
    for (const auto& from : cart.program().row_instances()) {
      const int node = to.block.point.node;
      if (node >= 9 || from.block.point.node != node + 1) continue;
      EXPECT_NEAR(m.guess.lambda[to.first_row], m.plan.point.lambda[from.first_row], 1e-9) << node;
      pressed += std::abs(m.guess.lambda[to.first_row]) > 0.01;
    }
  EXPECT_GE(pressed, 2);  // nodes at the maximum speed
}

TEST(PlanShift, DoesNotContinueAcrossAJump) {
  Phase<1, 1> down{"down", Velocity{}, exactly(0.5)}, up{"up", Velocity{}, exactly(0.5)};
  for (auto* phase : {&down, &up})
    phase->track("effort", input, Vec<double, 1>{1.0}).track("state", state, Vec<double, 1>{1.0});
  OptimalControlProblem ocp("bounce");
  ocp.start_at({1}).then(down).then(
      up, jump<1>("flip", [](const auto&, const auto& x) { return -0.5 * x[0]; }));
  MultipleShooting shooting(ocp, ten);
  const Moved m = move_on(shooting, 0.1);  // by two intervals
  const Layout& layout = shooting.layout();
  const double end = m.plan.point.w[layout.state(0, 10)];
  EXPECT_GT(end, 0.1);
  for (const int node : {8, 9, 10}) EXPECT_NEAR(m.guess.w[layout.state(0, node)], end, 1e-9);
  EXPECT_NEAR(m.guess.w[layout.state(1, 0)], m.plan.point.w[layout.state(1, 2)], 1e-9);
}

TEST(PlanShift, EndedFreePhaseHasMinimumDuration) {
  MultipleShooting car = gears();
  const Solution plan = solve(car, *sqp());
  const Moved m = move_on(car, plan.durations[0] - 0.2);
  EXPECT_NEAR(m.guess.w[car.layout().duration(0)], 0.5, 1e-12);  // the shortest allowed
  EXPECT_TRUE(m.guess.w.allFinite() && m.guess.lambda.allFinite() && m.guess.z.allFinite());
}

TEST(PlanShift, FixedPhasesMoveWithTheHorizon) {
  constexpr double elapsed = 0.1;  // s, one interval: all nodes keep their times
  MultipleShooting walk = walking_problem(walking_schedule());
  const Moved m = move_on(walk, elapsed);
  const Trajectory& old = m.plan.trajectory;
  const Trajectory moved = walk.trajectory(m.guess.w);
  for (const Trajectory::Piece& piece : moved.pieces()) {
    if (piece.end() > old.end_time() + 1e-9) continue;
    expect_near(piece.state, old.state(piece.start), 1e-9);
    expect_near(piece.end_state, old.state_before(piece.end()), 1e-9);
    expect_near(piece.coefficients, old.input(piece.start + 0.5 * piece.length), 1e-9);
  }
}

}  // namespace
}  // namespace saltus
