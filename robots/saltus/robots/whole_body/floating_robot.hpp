// The robot as simulators and whole-body controllers see it: a free base, the joints that have
// motors, and nothing else. Every other joint of the URDF is frozen, links that move together are
// one body, massless frames are gone.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/urdf_model.hpp"
#include "saltus/robots/whole_body/whole_body_state.hpp"

namespace saltus {

/// A robot with a floating base, as controllers need it.
struct FloatingRobot {
  /// What a link looks like, in the frame of its body.
  struct Look {
    std::string link;                ///< that is drawn
    std::vector<UrdfShape> visuals;  ///< its shapes
    std::vector<UrdfBox> boxes;      ///< in their place: collision boxes, or one with its inertia
  };
  /// One rigid body and the joint that carries it.
  struct Body {
    std::string name;           ///< of the link that leads the group
    int parent = -1;            ///< -1: the base
    std::string joint;          ///< to the parent; empty for the base
    Eigen::Isometry3d origin =  ///< joint frame in the parent's frame, position zero
        Eigen::Isometry3d::Identity();
    Vec<double, 3> axis = Vec<double, 3>::UnitX();          ///< of the joint, in the joint frame
    Bounds position;                                        ///< rad
    double effort = infinity;                               ///< largest torque, Nm
    double velocity = infinity;                             ///< largest speed, rad/s
    double mass = 0.0;                                      ///< kg
    Vec<double, 3> com = Vec<double, 3>::Zero();            ///< in the body's frame, m
    Mat<double, 3, 3> inertia = Mat<double, 3, 3>::Zero();  ///< about the CoM, kg m^2
    std::vector<UrdfBox> boxes;         ///< collision boxes, in the body's frame
    std::vector<Look> looks;            ///< of its links that the URDF shows
    std::vector<LinkCapsule> capsules;  ///< what fills them, in the body's frame; see add_capsules
  };
  /// A frame fixed to a body.
  struct Frame {
    int body = 0;                                            ///< of FloatingRobot::bodies
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in the body's frame
  };

  std::string name;             ///< of the robot
  std::string source;           ///< file of the URDF
  std::vector<Body> bodies;     ///< the base first, every parent before its children
  Frame left_sole, right_sole;  ///< contact frames: origin in the contact plane
  double total_mass = 0.0;      ///< kg
  /// Bodies whose capsules must not touch: all pairs but neighbours. The first is the smaller.
  std::vector<std::pair<int, int>> apart;

  /// How many move.
  int joints() const { return static_cast<int>(bodies.size()) - 1; }
  /// Index of the joint that leads to bodies[i + 1]. Throws InputError that suggests the nearest.
  int joint_index(const std::string& joint) const;
  /// Index of the body that carries this link's name. Throws InputError that suggests the nearest.
  int body_index(const std::string& body) const;
  /// One number per joint, in the order of bodies; zero where the posture names none.
  VectorXd joint_positions(const Posture& posture) const;
};

/// Keeps the joints that `robot` lists as actuated and freezes all others at zero. A foot without
/// collision box gets a thin one, the rectangle in `robot`. Throws InputError, naming the robot's
/// file and the joint, when `robot` names no base or joints, a joint is missing from the URDF or
/// cannot move, or the base link is not its root's group.
FloatingRobot floating_robot(const UrdfModel& model, const RobotDescription& robot);

/// The frame of any link of the URDF, fixed to the body that it moves with. Throws InputError that
/// suggests the nearest name.
FloatingRobot::Frame link_frame(const FloatingRobot& robot, const UrdfModel& model,
                                const std::string& link);

/// The box of even density that has the link's mass > 0, centre of mass and inertia, in the link's
/// frame; a smaller one of that form where it would be lighter than any robot.
UrdfBox box_of_inertia(const UrdfLink& link);

/// The same robot with all masses and inertias times `factor` > 0: what a model that errs says of
/// it.
FloatingRobot with_masses_scaled(FloatingRobot robot, double factor);

/// At rest in the posture, the contact frame of its stance sole (of both: the left one) at the
/// origin of the world. Throws InputError, naming the first joint that the posture puts outside its
/// limits.
WholeBodyState standing_state(const FloatingRobot& robot, const UrdfModel& model,
                              const RobotDescription& description, const StandingPosture& posture);

}  // namespace saltus
