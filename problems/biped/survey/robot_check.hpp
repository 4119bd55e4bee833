// Checks that the description of a robot suffices for standing, pushes and steps.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus::survey {

/// Result of one check.
struct Finding {
  enum class Level { good, note, wrong };
  Level level = Level::good;
  std::string subject;  ///< "masses", "feet", ...
  std::string text;     ///< the finding, and a remedy unless it is good
};

/// Findings on one subject. Adds a good one only if there is no other.
class Subject {
 public:
  /// `findings` must outlive this object.
  Subject(std::vector<Finding>& findings, std::string name)
      : findings_(findings), name_(std::move(name)) {}
  void note(std::string text) { say(Finding::Level::note, std::move(text)); }
  void wrong(std::string text) { say(Finding::Level::wrong, std::move(text)); }
  void good(std::string text) {
    if (is_good_) say(Finding::Level::good, std::move(text));
  }

 private:
  void say(Finding::Level level, std::string text) {
    is_good_ = is_good_ && level == Finding::Level::good;
    findings_.push_back({level, name_, std::move(text)});
  }
  std::vector<Finding>& findings_;
  std::string name_;
  bool is_good_ = true;
};

/// Checks masses, inertias, joint limits, meshes and feet, and what a URDF often has wrong (units,
/// sides, knees, coupled joints; plausibility.hpp). In every posture the CoM must be above
/// the support and limbs apart. The legs must reach the edges of the step region (`forward` and
/// `sideways`, m). Throws InputError only for files that cannot be read.
std::vector<Finding> check_robot(const robots::UrdfModel& model,
                                 const robots::RobotDescription& robot, double forward,
                                 Bounds sideways);

/// One line per finding; `wrong` ones include their remedy.
std::string describe(std::span<const Finding> findings);

}  // namespace saltus::survey
