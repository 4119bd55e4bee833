// Which figures of a biped does a problem on its centroidal model need?
//
// Read from a small YAML file (robots/README.md lists the keys, robots/icub/icub.yaml shows every
// one), or taken from the robot's URDF, in which case the file contributes only names and joint
// angles.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/types.hpp"
#include "saltus/robots/model/capsule.hpp"
#include "saltus/robots/model/foot.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus {

/// On which feet.
enum class Stance { left, right, both };

/// A posture with one sole flat on the ground: that of the stance foot, the left one if both stand.
/// Positions in m, in its contact frame: origin in the contact plane, x forward, y to the left, z
/// up.
struct StandingPosture {
  std::string name;                                    ///< as in the file
  Stance stance = Stance::both;                        ///< on which feet
  Vec<double, 3> com = Vec<double, 3>::Zero();         // its z is the height above the ground
  Vec<double, 3> other_foot = Vec<double, 3>::Zero();  // origin of the other contact frame
  Posture joints;                                      // rad; joints that are not named are at zero

  /// The foot whose sole is flat on the ground.
  Side side() const { return stance == Stance::right ? Side::right : Side::left; }
};

/// What the mirror image in the plane between the feet makes of the joints: those of left and right
/// change places with their namesakes, and some change sign.
struct Mirror {
  std::string left, right;            // what tells them apart
  std::vector<std::string> reversed;  // joints that change sign; of a pair both

  /// With one word in place of the other: at the beginning of the name, else (words of more than
  /// two letters) where it first stands. The name itself if it has neither.
  std::string namesake(const std::string& joint) const;
  /// Of a posture on one foot, on the other one.
  StandingPosture operator()(const StandingPosture& posture) const;
};

/// A joint with a motor.
struct ActuatedJoint {
  std::string name;                ///< as in the URDF
  std::optional<Bounds> position;  ///< rad; not given: that of the URDF
  std::optional<double> effort;    ///< largest torque, Nm; not given: that of the URDF
  std::optional<double> velocity;  ///< largest speed, rad/s; not given: that of the URDF
};

/// What of a robot is told by its files.
struct RobotDescription {
  std::string name;                       // of the robot
  std::string source;                     // where the figures come from, a clause for reports
  std::string file;                       // that names links, joints and postures, for messages
  double mass = 0.0;                      // kg
  std::string left_sole, right_sole;      // link names
  double contact_plane_offset = 0.0;      // m, of the contact plane along z of the sole links
  FootRectangle left_foot, right_foot;    // in the contact frames
  std::optional<Mirror> mirror;           // for postures that are the image of another
  std::vector<StandingPosture> postures;  // the first is the default
  std::string base;                       // link that floats; for the whole body only
  std::vector<ActuatedJoint> joints;  // likewise, in the order of torques; all others are frozen
  std::vector<LinkCapsule> capsules;  // likewise: shapes in place of those fitted to the meshes
  std::vector<std::string> warnings;  // what was assumed, sentences for the user

  /// By its side.
  const FootRectangle& foot(Side side) const { return side == Side::left ? left_foot : right_foot; }
  /// By its side.
  const std::string& sole(Side side) const { return side == Side::left ? left_sole : right_sole; }

  /// Throws InputError that suggests the nearest name.
  const StandingPosture& posture(const std::string& posture_name) const;
  /// The first one. Throws DefinitionError if there is none.
  const StandingPosture& default_posture() const;
  /// The first that stands on this foot alone. Throws InputError if there is none.
  const StandingPosture& posture_on(Side side) const;
};

/// Where mass, feet and the places of CoM and foot come from: the file must give them, or those
/// that it does not give are NaN until `describe` computes them from the URDF.
enum class Figures { in_file, from_urdf };

/// Throws InputError, one sentence naming file, key and remedy: the file is missing, empty or not
/// YAML; a key is unknown (the nearest known one is suggested), repeated or missing; a value has
/// the wrong type, is not finite or makes no sense.
RobotDescription read_robot_description(const std::filesystem::path& file,
                                        Figures figures = Figures::in_file);
/// The same from text; `source` stands for the file in messages and in `RobotDescription::source`.
RobotDescription parse_robot_description(const std::string& text, const std::string& source,
                                         Figures figures = Figures::in_file);

/// Mass, soles and the CoM of every posture computed from the URDF; `named` contributes the names
/// and the joint angles, and the rectangles of feet that have no collision box, with a warning.
/// Throws InputError when the URDF lacks a sole link or a joint, when the contact planes of the two
/// feet differ, and when neither file says what the feet are.
RobotDescription describe(const UrdfModel& model, const RobotDescription& named);

}  // namespace saltus
