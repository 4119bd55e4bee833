// Prints the dynamics of a robot in random states as JSON lines, for a comparison with another
// library: print_dynamics URDF STATES SEED. The robot is iCub's (icub.yaml).
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <nlohmann/json.hpp>
#include <random>

#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/icub/icub.hpp"

namespace saltus {
namespace {

using Json = nlohmann::json;

Json numbers(const Eigen::Ref<const MatrixXd>& m) {
  Json rows = Json::array();
  for (int i = 0; i < m.rows(); ++i) {
    Json row = Json::array();
    for (int j = 0; j < m.cols(); ++j) row.push_back(m(i, j));
    rows.push_back(row);
  }
  return rows;
}

Json sole(const robots::DynamicsModel::SoleMotion& motion) {
  return {{"position", numbers(motion.pose.translation())},
          {"rotation", numbers(motion.pose.linear())},
          {"jacobian", numbers(motion.jacobian)},
          {"drift", numbers(motion.drift)}};
}

void print(const char* urdf_file, int states, unsigned seed) {
  const robots::UrdfModel urdf = robots::UrdfModel::read(urdf_file);
  const robots::RobotDescription description = icub(urdf_file);
  const robots::FloatingRobot robot =
      robots::with_drives_scaled(robots::floating_robot(urdf, description), {});
  const auto dynamics = robots::make_dart_dynamics(robot);

  Json model{{"joints", Json::array()},
             {"left_sole", description.left_sole},
             {"right_sole", description.right_sole},
             {"contact_plane_offset", description.contact_plane_offset}};
  for (std::size_t i = 1; i < robot.bodies.size(); ++i)
    model["joints"].push_back(robot.bodies[i].joint);
  fmt::print("{}\n", model.dump());

  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int k = 0; k < states; ++k) {
    robots::WholeBodyState state;
    const Vec<double, 3> turn(unit(random), unit(random), unit(random));
    state.base.translation() = Vec<double, 3>(unit(random), unit(random), unit(random));
    state.base.linear() =
        Eigen::AngleAxisd(3.0 * unit(random), turn.normalized()).toRotationMatrix();
    for (double& v : state.base_twist) v = unit(random);
    state.q.resize(robot.joints());
    state.dq.resize(robot.joints());
    for (int i = 0; i < robot.joints(); ++i) {
      state.q[i] = 1.5 * unit(random);
      state.dq[i] = 3.0 * unit(random);
    }
    dynamics->update(state);
    const Json line{{"base_position", numbers(state.base.translation())},
                    {"base_rotation", numbers(state.base.linear())},
                    {"base_twist", numbers(state.base_twist)},
                    {"q", numbers(state.q)},
                    {"dq", numbers(state.dq)},
                    {"com", numbers(dynamics->com())},
                    {"com_velocity", numbers(dynamics->com_velocity())},
                    {"angular_momentum", numbers(dynamics->angular_momentum())},
                    {"mass_matrix", numbers(dynamics->mass_matrix())},
                    {"bias", numbers(dynamics->bias())},
                    {"left", sole(dynamics->sole(robots::Side::left))},
                    {"right", sole(dynamics->sole(robots::Side::right))}};
    fmt::print("{}\n", line.dump());
  }
}

}  // namespace
}  // namespace saltus

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  try {
    saltus::print(argv[1], std::atoi(argv[2]), static_cast<unsigned>(std::atoi(argv[3])));
  } catch (const std::exception& error) {
    std::fputs(error.what(), stderr);
    return 1;
  }
  return 0;
}
