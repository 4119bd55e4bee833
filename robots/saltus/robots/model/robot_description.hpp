// Description of a biped: the data that a problem with the centroidal model needs.
//
// Read from a small YAML file (robots/README.md lists the keys, robots/icub/icub.yaml shows all of
// them), or computed from the URDF of the robot. In the second case the file contributes only names
// and joint angles.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/types.hpp"
#include "saltus/robots/model/foot.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus::robots {

/// Feet that carry the robot.
enum class Stance { left, right, both };

/// A posture with one sole flat on the ground: the sole of the stance foot, or the left one if both
/// feet carry the robot. Positions in m, in the contact frame of that foot: origin in the contact
/// plane, x forward, y to the left, z up.
struct StandingPosture {
  std::string name;                                    ///< name in the file
  Stance stance = Stance::both;                        ///< feet that carry the robot
  Vec<double, 3> com = Vec<double, 3>::Zero();         // its z is the height above the ground
  Vec<double, 3> other_foot = Vec<double, 3>::Zero();  // origin of the other contact frame
  Posture joints;                                      // rad; joints that are not named are at zero

  /// The foot whose sole is flat on the ground.
  Side side() const { return stance == Stance::right ? Side::right : Side::left; }
};

/// All points whose distance from a segment is at most `radius`.
struct Capsule {
  Vec<double, 3> from = Vec<double, 3>::Zero(), to = Vec<double, 3>::Zero();  ///< m; may be equal
  double radius = 0.0;                                                        ///< m

  /// Midpoint of the segment, m.
  Vec<double, 3> middle() const { return 0.5 * (from + to); }
  double length() const { return (to - from).norm(); }  ///< length of the segment, m
  double volume() const;                                ///< m^3
};

/// Motor and reducer of a joint. The default is an ideal drive.
struct JointDrive {
  /// Inertia of rotor and reducer times the square of the transmission ratio, kg m^2. It resists
  /// the acceleration of the joint, not that of its parent.
  double rotor_inertia = 0.0;
  double viscous_friction = 0.0;  ///< Nm s/rad
  /// Coulomb friction of the moving joint, Nm. At rest the friction is larger by `breakaway`.
  double dry_friction = 0.0;
  /// Friction at rest divided by `dry_friction`, at least 1. It falls to 1 with exp(-(dq / s)^2),
  /// s = `stribeck_speed` (Stribeck's effect).
  double breakaway = 1.0;
  double stribeck_speed = 0.05;    ///< rad/s, positive
  double stall_torque = infinity;  ///< largest torque of the motor at rest, Nm
  /// Speed at which the driving torque vanishes, rad/s. The largest torque falls linearly from its
  /// value at rest.
  double no_load_speed = infinity;
  double stiffness = infinity;  ///< spring between reducer and joint, Nm/rad; infinity: rigid
  double backlash = 0.0;        ///< play between reducer and joint, from end to end, rad

  /// True if the drive has no inertia, no friction and no limits.
  bool is_ideal() const {
    return rotor_inertia == 0.0 && viscous_friction == 0.0 && dry_friction == 0.0 &&
           stall_torque == infinity && no_load_speed == infinity;
  }
  /// Friction of the moving joint at the speed `dq` (rad/s), smooth about zero, Nm.
  double friction(double dq) const {
    return viscous_friction * dq + dry_friction * std::tanh(dq / stribeck_speed);
  }
  /// Range of the motor's torque at the speed `dq` (rad/s), Nm, for the effort limit (Nm).
  Bounds torque_range(double effort, double dq) const {
    const double at_rest = std::min(effort, stall_torque), lost = dq / no_load_speed;
    return {-at_rest * (lost < 0.0 ? (lost > -1.0 ? 1.0 + lost : 0.0) : 1.0),
            at_rest * (lost > 0.0 ? (lost < 1.0 ? 1.0 - lost : 0.0) : 1.0)};
  }
};

/// Parts of a drive that apply: factors of its figures.
struct DriveFactors {
  double rotor_inertia = 0.0;      ///< factor of the rotor inertia; 0: none
  double friction = 0.0;           ///< factor of dry and viscous friction; 0: none
  bool torque_speed_line = false;  ///< true: stall torque and no-load speed limit the torque
  double elasticity = 0.0;         ///< factor of the compliance, 1 / stiffness; 0: rigid
  double backlash = 0.0;           ///< factor of the backlash; 0: none

  /// True if nothing applies.
  bool is_ideal() const {
    return rotor_inertia == 0.0 && friction == 0.0 && !torque_speed_line && elasticity == 0.0 &&
           backlash == 0.0;
  }
  /// The drive with these factors.
  JointDrive operator()(JointDrive drive) const {
    drive.rotor_inertia *= rotor_inertia;
    drive.viscous_friction *= friction;
    drive.dry_friction *= friction;
    if (!torque_speed_line) drive.stall_torque = drive.no_load_speed = infinity;
    drive.stiffness = elasticity > 0.0 ? drive.stiffness / elasticity : infinity;
    drive.backlash *= backlash;
    return drive;
  }
};

/// Data of a robot from its description file and its URDF.
struct RobotDescription {
  /// A capsule fixed to a link, in the link's frame.
  struct LinkCapsule {
    std::string link;  ///< name of the link
    Capsule capsule;   ///< shape, in the link frame
  };

  /// Mirror image of joints in the plane between the feet. Joints of the left and right side swap
  /// their positions, and some joints change sign.
  struct Mirror {
    std::string left, right;            // words in joint names that mark the side
    std::vector<std::string> reversed;  // joints that change sign; both joints of a pair are listed

    /// Name of the mirrored joint: `left` is replaced by `right` and vice versa. The word is
    /// replaced at the beginning of the name, else at the end if it begins with a separator such as
    /// "_", else (for words of more than two letters) at its first occurrence. Returns the name
    /// itself if it contains neither word.
    std::string namesake(const std::string& joint) const;
    /// Mirrors a posture on one foot to the other foot.
    StandingPosture operator()(const StandingPosture& posture) const;
  };

  /// A joint with a motor.
  struct Joint {
    std::string name;                ///< name in the URDF
    std::optional<Bounds> position;  ///< rad; default: the limits of the URDF
    std::optional<double> effort;    ///< largest torque, Nm; default: the limit of the URDF
    std::optional<double> velocity;  ///< largest speed, rad/s; default: the limit of the URDF
    JointDrive drive;                ///< motor and reducer; default: ideal
  };

  /// Origin of mass, feet and the positions of CoM and foot. `in_file`: the file must give them.
  /// `from_urdf`: values that the file does not give are NaN until `describe` computes them.
  enum class Figures { in_file, from_urdf };

  std::string name;                   // name of the robot
  std::string source;                 // origin of the data, a clause for reports
  std::string file;                   // file that names links, joints and postures, for messages
  double mass = 0.0;                  // kg
  std::string left_sole, right_sole;  // link names
  double contact_plane_offset = 0.0;  // position of the contact plane along z of the sole links, m
  FootRectangle left_foot, right_foot;    // in the contact frames
  std::optional<Mirror> mirror;           // for postures that are mirror images of others
  std::vector<StandingPosture> postures;  // the first is the default
  std::string base;                       // floating link; for the whole body only
  /// For the whole body only, in the order of the file; all others are frozen. Positions and
  /// torques have another order, see FloatingRobot::joint_index().
  std::vector<Joint> joints;
  /// For the whole body only: largest force (x, y, z, N) and torque (x, y, z, Nm) that the sensors
  /// of the feet measure; each must be positive
  std::optional<Vec<double, 6>> foot_sensor_range;
  /// For the whole body only: shapes that replace those fitted to the meshes
  std::vector<LinkCapsule> capsules;
  std::vector<std::string> warnings;  // assumptions that were made, sentences for the user

  /// Rectangle of the foot on the given side.
  const FootRectangle& foot(Side side) const { return side == Side::left ? left_foot : right_foot; }
  /// Name of the sole link on the given side.
  const std::string& sole(Side side) const { return side == Side::left ? left_sole : right_sole; }

  /// The posture of this name. Throws InputError that suggests the nearest name.
  const StandingPosture& posture(const std::string& posture_name) const;
  /// The first posture. Throws DefinitionError if there is none.
  const StandingPosture& default_posture() const;
  /// The first posture on this foot alone. Throws InputError if there is none.
  const StandingPosture& posture_on(Side side) const;
};

/// Throws InputError, one sentence naming file, key and remedy: the file is missing, empty or not
/// YAML; a key is unknown (the nearest known one is suggested), repeated or missing; a value has
/// the wrong type, is not finite or makes no sense.
RobotDescription read_robot_description(
    const std::filesystem::path& file,
    RobotDescription::Figures figures = RobotDescription::Figures::in_file);
/// Like read_robot_description(), from text. `source` names the file in messages and in
/// `RobotDescription::source`.
RobotDescription parse_robot_description(
    const std::string& text, const std::string& source,
    RobotDescription::Figures figures = RobotDescription::Figures::in_file);

/// Computes mass, soles and the CoM of every posture from the URDF. `named` contributes the names
/// and joint angles. It also contributes the rectangles of feet without collision box, with a
/// warning. Throws InputError if the URDF lacks a sole link or a joint, if the contact planes of
/// the two feet differ, or if neither file describes the feet.
RobotDescription describe(const UrdfModel& model, const RobotDescription& named);

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using Stance [[deprecated("use robots::Stance; removed in 0.4")]] = robots::Stance;
/// Deprecated name.
using StandingPosture [[deprecated("use robots::StandingPosture; removed in 0.4")]] =
    robots::StandingPosture;
/// Deprecated name.
using RobotDescription [[deprecated("use robots::RobotDescription; removed in 0.4")]] =
    robots::RobotDescription;
/// Deprecated name.
using Mirror [[deprecated("use robots::RobotDescription::Mirror; removed in 0.4")]] =
    robots::RobotDescription::Mirror;
/// Deprecated name.
using ActuatedJoint [[deprecated("use robots::RobotDescription::Joint; removed in 0.4")]] =
    robots::RobotDescription::Joint;
/// Deprecated name.
using Figures [[deprecated("use robots::RobotDescription::Figures; removed in 0.4")]] =
    robots::RobotDescription::Figures;
using robots::describe;                 ///< deprecated name
using robots::parse_robot_description;  ///< deprecated name
using robots::read_robot_description;   ///< deprecated name
}  // namespace saltus
