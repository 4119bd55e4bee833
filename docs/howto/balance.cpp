// A balance controller on a robot of your own, which stands on both feet.
#include <cstdio>
#include <filesystem>
#include <utility>

#include "driver.hpp"
#include "saltus/robots/dart/dart_plant.hpp"  // equations of motion
#include "saltus/robots/walking/balance_controller.hpp"

namespace robots = saltus::robots;
using robots::walking::BalanceController, robots::walking::cone_options,
    robots::walking::ContactSettings, robots::walking::initial_scene,
    robots::walking::make_capture_point_controller, robots::walking::posture_on_both_feet,
    robots::walking::Scene, robots::walking::SceneSettings, robots::walking::StepPlanner,
    robots::walking::two_feet_throughout;
using saltus::Schedule, saltus::VectorXd;

class MyRobot final : public robots::Robot {
 public:
  MyRobot(Driver& driver, const robots::FloatingRobot& body) : driver_(driver) {
    for (const std::string& joint : driver.joints) index_.push_back(body.joint_index(joint));
    readings_.q = VectorXd::Zero(body.joints());
    publish();
  }
  const Readings& read() const override { return readings_; }
  void write(const Commands& commands) override {
    for (std::size_t i = 0; i < index_.size(); ++i)
      driver_.torques[i] = commands.torques[index_[i]];
  }
  std::string wait() override {
    if (!driver_.next_sample()) return "the robot sends no samples";
    if (driver_.clock - readings_.time > 1.5 * period()) return "a sample was lost";
    publish();
    return {};
  }
  double period() const override { return 0.001; }
  std::string name() const override { return "my robot"; }

 private:
  void publish() {
    readings_.time = driver_.clock;
    for (std::size_t i = 0; i < index_.size(); ++i) readings_.q[index_[i]] = driver_.positions[i];
    readings_.has_new_positions = true;
    readings_.angular_velocity = driver_.gyroscope;
    readings_.specific_force = driver_.accelerometer;
    readings_.left = driver_.soles.head<6>();
    readings_.right = driver_.soles.tail<6>();
  }

  Driver& driver_;
  std::vector<int> index_;  // places of the driver's joints in the vectors of Saltus
  Readings readings_;
};

int main() {
  const auto folder = std::filesystem::path(__FILE__).parent_path();
  const auto urdf = robots::UrdfModel::read(folder / "biped.urdf");
  constexpr auto from_urdf = robots::RobotDescription::Figures::from_urdf;
  const auto description =
      robots::describe(urdf, robots::read_robot_description(folder / "biped.yaml", from_urdf));
  const robots::FloatingRobot body = robots::floating_robot(urdf, description);
  const robots::StandingPosture& posture = posture_on_both_feet(description);
  const auto start = robots::standing_state(body, urdf, description, posture);
  const Scene scene =
      initial_scene({robots::Stance::both, SceneSettings::Target::centroid}, description);

  Driver driver;
  for (int i = body.joints(); i > 0; --i) {
    driver.joints.push_back(body.bodies[i].joint);
    driver.positions.push_back(start.q[i - 1]);
  }
  driver.torques.resize(driver.joints.size());
  driver.soles = scene.standing_wrenches(body.total_mass, posture.com);
  MyRobot robot(driver, body);

  const ContactSettings contact;
  const Schedule contacts = two_feet_throughout();
  BalanceController::Parts parts;
  parts.estimator = robots::make_sensor_estimator(body, scene.side, {}, {}, robot.period());
  parts.model = robots::make_dart_dynamics(body);
  parts.whole_body =
      robots::make_inverse_dynamics_controller(body, cone_options(contact, description.left_foot),
                                               cone_options(contact, description.right_foot));
  parts.steps = std::make_unique<StepPlanner>();  // never steps
  parts.wrenches = make_capture_point_controller({}, {}, contact, description, scene, contacts);
  BalanceController controller(std::move(parts),
                               {.period = robot.period(), .scene = scene, .contacts = contacts});

  controller.start(start, robot.read());
  std::string failure;
  for (int k = 0; k < 1000 && failure.empty(); ++k) {
    robot.write(controller.update(robot.read()));
    failure = robot.wait();
  }
  const bool is_good = failure.empty() && controller.statistics().failures == 0;
  std::printf("every torque was computed: %s; left ankle: %.0f Nm\n", is_good ? "yes" : "no",
              controller.commands().torques[body.joint_index("l_ankle_pitch")]);
  return is_good ? 0 : 1;
}
