// A recorded run: per line the readings of a robot, whether its swing foot has landed, and the
// torques that the controller has computed.
#pragma once

#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "saltus/robots/whole_body/robot.hpp"

namespace saltus {

struct RecordedLine {
  robots::Robot::Readings readings;
  bool has_landed = false;
  VectorXd torques;  // Nm
};

/// One line of the file. Nine digits: errors of 1e-9 of each number.
inline std::string to_csv(const RecordedLine& line) {
  const robots::Robot::Readings& r = line.readings;
  std::string text = fmt::format("{:.9g},{:d},{:d}", r.time, r.has_new_positions, line.has_landed);
  const auto add = [&text](const auto& numbers) {
    for (const double x : numbers) text += fmt::format(",{:.9g}", x);
  };
  add(r.q);
  add(r.angular_velocity);
  add(r.specific_force);
  add(r.left);
  add(r.right);
  add(line.torques);
  return text + "\n";
}

/// Reads the file of a robot with this number of joints.
inline std::vector<RecordedLine> read_recorded_run(const std::string& file, int joints) {
  std::ifstream in(file);
  std::vector<RecordedLine> lines;
  for (std::string text; std::getline(in, text);) {
    std::istringstream words(text);
    const auto next = [&words] {
      std::string word;
      std::getline(words, word, ',');
      return std::stod(word);
    };
    RecordedLine line;
    robots::Robot::Readings& r = line.readings;
    r.q = line.torques = VectorXd::Zero(joints);
    r.time = next();
    r.has_new_positions = next() != 0.0;
    line.has_landed = next() != 0.0;
    const auto fill = [&next](auto& numbers) {
      for (double& x : numbers) x = next();
    };
    fill(r.q);
    fill(r.angular_velocity);
    fill(r.specific_force);
    fill(r.left);
    fill(r.right);
    fill(line.torques);
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace saltus
