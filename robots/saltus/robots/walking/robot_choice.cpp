#include "saltus/robots/walking/robot_choice.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "saltus/core/error.hpp"
#include "saltus/robots/icub/icub.hpp"

namespace saltus::robots::walking {

RobotDescription robot_of(const RobotChoice& choice, bool needs_urdf) {
  const auto urdf = urdf_of(choice);
  if (choice.file.empty()) return icub(urdf);
  if (needs_urdf) urdf_of_body(choice);  // throws if there is none
  const RobotDescription::Figures figures =
      urdf ? RobotDescription::Figures::from_urdf : RobotDescription::Figures::in_file;
  const RobotDescription named = read_robot_description(choice.file, figures);
  return urdf ? describe(UrdfModel::read(*urdf), named) : named;
}

std::optional<std::filesystem::path> urdf_of(const RobotChoice& choice) {
  if (!choice.urdf.empty()) return choice.urdf;
  if (!choice.file.empty()) return std::nullopt;
  return find_icub_urdf();
}

std::filesystem::path urdf_of_body(const RobotChoice& choice) {
  const auto urdf = urdf_of(choice);
  if (urdf) return *urdf;
  if (!choice.file.empty())
    throw InputError(fmt::format(
        "the whole-body model of the robot in {} needs a URDF; give it with --robot.urdf FILE",
        choice.file));
  return fetch_icub_urdf([](const std::string& line) { fmt::print(stderr, "{}\n", line); });
}

RobotDescription nominal_robot(const RobotChoice& choice, RobotDescription robot) {
  robot.mass *= 1.0 + choice.mass_error;
  return robot;
}

}  // namespace saltus::robots::walking
