// Plans of iCub's whole body, by two solvers, and their tracking in DART.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "problems/whole_body/tasks.hpp"
#include "problems/whole_body/tracking.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/robots/icub_body.hpp"

namespace saltus::whole_body {
namespace {

const ShootingOptions grid{.intervals_per_phase = 6, .integrator = runge_kutta4()};

class WholeBodyPlans : public IcubBody {
 protected:
  void SetUp() override {
    IcubBody::SetUp();
    if (IsSkipped()) return;
    robots::add_capsules(robot, *urdf, description);
  }
  Solution plan_of(const Task& task, SolverChoice choice) const {
    MultipleShooting shooting(problem(body(), task, {}), grid);
    const auto solver = make_solver(choice, {.tolerance = 1e-6, .time_limit = 60.0});
    return solve(shooting, *solver);
  }
  // The formulas of a plan refer to it.
  const Body& body() const {
    if (!body_) body_.emplace(robot, description);
    return *body_;
  }

 private:
  mutable std::optional<Body> body_;
};

TEST_F(WholeBodyPlans, StartPostureStandsOnBothSoles) {
  const Task step = task("step", body(), {});
  const robots::Kinematics<joints, double> at(body().tree, step.start);
  for (int foot = 0; foot < 2; ++foot) {
    const double y = foot == 0 ? 0.07 : -0.07;
    EXPECT_LT((at.position(body().soles[foot]) - Vec<double, 3>(0.0, y, 0.0)).norm(), 1e-9);
    EXPECT_LT((at.rotation(body().soles[foot]) - Mat<double, 3, 3>::Identity()).norm(), 1e-9);
  }
}

TEST_F(WholeBodyPlans, TwoSolversFindTheSameStep) {
  const Task step = task("step", body(), {});
  const Solution by_stages = plan_of(step, SolverChoice::riccati);
  const Solution by_ipopt = plan_of(step, SolverChoice::ipopt);
  ASSERT_TRUE(by_stages.ok()) << by_stages.message;
  ASSERT_TRUE(by_ipopt.ok()) << by_ipopt.message;
  EXPECT_NEAR(by_stages.cost, by_ipopt.cost, 1e-5 * by_ipopt.cost);
  EXPECT_LE(by_stages.iterations, 40);  // from the guess once, and a few more for its accuracy
  // The right sole ends where it should, with the centre of mass between the feet.
  const VectorXd end = by_stages.trajectory.final_state();
  const robots::Kinematics<joints, double> at(body().tree, end.tail<coordinates>().eval());
  EXPECT_LT((at.position(body().soles[1]) - Vec<double, 3>(0.15, -0.07, 0.0)).norm(), 1e-6);
  EXPECT_LT((end.head<2>() - step.goal).cwiseAbs().maxCoeff(), 0.02 + 1e-6);
  EXPECT_LT(end.segment<6>(3).norm(), 1e-6);
}

struct OnGround {
  std::string task;
  double height, slope_deg;
};
class TrackedTasks : public WholeBodyPlans, public testing::WithParamInterface<OnGround> {};

TEST_P(TrackedTasks, DoNotFall) {
  const Task task = whole_body::task(GetParam().task, body(), {});
  const Solution plan = plan_of(task, SolverChoice::riccati);
  ASSERT_TRUE(plan.ok()) << plan.message;
  TrackingOptions options;
  robots::Plant::Ground& ground = options.ground;
  ground.ahead = true;
  ground.edge = edge_ahead(body());
  ground.height = GetParam().height;
  ground.slope_forward = std::tan(GetParam().slope_deg * std::numbers::pi / 180.0);
  const PlannedTask motion{&task, &plan.trajectory};
  const Tracking tracked = track(body(), robot, {&motion, 1}, options);
  EXPECT_FALSE(tracked.fell) << "at " << tracked.fell_at << " s";
  EXPECT_LT(tracked.com, 0.02);
  EXPECT_LT(tracked.com_at_end, 0.001);
  EXPECT_LT(tracked.feet, 0.015);
  EXPECT_LT(tracked.slip, 0.002);
  EXPECT_GT(tracked.table.rows(), 200u);
}

INSTANTIATE_TEST_SUITE_P(All, TrackedTasks,
                         testing::Values(OnGround{"step", 0.0, 0.0}, OnGround{"walk", 0.0, 0.0},
                                         OnGround{"step_up", 0.1, 0.0}, OnGround{"ramp", 0.0, 10.0},
                                         OnGround{"turn", 0.0, 0.0}, OnGround{"hop", 0.0, 0.0}),
                         [](const auto& tested) { return tested.param.task; });

// A push of 4 N s to the left, in the middle of the step.
class PushedStep : public WholeBodyPlans {
 protected:
  Tracking pushed(bool replans) const {
    const Task step = task("step", body(), {});
    const Solution plan = plan_of(step, SolverChoice::riccati);
    const OptimalControlProblem ocp = problem(body(), step, {});
    Replanner replanner(ocp, grid, 0.02, plan.trajectory);
    const PlannedTask motion{&step, &plan.trajectory, replans ? &replanner : nullptr};
    const Tracking result = track(body(), robot, {&motion, 1}, push(4.0, {0.0, 1.0, 0.0}));
    const auto& counts = replanner.statistics().counts;
    EXPECT_EQ(counts[static_cast<std::size_t>(Provenance::shifted)], 0);
    EXPECT_EQ(counts[static_cast<std::size_t>(Provenance::fallback)], 0);
    return result;
  }
  TrackingOptions push(double impulse, const Vec<double, 3>& direction) const {
    TrackingOptions options;
    options.push = {impulse, direction, 0.3};
    options.pushed.body = 0;
    options.pushed.pose.setIdentity();
    return options;
  }
};

TEST_F(PushedStep, NewPlansStayNearTheMotion) {
  const Tracking first = pushed(false), renewed = pushed(true);
  EXPECT_FALSE(first.fell);
  EXPECT_FALSE(renewed.fell);
  EXPECT_GT(first.com, 0.004);
  EXPECT_LT(renewed.com, 0.002);
  EXPECT_LT(renewed.com_at_end, 0.001);
}

// The robot steps with the foot on the side of the push, and not at all after a weak one.
TEST_F(PushedStep, RobotRecoversByAStepWithTheNearerFoot) {
  std::vector<Task> tasks;
  std::vector<Solution> plans;
  for (const int foot : {0, 1}) {
    Sizes sizes;
    sizes.foot = foot;
    tasks.push_back(task("recover", body(), sizes));
    plans.push_back(plan_of(tasks.back(), SolverChoice::riccati));
    ASSERT_TRUE(plans.back().ok()) << plans.back().message;
  }
  // The number of solves and the index of the motion.
  const auto recover = [&](double impulse, const Vec<double, 3>& direction) {
    std::deque<Replanner> replanners;
    std::vector<PlannedTask> motions;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      replanners.emplace_back(problem(body(), tasks[i], {}), grid, 0.02, plans[i].trajectory);
      motions.push_back({&tasks[i], &plans[i].trajectory, &replanners.back()});
    }
    TrackingOptions options = push(impulse, direction);
    options.waits = true;
    const Tracking tracked = track(body(), robot, motions, options);
    EXPECT_FALSE(tracked.fell);
    EXPECT_LT(tracked.com_at_end, 0.01);
    const auto chosen = static_cast<std::size_t>(tracked.motion);
    return std::pair(replanners[chosen].statistics().processor.count(), tracked.motion);
  };
  EXPECT_EQ(recover(4.0, {0.0, -1.0, 0.0}).first, 0);
  const auto [to_the_left, left] = recover(12.0, {0.0, 1.0, 0.0});
  EXPECT_GT(to_the_left, 20);
  EXPECT_EQ(left, 0);
  const auto [to_the_right, right] = recover(12.0, {0.0, -1.0, 0.0});
  EXPECT_GT(to_the_right, 20);
  EXPECT_EQ(right, 1);
}

}  // namespace
}  // namespace saltus::whole_body
