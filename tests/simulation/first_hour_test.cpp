// Features for new users: bounds per row, costs at starts and over links, one set of options, plans
// as files, and a user-defined plant under a controller with a fixed end.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/file_content.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/simulation/closed_loop.hpp"
#include "saltus/simulation/loop_log.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/native_solver.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using namespace testing_support;

constexpr auto state = [](const auto&, const auto& x) { return x; };
constexpr auto input = [](const auto&, const auto&, const auto& u) { return u; };

struct Rate {  // x' = u; one state is a scalar
  template <class S>
  S operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return u[0];
  }
};

struct OneRow {  // the same in braces, as for several states
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return {u[0]};
  }
};
struct OneSquare {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return {u[0] * u[0]};
  }
};

Phase<2, 1> from_rest_to_rest() {
  Phase<2, 1> phase{"dash", Cart{}, exactly(1.0)};
  phase.begin_with("from", state, {exactly(0.0), at_most(0.0)})
      .reach("there", state, exactly({1.0, 0.0}))
      .minimise("effort", effort);
  return phase;
}

OptimalControlProblem dash() {
  OptimalControlProblem problem("dash");
  problem.start_within({unbounded(), at_least(0.0)}, VectorXd::Zero(2)).then(from_rest_to_rest());
  return problem;
}

std::string refusal(const auto& act) { return error_of<DefinitionError>(act); }

TEST(UserTasks, OneRowInBracesIsAResult) {
  Phase<1, 1> phase{"dash", OneRow{}, exactly(1.0)};
  phase.track("input", OneRow{}, VectorXd::Ones(1))
      .minimise("effort", OneSquare{})
      .keep("limit", OneRow{}, between(-3.0, 3.0))
      .reach("there", state, exactly(1.0));
  OptimalControlProblem problem("one row");
  problem.start_at({0.0}).then(phase);
  const Solution plan = solve(problem);
  ASSERT_TRUE(plan.ok()) << plan.message;
  EXPECT_NEAR(plan.cost, 1.5, 1e-7);
}

TEST(UserTasks, BoundsApplyPerRow) {
  const Solution plan = solve(dash());
  ASSERT_TRUE(plan.ok()) << plan.message;
  // 1/2 int u^2 is 6 for u = 6 - 12 t, and 6 n^2 / (n^2 - 1) with n constant pieces.
  EXPECT_NEAR(plan.cost, 6.0 * 900.0 / 899.0, 1e-6);
  EXPECT_EQ(exactly(VectorXd{{1.0, 0.0}}), exactly({1.0, 0.0}));
  const std::string wrong = refusal([] {
    Phase<2, 1> phase = from_rest_to_rest();
    phase.begin_with("rows", state, exactly({1.0, 2.0, 3.0}));
    OptimalControlProblem problem("rows");
    solve(problem.start_at({0, 0}).then(phase));
  });
  EXPECT_EQ(wrong, "phase 'dash', term 'rows': the formula has 2 rows, but 3 bounds were given");
}

TEST(UserTasks, CostsApplyAtTheStart) {
  for (const bool squares : {false, true}) {
    Phase<1, 1> phase{"move", Rate{}, exactly(1.0)};
    phase.track("effort", input, VectorXd::Ones(1)).reach("there", state, exactly({2.0}));
    if (squares)
      phase.track_at_start("start", state, VectorXd::Ones(1));
    else
      phase.minimise_at_start("start",
                              [](const auto&, const auto& x) { return 0.5 * x[0] * x[0]; });
    OptimalControlProblem problem("move");
    problem.start_within({unbounded()}, VectorXd::Zero(1)).then(phase);
    const Solution plan = solve(problem);
    ASSERT_TRUE(plan.ok()) << plan.message;
    EXPECT_NEAR(plan.trajectory.state(0.0)[0], 1.0, 1e-6);  // x^2 + (2 - x)^2 is minimal
    EXPECT_NEAR(plan.cost, 1.0, 1e-6);
  }
}

// From 0 through 1 to 3 in 3 s. In a phase of length T the minimum effort is d^2 / 2 T.
OptimalControlProblem two_moves(bool equal_lengths, bool as_square = false) {
  Phase<1, 1> first{"first", Rate{}, between(0.1, 2.9)},
      second{"second", Rate{}, between(0.1, 2.9)};
  for (auto* phase : {&first, &second})
    phase->track("effort", input, VectorXd::Ones(1)).guess_duration(1.5);
  first.reach("there", state, exactly(1.0));
  second.reach("there", state, exactly(3.0));
  OptimalControlProblem problem("two moves");
  problem.start_at({0.0}).then(first).then(second).total_time(exactly(3.0));
  if (as_square)
    problem.minimise_link(
        "equal lengths",
        [](const auto& a, const auto& b) { return 5.0 * square(a.duration - b.duration); },
        end_of(first), end_of(second));
  else if (equal_lengths)
    problem.track_link(
        "equal lengths", [](const auto& a, const auto& b) { return a.duration - b.duration; }, 10.0,
        end_of(first), end_of(second));
  const auto both = [](const auto& a, const auto& b) {
    return Vec<std::decay_t<decltype(a.duration)>, 2>{a.duration, b.duration};
  };
  problem.link("lengths", both, {at_least(0.2), at_most(2.8)}, end_of(first), end_of(second));
  return problem;
}

TEST(UserTasks, CostsAndBoundsApplyOverLinks) {
  const Solution alone = solve(two_moves(false));
  ASSERT_TRUE(alone.ok()) << alone.message;
  EXPECT_NEAR(alone.durations[0], 1.0, 1e-5);
  const Solution plan = solve(two_moves(true));
  ASSERT_TRUE(plan.ok()) << plan.message;
  const double T = plan.durations[0];
  const double slope = -0.5 / (T * T) + 2.0 / ((3.0 - T) * (3.0 - T)) + 20.0 * (2.0 * T - 3.0);
  EXPECT_NEAR(slope, 0.0, 1e-4);  // minimum of 1/2T + 2/(3-T) + 10/2 (2T-3)^2
  EXPECT_NEAR(plan.cost, 0.5 / T + 2.0 / (3.0 - T) + 5.0 * (2.0 * T - 3.0) * (2.0 * T - 3.0), 1e-6);
  const Solution square = solve(two_moves(true, true));
  ASSERT_TRUE(square.ok()) << square.message;
  EXPECT_NEAR(square.durations[0], T, 1e-5);
  EXPECT_NEAR(square.cost, plan.cost, 1e-6);
  const std::string wrong = refusal([] {
    OptimalControlProblem problem = two_moves(true);
    problem.editable_link(1).limits = exactly({1.0, 2.0, 3.0});
    solve(problem);
  });
  EXPECT_EQ(wrong,
            "problem 'two moves', link 'lengths': the formula has 2 rows, but 3 bounds were given");
}

TEST(UserTasks, SolveAndGridOptionsConvert) {
  const ShootingOptions grid{.intervals_per_phase = 10, .integrator = runge_kutta4()};
  const Solution by_grid = solve(dash(), grid);
  const SolveOptions options{.intervals_per_phase = 10, .integrator = runge_kutta4()};
  const Solution by_options = solve(dash(), options);
  MultipleShooting shooting(dash(), options);
  EXPECT_EQ(shooting.options().intervals_per_phase, 10);
  EXPECT_EQ(by_grid.cost, by_options.cost);
  EXPECT_EQ(by_grid.point.w, by_options.point.w);
  EXPECT_TRUE(solve(dash(), ShootingOptions{}).ok());  // the integrator of solve()
}

TEST(UserTasks, SavesAPlan) {
  const auto folder = std::filesystem::temp_directory_path() /
                      ("saltus_first_hour_" + std::to_string(::getpid())) / "plan";
  const Solution plan = solve(dash());
  save(dash(), plan, folder, {"position [m]", "speed [m/s]"}, {"acceleration [m/s^2]"});
  const std::string table = file_content(folder / "trajectory.csv");
  EXPECT_EQ(table.substr(0, table.find('\n')),
            "t [s],mode,position [m],speed [m/s],acceleration [m/s^2]");
  EXPECT_EQ(file_content(folder / "events.csv"), "t [s],event,kind,mode before,mode after\n");
  save(dash(), plan.trajectory, folder);
  EXPECT_EQ(refusal([&] { save(dash(), plan, folder, {"position [m]"}); }),
            "save: 1 names of states were given, but the plan has 2 states");
  EXPECT_THROW(save(dash(), plan, folder / "trajectory.csv"), InputError);
  std::filesystem::remove_all(folder.parent_path());
}

ShrinkingHorizonController controller_of(const OptimalControlProblem& problem, double period) {
  return {problem,
          remaining_controllers(problem, {.intervals_per_phase = 6, .integrator = runge_kutta4()},
                                [&](MultipleShooting rest) {
                                  return RecedingHorizonController(
                                      std::move(rest), make_real_time_solver(make_native_solver()),
                                      {.period = period});
                                })};
}

// One metre from rest to rest in minimum time: full throttle, then full brake.
TEST(UserTasks, ReachesTheEndWithACustomPlant) {
  Phase<2, 1> throttle{"throttle", Cart{}, between(0.1, 5.0)},
      brake{"brake", Cart{}, between(0.1, 5.0)};
  for (auto* phase : {&throttle, &brake})
    phase->bound_input(0, between(-1.0, 1.0)).guess_duration(1.1);
  brake.reach("there", state, exactly({1.0, 0.0}))
      .minimise_at_end("time", [](const auto& t, const auto&) { return t; });
  OptimalControlProblem problem("dash");
  problem.start_at({0, 0}).then(throttle).then(brake);
  const LoopOptions options{.duration = 6.0, .tolerance = {.relative = 1e-4}};
  ShrinkingHorizonController controller = controller_of(problem, 0.04);
  IntegratorPlant plant = make_plant<2, 1>(Cart{}, runge_kutta4(), VectorXd::Zero(2));
  const LoopLog log = simulate_closed_loop(controller, plant, options);
  EXPECT_TRUE(log.ok()) << log.message;
  EXPECT_NEAR(plant.state()[0], 1.0, 1e-4);
  // The result equals that of the plant with phases.
  ShrinkingHorizonController same = controller_of(problem, 0.04);
  PhasedPlant phased(problem, runge_kutta4());
  const LoopLog reference = simulate_closed_loop(same, phased, options);
  EXPECT_EQ(log.ticks.size(), reference.ticks.size());
  EXPECT_NEAR(plant.time(), phased.over_since(), 1e-9);
  EXPECT_LE((plant.state() - phased.state()).cwiseAbs().maxCoeff(), 1e-9);
  ASSERT_EQ(log.recording.events.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(log.recording.events[i].name, reference.recording.events[i].name);
    EXPECT_EQ(log.recording.events[i].mode_after, reference.recording.events[i].mode_after);
    EXPECT_NEAR(log.recording.events[i].time, reference.recording.events[i].time, 1e-9);
  }
}

// A ball that bounces in advance() and reports the event, or that bounces in enter_phase().
class BouncingBall final : public LoopPlant {
 public:
  explicit BouncingBall(bool reports) : reports_(reports) {}
  double time() const override { return time_; }
  VectorXd state() const override { return x_; }
  int inputs() const override { return 1; }
  bool advance(const VectorRef& u, double length) override {
    const double a = u[0] - gravity, rate = -x_[1] / a, drop = 2.0 * x_[0] / a;
    const double hit = a < 0.0 ? rate + std::sqrt(rate * rate - drop) : infinity;
    if (reports_ && hit > 0.0 && hit < length && x_[0] > 0.0) {
      move(a, hit);
      HybridEvent impact;
      impact.time = time_;
      impact.kind = HybridEvent::Kind::jumps;
      impact.name = "impact";
      impact.before = x_;
      enter_phase(1);
      events_.push_back(std::move(impact));
      length -= hit;
    }
    move(a, length);
    return true;
  }
  std::vector<HybridEvent> take_events() override { return std::exchange(events_, {}); }
  void enter_phase(int) override {
    if (x_[1] < 0.0) x_ = VectorXd{{0.0, -0.8 * x_[1]}};
  }

 private:
  void move(double a, double length) {
    x_[0] += x_[1] * length + 0.5 * a * length * length;
    x_[1] += a * length;
    time_ += length;
  }
  bool reports_;
  double time_ = 0.0;
  VectorXd x_{{1.0, 0.0}};
  std::vector<HybridEvent> events_;
};

TEST(UserTasks, PhaseOfACustomPlantEndsByEventOrGuard) {
  Phase<2, 1> fall{"fall", Ball{}, between(0.1, 0.9)}, rise{"rise", Ball{}, between(0.1, 0.9)};
  fall.ends_when("impact", height, Crossing::falling).minimise("effort", effort);
  rise.minimise("effort", effort).reach("back", state, exactly({1.0, 0.0}));
  for (auto* phase : {&fall, &rise}) phase->guess_duration(0.5);
  const auto map = [](const auto&, const auto& x) { return decltype(x.eval()){x[0], -0.8 * x[1]}; };
  OptimalControlProblem problem("bounce");
  problem.start_at({1, 0}).then(fall).then(rise, jump<2>("bounce", map)).total_time(exactly(1.0));
  for (const bool reports : {true, false}) {
    ShrinkingHorizonController controller = controller_of(problem, 0.05);
    BouncingBall plant(reports);
    const LoopLog log =
        simulate_closed_loop(controller, plant, {.duration = 2.0, .samples_per_tick = 50});
    EXPECT_TRUE(log.completed && log.reached_end) << log.message;
    EXPECT_NEAR(plant.time(), 1.0, 1e-6);
    EXPECT_NEAR(plant.state()[0], 1.0, reports ? 1e-3 : 1e-2);  // the guard: within 1 ms
    ASSERT_EQ(log.recording.events.size(), 2u);
    EXPECT_EQ(log.recording.events[0].name, "impact");
    EXPECT_EQ(log.recording.events[0].mode_after, "rise");
  }
}

TEST(UserTasks, MismatchedCustomPlantGivesOneSentence) {
  Phase<2, 1> fly{"fly", Cart{}, between(0.1, 0.9)};
  Phase<1, 1> roll{"roll", Rate{}, exactly(1.0)};
  fly.guess_duration(0.5).reach("there", height, exactly(0.1)).minimise("effort", effort);
  roll.track("effort", input, VectorXd::Ones(1));
  OptimalControlProblem problem("land");
  problem.start_at({0, 0}).then(fly).then(
      roll, jump<2>("land", [](const auto&, const auto& x) { return x[0]; }));
  ShrinkingHorizonController controller = controller_of(problem, 0.05);
  IntegratorPlant plant = make_plant<2, 1>(Cart{}, runge_kutta4(), VectorXd::Zero(2));
  const LoopLog log = simulate_closed_loop(controller, plant, {.duration = 2.0});
  EXPECT_FALSE(log.completed);
  EXPECT_NE(log.message.find("where phase 'roll' of the controller begins, which has 1 and 1: "
                             "change them in enter_phase()"),
            std::string::npos)
      << log.message;
}

}  // namespace
}  // namespace saltus
