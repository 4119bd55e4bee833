// Which figures of a biped does a problem on its centroidal model need?
//
// Read from a small YAML file (robots/icub/icub.yaml shows every key), or taken from the robot's
// URDF, in which case the file contributes only names and joint angles.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/error.hpp"
#include "framework/core/types.hpp"
#include "robots/foot.hpp"
#include "robots/urdf_model.hpp"

namespace saltus {

enum class Stance { left, both };

/// A posture with the left sole flat on the ground. Positions in m, in the contact frame of the
/// left sole: origin in the contact plane, x forward, y to the left, z up.
struct StandingPosture {
  std::string name;
  Stance stance = Stance::both;
  Vec<double, 3> com = Vec<double, 3>::Zero();         // its z is the height above the ground
  Vec<double, 3> right_foot = Vec<double, 3>::Zero();  // origin of the right contact frame
  Posture joints;                                      // rad; joints that are not named are at zero
};

/// A joint with a motor.
struct ActuatedJoint {
  std::string name;
  std::optional<Bounds> position;  ///< rad; not given: that of the URDF
  std::optional<double> effort;    ///< largest torque, Nm; not given: that of the URDF
};

struct RobotDescription {
  std::string name;
  std::string source;                     // where the figures come from, a clause for reports
  double mass = 0.0;                      // kg
  std::string left_sole, right_sole;      // link names
  double contact_plane_offset = 0.0;      // m, of the contact plane along z of the sole links
  FootRectangle left_foot, right_foot;    // in the contact frames
  std::vector<StandingPosture> postures;  // the first is the default
  std::string base;                       // link that floats; for the whole body only
  std::vector<ActuatedJoint> joints;  // likewise, in the order of torques; all others are frozen

  /// Throws InputError that suggests the nearest name.
  const StandingPosture& posture(const std::string& posture_name) const;
  const StandingPosture& default_posture() const { return postures.front(); }
};

/// Throws InputError, one sentence naming file, key and remedy: the file is missing, empty or not
/// YAML; a key is unknown (the nearest known one is suggested), repeated or missing; a value has
/// the wrong type, is not finite or makes no sense.
RobotDescription read_robot_description(const std::filesystem::path& file);
/// The same from text; `source` stands for the file in messages and in `RobotDescription::source`.
RobotDescription parse_robot_description(const std::string& text, const std::string& source);

/// Mass, soles and the CoM of every posture computed from the URDF; `named` contributes the names
/// and the joint angles. Throws InputError when the URDF lacks a sole link or a joint, and when the
/// contact planes of the two feet differ.
RobotDescription describe(const UrdfModel& model, const RobotDescription& named);

}  // namespace saltus
