// The synthetic biped, which lowers its right foot, with a controller that needs no simulator.
#pragma once

#include <memory>
#include <utility>

#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/balance_controller.hpp"
#include "saltus/robots/walking/planner.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"
#include "tests/robots/synthetic_biped.hpp"

namespace saltus::robots::walking {

/// Plans one step of the right foot, initially in the air, to the place below it.
class RightFootDown final : public StepPlanner {
 public:
  explicit RightFootDown(const Vec<double, 3>& place) {
    plan_.steps[0] = {Side::right, 0.05, 0.2, 0.15, place};
  }
  const StepPlan& plan(const StepSituation& now) override {
    plan_.count = now.right.stands ? 0 : 1;
    return plan_;
  }
};

struct SyntheticBalance {
  SyntheticBalance() {
    const SyntheticBiped biped;
    const UrdfModel urdf = UrdfModel::parse(biped.urdf(), "synthetic.urdf");
    description = describe(urdf, parse_robot_description(biped.yaml(), "synthetic.yaml",
                                                         RobotDescription::Figures::from_urdf));
    robot = floating_robot(urdf, description);
    const StandingPosture& posture = description.default_posture();
    start = standing_state(robot, urdf, description, posture);
    scene = scene_of(posture, description);
  }

  BalanceController::Parts parts(std::unique_ptr<DynamicsModel> model,
                                 std::unique_ptr<Estimator> estimator) const {
    const ContactSettings contact;
    const Schedule contacts = one_foot_then_two(infinity, scene.side, 1);
    BalanceController::Parts parts;
    parts.estimator = std::move(estimator);
    parts.model = std::move(model);
    parts.whole_body =
        make_inverse_dynamics_controller(robot, cone_options(contact, description.left_foot),
                                         cone_options(contact, description.right_foot));
    parts.steps = std::make_unique<RightFootDown>(scene.swing.position);
    parts.wrenches = make_capture_point_controller({}, {}, contact, description, scene, contacts);
    return parts;
  }
  BalanceController controller(std::unique_ptr<DynamicsModel> model,
                               std::unique_ptr<Estimator> estimator) const {
    return {parts(std::move(model), std::move(estimator)), options()};
  }
  /// Estimates from measured sensors.
  std::unique_ptr<Estimator> sensor_estimator() const {
    return make_sensor_estimator(robot, Side::left, SensorOptions{}, Estimator::Options{},
                                 options().period);
  }
  BalanceController::Options options() const {
    BalanceController::Options options;
    options.scene = scene;
    options.contacts = one_foot_then_two(infinity, scene.side, 1);
    return options;
  }

  RobotDescription description;
  FloatingRobot robot;
  WholeBodyState start;
  Scene scene;
};

}  // namespace saltus::robots::walking
