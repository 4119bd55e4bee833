// The balance planner carries out a step plan.
#include "saltus/robots/walking/balance_controller.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/walking/contacts.hpp"
#include "saltus/robots/walking/planner.hpp"
#include "tests/robots/fixed_steps.hpp"
#include "tests/support/errors.hpp"

namespace saltus::robots::walking {
namespace {

BalancePlanner::Estimate at_rest(const Scene& scene, const RobotDescription& robot) {
  BalancePlanner::Estimate estimate;
  estimate.mass = robot.mass;
  estimate.left_sole = scene.sole(Side::left);
  estimate.right_sole = scene.sole(Side::right);
  estimate.gamma.head<2>() = scene.target_point();
  estimate.gamma[2] = scene.com_height;
  return estimate;
}

// The plan has a step of the right foot, then one of the left foot. The run ends before the second
// step. The robot stays in its initial state.
TEST(BalancePlanner, TakesTheFirstStepOfAPlanAtItsTimeAndPlace) {
  const RobotDescription robot = icub();
  StepPlan plan;
  plan.count = 2;
  plan.steps[0] = {Side::right, 0.02, 0.05, 0.04, {0.1, -0.15, 0.0}};
  plan.steps[1] = {Side::left, 0.2, 0.3, 0.3, {0.2, 0.0, 0.0}};
  const FixedSteps problem(plan, 0.045);
  const Scene scene = initial_scene(problem, robot);
  BalancePlanner planner(
      scene, problem.contacts(scene), problem.make_step_planner(robot, scene),
      make_capture_point_controller({}, {}, {}, robot, scene, problem.contacts(scene)), 0.01,
      BalancePlanner::LandingTime::as_planned);
  const BalancePlanner::Estimate estimate = at_rest(scene, robot);
  for (int k = 0; k < 5; ++k) {
    const double t = 0.01 * k;
    const BalancePlanner::StepChange change = planner.plan_steps(t, estimate);
    planner.plan_wrenches(t, estimate);
    EXPECT_EQ(change.has_begun, k == 2) << t;
    EXPECT_EQ(change.has_lifted, k == 2) << t;
    EXPECT_EQ(change.has_target, k >= 2) << t;
    EXPECT_EQ(planner.is_stepping(), k >= 2) << t;
    EXPECT_TRUE(planner.stands(Side::left));
    EXPECT_EQ(planner.stands(Side::right), k < 2) << t;
  }
  const StepPlan::Step& step = planner.step();
  EXPECT_EQ(step.foot, Side::right);
  EXPECT_DOUBLE_EQ(step.lift_off, 0.02);
  EXPECT_EQ(step.landing, plan.steps[0].landing);
  EXPECT_EQ(step.earliest_landing, plan.steps[0].earliest_landing);
  EXPECT_EQ(step.place, plan.steps[0].place);
  planner.land(0.05, step.place);
  EXPECT_FALSE(planner.is_stepping());
  EXPECT_TRUE(planner.stands(Side::right));
  EXPECT_EQ(planner.scene().swing.position, plan.steps[0].place);
  EXPECT_TRUE(planner.scene().swing.rotation.isIdentity(0.0));
}

// The feet of the scene have the planned heading of the landing foot, and the measured one of the
// other foot.
TEST(BalancePlanner, TurnsTheFeetOfTheScene) {
  const RobotDescription robot = icub();
  StepPlan plan;
  plan.count = 1;
  plan.steps[0] = {Side::right, 0.0, 0.05, 0.04, {0.1, -0.15, 0.0}, 0.3};
  const FixedSteps problem(plan, 0.045);
  const Scene scene = initial_scene(problem, robot);
  BalancePlanner planner(
      scene, problem.contacts(scene), problem.make_step_planner(robot, scene),
      make_capture_point_controller({}, {}, {}, robot, scene, problem.contacts(scene)), 0.01,
      BalancePlanner::LandingTime::as_planned);
  BalancePlanner::Estimate estimate = at_rest(scene, robot);
  estimate.left_sole = flat_sole(scene.sole(Side::left).position, 0.2);
  EXPECT_TRUE(planner.plan_steps(0.0, estimate).has_lifted);
  const auto yaw = [&](Side side) {
    const Mat<double, 3, 3>& rotation = planner.scene().sole(side).rotation;
    return std::atan2(rotation(1, 0), rotation(0, 0));
  };
  EXPECT_NEAR(yaw(Side::left), 0.2, 1e-12);
  EXPECT_NEAR(yaw(Side::right), 0.3, 1e-12);
}

// A capture-point controller that records the landing time in its contact schedule.
class RecordingPlanner final : public Planner {
 public:
  RecordingPlanner(std::unique_ptr<Planner> planner, double& landing)
      : planner_(std::move(planner)), landing_(landing) {}
  const ControlTick& tick(const Measurement& measured, const Scene& scene,
                          const Schedule& contacts) override {
    landing_ = landing_time(contacts);
    return planner_->tick(measured, scene, contacts);
  }
  RecedingHorizonController& controller() override { return planner_->controller(); }

 private:
  std::unique_ptr<Planner> planner_;
  double& landing_;
};

// When the planned landing is due, the plan still has one foot on the ground for two ticks.
TEST(BalancePlanner, PlansNoDoubtedLandingWithinTheNextTick) {
  constexpr double period = 0.01, due = 0.05;
  const RobotDescription robot = icub();
  StepPlan plan;
  plan.count = 1;
  plan.steps[0] = {Side::right, 0.0, due, 0.04, {0.1, -0.15, 0.0}};
  const FixedSteps problem(plan, 0.045);
  const Scene scene = initial_scene(problem, robot);
  using LandingTime = BalancePlanner::LandingTime;
  for (const auto& [time, delay] :
       {std::pair{LandingTime::as_planned, 0.0}, std::pair{LandingTime::when_felt, period},
        std::pair{LandingTime::doubted, 2.0 * period}}) {
    double landing = 0.0;
    BalancePlanner planner(
        scene, problem.contacts(scene), problem.make_step_planner(robot, scene),
        std::make_unique<RecordingPlanner>(
            make_capture_point_controller({}, {}, {}, robot, scene, problem.contacts(scene)),
            landing),
        period, time);
    const BalancePlanner::Estimate estimate = at_rest(scene, robot);
    for (int k = 0; k <= 5; ++k) {
      planner.plan_steps(period * k, estimate);
      planner.plan_wrenches(period * k, estimate);
    }
    EXPECT_NEAR(landing, due + delay, 1e-12);
  }
}

TEST(PostureAtStart, IsChosenByTheEndOfItsName) {
  const RobotDescription robot = icub();
  SceneSettings settings;
  EXPECT_EQ(posture_at_start(settings, robot).name, "left_stance");
  settings.posture = "bent";
  EXPECT_EQ(posture_at_start(settings, robot).name, "left_stance_bent");
  settings.stance = Stance::right;
  EXPECT_EQ(posture_at_start(settings, robot).name, "right_stance_bent");
  settings.stance = Stance::both;
  expect_error<InputError>([&] { posture_at_start(settings, robot); },
                           {"posture", "icub.yaml", "\"_bent\"", "two_feet"});
}

}  // namespace
}  // namespace saltus::robots::walking
