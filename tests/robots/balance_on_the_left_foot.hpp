// A whole-body controller without a planner: a linear law for the momentum, one push, no step.
#pragma once

#include <gtest/gtest.h>

#include "saltus/robots/whole_body/floating_robot.hpp"
#include "saltus/robots/whole_body/swing_foot.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus {

struct SidePush {
  double impulse;       ///< N s, towards -y, on the chest
  double start = 0.2;   ///< s
  double length = 0.1;  ///< s
  double end = 2.5;     ///< end of the run, s
};

/// The plant begins on its left foot, `tasks` are those of rest there, and the model has the state
/// of the plant. Calls `check` with every command. Expects rest above the foot at the end.
template <class Plant, class Check>
void balance_on_the_left_foot(const robots::FloatingRobot& robot, robots::DynamicsModel& model,
                              Plant& plant, robots::WholeBodyController& controller,
                              robots::WholeBodyController::Tasks tasks, const SidePush& push,
                              const Check& check) {
  robots::SwingFoot swing;
  swing.hold(model.sole(robots::Side::right).pose);
  const Vec<double, 3> above_the_foot(0.0, 0.0, model.com()[2]);
  const int chest = robot.body_index("chest");
  for (int k = 0; 1e-3 * k < push.end; ++k) {
    const double t = 1e-3 * k;
    if (k % 2 == 0) {
      model.update(plant.state());
      tasks.force =
          model.mass() * (50.0 * (above_the_foot - model.com()) - 14.0 * model.com_velocity());
      tasks.torque = -5.0 * model.angular_momentum();
      tasks.swing_acceleration = swing.acceleration(model.sole(robots::Side::right));
      const robots::WholeBodyController::Command& command =
          controller.control(model, plant.state(), tasks);
      ASSERT_EQ(command.status, qp::QpStatus::optimal) << t;
      check(command, t);
      plant.set_torques(command.torques);
    }
    if (t >= push.start && t < push.start + push.length)
      plant.push(chest, {0.0, -push.impulse / push.length, 0.0}, Vec<double, 3>::Zero());
    plant.step();
  }
  EXPECT_LT((model.com() - above_the_foot).norm(), 0.005);
  EXPECT_LT(model.com_velocity().norm(), 0.01);
  EXPECT_FALSE(plant.contact(robots::Side::right).touches);
  EXPECT_LT(model.sole(robots::Side::left).pose.translation().norm(), 0.005);  // it did not hop
}

}  // namespace saltus
