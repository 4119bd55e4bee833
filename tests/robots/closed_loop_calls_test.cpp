// What the closed loop makes of a plan of steps: told to a plant that does nothing but take note.
#include <gtest/gtest.h>

#include <initializer_list>

#include "saltus/ocp/window.hpp"
#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/walking/closed_loop.hpp"
#include "tests/robots/fixed_steps.hpp"

namespace saltus::walking {
namespace {

// Stands as at the start; its feet are where they were put.
class Notebook : public LeggedPlant {
 public:
  Notebook(const RobotDescription& robot, const Scene& scene)
      : mass_(robot.mass), left_(scene.sole(Side::left)), right_(scene.sole(Side::right)) {
    gamma_.head<2>() = 0.5 * (left_.position + right_.position).head<2>();
    gamma_[2] = scene.com_height;
  }

  double tick_time(long k) const override { return 0.01 * static_cast<double>(k); }
  double step_end(double, double limit) const override { return limit; }
  bool sense(double) override { return true; }
  Vec<double, 9> measured() const override { return gamma_; }
  double nominal_mass() const override { return mass_; }
  SoleFrame sole(Side foot) const override { return foot == Side::left ? left_ : right_; }
  Vec<double, 3> sole_velocity(Side) const override { return Vec<double, 3>::Zero(); }
  const Vec<double, 12>& applied() const override { return applied_; }
  Vec<double, 3> contact_force() const override {
    return applied_.head<3>() + applied_.segment<3>(6);
  }
  bool lands_on_time() const override { return true; }
  void lift_off(double t, Side foot) override { lifted.emplace_back(t, foot); }
  void swing(double, const SwingTarget& to) override { target = to; }
  std::optional<Landing> find_landing(double t) override {
    if (t < target.landing - same_instant) return std::nullopt;
    return Landing{target.place, target.place};
  }
  void command(double, const Vec<double, 12>& wrenches) override { applied_ = wrenches; }
  std::string step(double, double to) override {
    now_ = to;
    return {};
  }
  double truth_time() const override { return now_; }
  Vec<double, 9> truth() const override { return gamma_; }
  Vec<double, 3> true_sole(Side foot) const override { return sole(foot).position; }
  void describe(RunLog&) const override {}

  std::vector<std::pair<double, Side>> lifted;
  SwingTarget target;

 private:
  double mass_, now_ = 0.0;
  SoleFrame left_, right_;
  Vec<double, 9> gamma_ = Vec<double, 9>::Zero();
  Vec<double, 12> applied_ = Vec<double, 12>::Zero();
};

// The same in steps of 1 ms, measured at every fifth.
class FineNotebook final : public Notebook {
 public:
  using Notebook::Notebook;
  double tick_time(long k) const override { return step_ * static_cast<double>(10 * k); }
  double step_end(double, double) const override { return step_ * static_cast<double>(steps_ + 1); }
  double sample_end(double) const override {
    return step_ * static_cast<double>((steps_ / 5 + 1) * 5);
  }
  bool sense(double) override { return steps_ % 5 == 0; }
  std::string step(double from, double to) override {
    ++steps_;
    return Notebook::step(from, to);
  }

 private:
  double step_ = 0.001;  // s
  long steps_ = 0;
};

// However short it is, and wherever it lies between two samples.
TEST(ClosedLoopCalls, ThePushOfSamplesHasItsImpulse) {
  const RobotDescription robot = icub();
  for (const double start : {2.400, 2.401})
    for (const double duration : {0.001, 0.003}) {
      FixedSteps problem({}, 2.43);
      Push push;
      push.start = start;
      push.duration = duration;
      problem.all = {push};
      FineNotebook fine(robot, initial_scene(problem, robot));
      Notebook coarse(robot, initial_scene(problem, robot));
      for (LeggedPlant* plant : std::initializer_list<LeggedPlant*>{&fine, &coarse}) {
        const RunLog log = simulate(problem, robot, *plant);
        Vec<double, 3> impulse = Vec<double, 3>::Zero();
        for (std::size_t i = 0; i + 1 < log.samples.size(); ++i)
          impulse += log.samples[i].push * (log.samples[i + 1].time - log.samples[i].time);
        EXPECT_LT((impulse - push.impulse * push.direction).norm(), 1e-9)
            << start << " s, " << duration << " s";
      }
    }
}

// Right foot, then left foot; the run ends before the second.
TEST(ClosedLoopCalls, TheFirstStepOfAPlanIsTakenAtItsTimeAndPlace) {
  const RobotDescription robot = icub();
  StepPlan plan;
  plan.count = 2;
  plan.steps[0] = {Side::right, 0.02, 0.05, 0.04, {0.1, -0.15, 0.0}};
  plan.steps[1] = {Side::left, 0.2, 0.3, 0.3, {0.2, 0.0, 0.0}};
  const FixedSteps problem(plan, 0.045);
  Notebook plant(robot, initial_scene(problem, robot));
  const RunLog log = simulate(problem, robot, plant);
  EXPECT_FALSE(log.stopped_early) << log.stop_reason;
  ASSERT_EQ(plant.lifted.size(), 1u);
  EXPECT_DOUBLE_EQ(plant.lifted[0].first, 0.02);
  EXPECT_EQ(plant.lifted[0].second, Side::right);
  EXPECT_EQ(plant.target.landing, plan.steps[0].landing);
  EXPECT_EQ(plant.target.earliest, plan.steps[0].earliest_landing);
  EXPECT_EQ(plant.target.place, plan.steps[0].place);
  ASSERT_EQ(log.steps.size(), 1u);
  EXPECT_EQ(log.steps[0].foot, Side::right);
  EXPECT_DOUBLE_EQ(log.steps[0].lift_off, 0.02);
  EXPECT_EQ(log.steps[0].due, plan.steps[0].landing);
  EXPECT_EQ(log.steps[0].place, plan.steps[0].place);
  EXPECT_EQ(log.touchdown, infinity);
}

}  // namespace
}  // namespace saltus::walking
