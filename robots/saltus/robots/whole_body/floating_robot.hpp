// Rigid-body tree for simulators and whole-body controllers: a free base and the joints that have
// motors. All other joints of the URDF are frozen, links that move together are merged into one
// body, and massless frames are removed. This file also defines its collision capsules and the
// interface to its equations of motion.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"
#include "saltus/robots/whole_body/robot.hpp"

namespace saltus::robots {

/// A robot with a floating base.
struct FloatingRobot {
  /// Appearance of a link, in the frame of its body.
  struct Look {
    std::string link;                           ///< name of the link
    std::vector<UrdfModel::LinkShape> visuals;  ///< visual shapes
    std::vector<UrdfModel::Box> boxes;  ///< boxes to draw without them: collision boxes, or one
                                        ///< with the inertia of the link
  };
  /// A rigid body and the joint to its parent.
  struct Body {
    std::string name;           ///< name of the link that leads the group
    int parent = -1;            ///< index of the parent; -1 for the base
    std::string joint;          ///< joint to the parent; empty for the base
    Eigen::Isometry3d origin =  ///< joint frame in the parent's frame, at position zero
        Eigen::Isometry3d::Identity();
    Vec<double, 3> axis = Vec<double, 3>::UnitX();  ///< axis of the joint, in the joint frame
    Bounds position;                                ///< rad
    double effort = infinity;                       ///< largest torque, Nm
    double velocity = infinity;                     ///< largest speed, rad/s
    JointDrive drive;                               ///< motor and reducer
    double mass = 0.0;                              ///< kg
    Vec<double, 3> com = Vec<double, 3>::Zero();    ///< in the body's frame, m
    Mat<double, 3, 3> inertia = Mat<double, 3, 3>::Zero();  ///< about the CoM, kg m^2
    std::vector<UrdfModel::Box> boxes;  ///< collision boxes, in the body's frame
    std::vector<Look> looks;            ///< appearance of the links with visual shapes
    std::vector<RobotDescription::LinkCapsule> capsules;  ///< capsules around the links, in the
                                                          ///< body's frame; see add_capsules
  };
  /// A frame fixed to a body.
  struct Frame {
    int body = 0;                                            ///< index in FloatingRobot::bodies
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in the body's frame
  };

  std::string name;    ///< name of the robot
  std::string source;  ///< file of the URDF
  /// The base first, every parent before its children: the order of UrdfModel::links().
  std::vector<Body> bodies;
  Frame left_sole, right_sole;  ///< contact frames: origin in the contact plane
  double total_mass = 0.0;      ///< kg
  /// Pairs of bodies whose capsules must not touch: all but neighbours. The smaller index comes
  /// first.
  std::vector<std::pair<int, int>> apart;

  /// Number of moving joints.
  int joints() const { return static_cast<int>(bodies.size()) - 1; }
  /// Index i of the joint that leads to bodies[i + 1]: its place in all vectors of positions,
  /// velocities and torques. Throws InputError that suggests the nearest name.
  int joint_index(const std::string& joint) const;
  /// Index of the body of this name. Throws InputError that suggests the nearest name.
  int body_index(const std::string& body) const;
  /// Joint positions in the order of bodies, rad; zero for joints that the posture does not name.
  VectorXd joint_positions(const Posture& posture) const;
};

/// Keeps the joints that `robot` lists as actuated and freezes all others at zero. A foot without a
/// collision box receives a thin box on the rectangle in `robot`. Throws InputError, naming the
/// robot's file and the joint, if `robot` names no base or joints, if a joint is missing from the
/// URDF, cannot move or follows another one (<mimic>), or if the base link does not belong to the
/// group of the root link.
FloatingRobot floating_robot(const UrdfModel& model, const RobotDescription& robot);

/// The frame of any link of the URDF, fixed to the body that it moves with. Throws InputError that
/// suggests the nearest name.
FloatingRobot::Frame link_frame(const FloatingRobot& robot, const UrdfModel& model,
                                const std::string& link);

/// Box of uniform density with the mass (> 0), centre of mass and inertia of the link, in the
/// link's frame. It is scaled down if its density would be lower than that of any robot.
UrdfModel::Box box_of_inertia(const UrdfModel::Link& link);

/// The same robot with all masses and inertias times `factor` > 0, to represent the error of a
/// model.
FloatingRobot with_masses_scaled(FloatingRobot robot, double factor);

/// The same robot with its centre of mass moved by `shift` (m, axes of the base): the centre of
/// mass of the base moves. This represents the error of a model.
FloatingRobot with_com_shifted(FloatingRobot robot, const Vec<double, 3>& shift);

/// Returns the robot with the figures of all drives multiplied by these factors. Throws InputError
/// if drives are requested and the robot has no figures of them.
FloatingRobot with_drives_scaled(FloatingRobot robot, const DriveFactors& factors);

/// State at rest in the posture, with the contact frame of its stance sole (the left one for a
/// posture on both feet) at the origin of the world. Throws InputError, naming the first joint that
/// is outside its limits.
WholeBodyState standing_state(const FloatingRobot& robot, const UrdfModel& model,
                              const RobotDescription& description, const StandingPosture& posture);

/// Sets the capsules of the bodies and the pairs that must stay apart.
///
/// Capsules come from `description`. Without it they are fitted to the visual shapes of each link
/// (reading its meshes takes about half a second for iCub), else to its collision shapes, else to
/// the box of its inertia. All pairs must stay apart, except a body and its parent, and bodies at
/// most four joints apart that are nearer than 1 cm at rest (every joint at zero, or at the limit
/// nearest to it). Throws InputError for a mesh that cannot be read, and for a capsule on an
/// unknown link.
void add_capsules(FloatingRobot& robot, const UrdfModel& model,
                  const RobotDescription& description);

/// Throws InputError, naming the pair with the deepest overlap, if capsules that must stay apart
/// overlap in `state`.
void expect_apart(const FloatingRobot& robot, const WholeBodyState& state,
                  const std::string& posture);

/// Equations of motion M dnu/dt + h = (0 | tau) + sum_i J_i' w_i. Here nu = (base twist | dq), with
/// the base twist as in WholeBodyState but in the base's own axes. w_i = (torque about the contact
/// frame's origin | force), world axes. All quantities belong to the state of the last update(),
/// which does not allocate.
class DynamicsModel {
 public:
  /// Motion of a sole. With nu of DynamicsModel, twist = J nu and d twist / dt = J dnu/dt + drift.
  /// Twists are (angular | linear of the contact frame's origin), world axes.
  struct SoleMotion {
    Eigen::Isometry3d pose;  ///< pose of the contact frame in the world
    Vec<double, 6> twist;    ///< (angular rad/s | linear m/s of its origin), world axes
    MatrixXd jacobian;       ///< 6 x (6 + n)
    Vec<double, 6> drift;    ///< (dJ/dt) nu
  };

  virtual ~DynamicsModel() = default;
  /// Computes all quantities at this state.
  virtual void update(const WholeBodyState& state) = 0;

  /// Number of joints.
  virtual int joints() const = 0;
  /// Mass of the whole robot, kg.
  virtual double mass() const = 0;
  const MatrixXd& mass_matrix() const { return mass_matrix_; }  ///< (6 + n) x (6 + n)
  const VectorXd& bias() const { return bias_; }  ///< h: gravity, Coriolis, centrifugal; 6 + n
  /// Motion of the sole on the given side.
  const SoleMotion& sole(Side side) const { return side == Side::left ? left_ : right_; }
  const Vec<double, 3>& com() const { return com_; }                    ///< m
  const Vec<double, 3>& com_velocity() const { return com_velocity_; }  ///< m/s
  const Vec<double, 3>& angular_momentum() const { return momentum_; }  ///< about the CoM, Nms

 protected:
  MatrixXd mass_matrix_;                          ///< (6 + joints) square
  VectorXd bias_;                                 ///< gravity and velocity terms, 6 + joints
  SoleMotion left_, right_;                       ///< motion of both soles
  Vec<double, 3> com_, com_velocity_, momentum_;  ///< m, m/s, Nms about the CoM
};

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using FloatingRobot [[deprecated("use robots::FloatingRobot; removed in 0.4")]] =
    robots::FloatingRobot;
/// Deprecated name.
using DynamicsModel [[deprecated("use robots::DynamicsModel; removed in 0.4")]] =
    robots::DynamicsModel;
/// Deprecated name.
using SoleMotion [[deprecated("use robots::DynamicsModel::SoleMotion; removed in 0.4")]] =
    robots::DynamicsModel::SoleMotion;
using robots::floating_robot;      ///< deprecated name
using robots::link_frame;          ///< deprecated name
using robots::standing_state;      ///< deprecated name
using robots::with_masses_scaled;  ///< deprecated name
}  // namespace saltus
