// Control while the schedule is edited. The plan of every tick, warm-started and updated in place,
// equals that of a newly built controller. The plan adapts to early and late events.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "saltus/core/error.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/point_mass.hpp"
#include "tests/support/walking_problem.hpp"

namespace saltus {
namespace {

using namespace testing_support;

constexpr double step = 0.1;  // s

enum class Back { riccati, sparse };
RecedingHorizonController controller_for(MultipleShooting shooting, Back which) {
  auto solver = make_real_time_iteration(
      shooting.nlp(), {.qp = which == Back::riccati ? riccati_qp() : sparse_qp()});
  return {std::move(shooting), std::move(solver), {.period = step}};
}

// Results of a tick.
struct Record {
  Provenance provenance = Provenance::fallback;
  double objective = 0.0;
  int iterations = 0;
  Vec<double, 2> state, input;  // measured; first of the tick
};

Record record(const ControlTick& tick, const Vec<double, 2>& state) {
  Record r{tick.provenance, tick.objective, tick.iterations, state, {0.0, 0.0}};
  for (int i = 0; i < tick.input[0].size; ++i) r.input[i] = tick.input[0].input()[i];
  return r;
}

// x = (position, speed) of unit mass under a force.
void push(Vec<double, 2>& x, double force, double seconds) {
  x[0] += seconds * (x[1] + 0.5 * seconds * force);
  x[1] += seconds * force;
}

// Two solves to a residual of 1e-8 each. Costs are of order 1.
constexpr double same_cost = 1e-6;

class LiveScheduleLoop : public ::testing::TestWithParam<Back> {};

TEST_P(LiveScheduleLoop, EditedPlanEqualsRebuiltPlanWithoutAllocation) {
  constexpr unsigned seed = 21;
  constexpr int ticks = 60;
  std::mt19937 random(seed);
  std::vector<Schedule> schedules{walking_schedule()};
  for (int k = 1; k < ticks; ++k) {
    Schedule next = schedules.back();
    next.hold("goal", step * k, 0.2);
    next.forget_until(step * k - 0.25);
    for (int edits = 0; edits < 2; ++edits) edit_at_random(next, step * k, random);
    schedules.push_back(next);
  }

  MultipleShooting shooting = walking_problem(walking_schedule());
  RecedingHorizonController controller = controller_for(std::move(shooting), GetParam());
  Schedule live = walking_schedule();
  std::vector<Record> records(ticks);
  Vec<double, 2> x{0.8, 0.4};
  const VectorXd none = VectorXd::Zero(2);
  const testing::AllocationCount count;
  for (int k = 0; k < ticks; ++k) {
    live.adopt(schedules[k]);
    live.hold("goal", step * k, step);
    controller.set_schedule(live);
    controller.set_previous_input(none);
    const ControlTick& tick = controller.tick(step * k, x);
    records[k] = record(tick, x);
    for (const HeldInput::Piece& piece : tick.input)
      push(x, piece.values[0] + piece.values[1], piece.length);
  }
  EXPECT_EQ(count.made(), 0);
  EXPECT_EQ(controller.statistics().count(Provenance::optimal), ticks);

  int warm = 0, cold = 0;
  for (int k = 0; k < ticks; ++k) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << " tick " << k);
    schedules[k].hold("goal", step * k, step);
    RecedingHorizonController anew = controller_for(walking_problem(schedules[k]), GetParam());
    anew.set_previous_input(none);
    const Record r = record(anew.tick(step * k, records[k].state), records[k].state);
    ASSERT_EQ(r.provenance, Provenance::optimal);
    ASSERT_EQ(records[k].provenance, Provenance::optimal);
    EXPECT_NEAR(records[k].objective, r.objective, same_cost * (1.0 + std::abs(r.objective)));
    // The cost is strictly convex in the inputs, with a curvature of about 0.02.
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(records[k].input[i], r.input[i], 1e-3);
    warm += records[k].iterations;
    cold += r.iterations;
  }
  RecordProperty("warm_iterations", warm);
  RecordProperty("cold_iterations", cold);
  EXPECT_LT(warm, cold);
}

// --- a gate that opens at an unknown time --------------------------------------------------------

Schedule gate_schedule() {
  return Schedule({"closed", "open", "closed"}, {{"opens", 0.55}, {"closes", 1.05}}).reserve(3);
}

// Up to 1 N while the gate is closed, up to 3 N while it is open.
MultipleShooting gate(const Schedule& schedule) {
  Phase<2, 1> phase{"gate", Cart{}, exactly(1.0)};
  phase.bound_input(0, between(-1.0, 1.0), during("closed"))
      .bound_input(0, between(-3.0, 3.0), during("open"))
      .track(
          "rest", [](const auto&, const auto& x) { return x; }, Vec<double, 2>{10.0, 1.0})
      .track(
          "force", [](const auto&, const auto&, const auto& u) { return u; }, Vec<double, 1>{0.05});
  OptimalControlProblem ocp("gate");
  ocp.schedule(schedule).start_at({1.0, 0.0}).then(phase);
  return {std::move(ocp), {.intervals_per_phase = 10, .integrator = zero_order_hold()}};
}

// The gate opens at time `opens` and closes half a second later.
void expect_loop_follows(Back which, double opens) {
  RecedingHorizonController controller = controller_for(gate(gate_schedule()), which);
  Schedule plan = gate_schedule();
  Vec<double, 2> x{2.0, 0.0};
  int ticks = 0, warm = 0, cold = 0;
  bool has_opened = false, has_closed = false;
  double largest = 0.0;
  for (; ticks < 20; ++ticks) {
    SCOPED_TRACE(ticks);
    const double now = step * ticks;
    const auto follow = [&](const char* event, double truth, bool& has_happened) {
      if (has_happened) return;
      has_happened = truth <= now;
      if (has_happened)
        plan.confirm(event, now);
      else
        plan.hold(event, now, step);
    };
    follow("opens", opens, has_opened);
    if (has_opened) follow("closes", opens + 0.5, has_closed);
    controller.set_schedule(plan);
    const ControlTick& tick = controller.tick(now, x);
    ASSERT_EQ(tick.provenance, Provenance::optimal);
    warm += ticks > 0 ? tick.iterations : 0;
    RecedingHorizonController anew = controller_for(gate(plan), which);
    const ControlTick& fresh = anew.tick(now, x);
    ASSERT_EQ(fresh.provenance, Provenance::optimal);
    EXPECT_NEAR(tick.objective, fresh.objective, same_cost * (1.0 + fresh.objective));
    cold += ticks > 0 ? fresh.iterations : 0;
    for (const HeldInput::Piece& piece : tick.input) {
      // The controller never requests more than the known state of the gate allows.
      EXPECT_LE(std::abs(piece.input()[0]), has_opened && !has_closed ? 3.0 : 1.0);
      largest = std::max(largest, std::abs(piece.input()[0]));
      push(x, piece.input()[0], piece.length);
    }
  }
  EXPECT_GT(largest, 1.0);  // the plan used the open gate
  EXPECT_NEAR(plan.time_of("opens"), opens, step);
  EXPECT_GE(plan.time_of("opens"), opens);
  EXPECT_NEAR(plan.time_of("closes"), opens + 0.5, step);
  EXPECT_EQ(controller.statistics().count(Provenance::optimal), ticks);
  EXPECT_EQ(controller.statistics().all().count(), ticks);
  EXPECT_LE(warm, cold);
  EXPECT_LT(std::abs(x[0]), 0.5);
}

TEST_P(LiveScheduleLoop, HandlesAnEarlyEvent) { expect_loop_follows(GetParam(), 0.28); }
TEST_P(LiveScheduleLoop, HandlesAnEventAtItsPlannedTime) { expect_loop_follows(GetParam(), 0.55); }
TEST_P(LiveScheduleLoop, HandlesALateEvent) { expect_loop_follows(GetParam(), 0.93); }

TEST_P(LiveScheduleLoop, RejectedEditDoesNotAffectTheNextTick) {
  RecedingHorizonController controller = controller_for(gate(gate_schedule()), GetParam());
  RecedingHorizonController untouched = controller_for(gate(gate_schedule()), GetParam());
  const Vec<double, 2> x{1.0, 0.0};
  controller.tick(0.0, x);
  untouched.tick(0.0, x);
  Schedule strange = gate_schedule().declare({"ajar"});
  strange.insert("ajar", "moves", 0.3);
  EXPECT_THROW(controller.set_schedule(strange), DefinitionError);
  const ControlTick& tick = controller.tick(step, x);
  const ControlTick& expected = untouched.tick(step, x);
  EXPECT_EQ(tick.provenance, Provenance::optimal);
  EXPECT_EQ(tick.objective, expected.objective);
  EXPECT_EQ(tick.iterations, expected.iterations);
}

// A measurement is missing while the schedule changes. The old plan continues in the new modes.
TEST_P(LiveScheduleLoop, ContinuesThePlanInNewModesWithoutMeasurement) {
  RecedingHorizonController controller = controller_for(gate(gate_schedule()), GetParam());
  const Vec<double, 2> x{5.0, 0.0};
  Schedule plan = gate_schedule();
  plan.confirm("opens", 0.0);
  controller.set_schedule(plan);
  ASSERT_EQ(controller.tick(0.0, x).provenance, Provenance::optimal);
  plan.confirm("closes", 0.15);  // in the middle of the next tick
  controller.set_schedule(plan);
  const ControlTick& tick = controller.tick(step, VectorXd::Constant(2, std::nan("")));
  EXPECT_EQ(tick.provenance, Provenance::shifted);
  ASSERT_EQ(tick.input.size(), 2u);
  EXPECT_NEAR(tick.input[0].length, 0.05, 1e-9);
  EXPECT_NEAR(tick.input[0].input()[0], -3.0, 1e-6);
  EXPECT_NEAR(tick.input[1].input()[0], -1.0, 1e-6);
  EXPECT_EQ(controller.statistics().count(Provenance::shifted), 1);
}

INSTANTIATE_TEST_SUITE_P(Solvers, LiveScheduleLoop, ::testing::Values(Back::riccati, Back::sparse),
                         [](const auto& instance) {
                           return instance.param == Back::riccati ? "Riccati" : "Sparse";
                         });

}  // namespace
}  // namespace saltus
