// Plans of the whole body: contacts in a given order, with free durations. problem.cpp has the
// mathematics.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/robots/kinematics/kinematics.hpp"

namespace saltus::whole_body {

inline constexpr int joints = 23;               // iCub without hands, neck and eyes
inline constexpr int coordinates = 6 + joints;  // q of robots::Kinematics
inline constexpr int states = 9 + coordinates;  // (c, v, k, q), without a chosen place
inline constexpr int place_at = 9;              // a chosen place s is between k and q
using Tree = robots::KinematicTree<joints>;
using Frame = robots::FloatingRobot::Frame;

/// A sole on the ground. z of `place` is the normal of the surface.
struct Contact {
  Frame frame;                      // on the robot
  robots::SoleFrame place;          // where it stays, in the world
  robots::FootRectangle rectangle;  // of the sole
  bool chosen = false;              // x and y of the place are those of the state s
};

/// Data of the robot that all phases share.
struct Body {
  explicit Body(const robots::FloatingRobot& robot, const robots::RobotDescription& description);

  Tree tree;
  Frame soles[2];                                // left, right
  robots::FootRectangle feet[2];                 // left, right
  VectorXd lowest, highest, fastest, strongest;  // limits of the joints: rad, rad/s, Nm
  VectorXd nominal;                              // posture that costs nothing, rad
  /// Points with radii on the left and on the right leg; no two of them may come closer.
  struct Sphere {
    int body;
    Vec<double, 3> centre;  // in the body's frame, m
    double radius;          // m
  };
  std::vector<Sphere> legs[2];
};

/// Limits and weights.
struct Options {
  double friction = 0.35, torsion = 0.01;  // friction coefficient; yaw torque over force, m
  double margin = 0.005;                   // of the centre of pressure from the rim of a sole, m
  double speed = 0.7, torque = 0.8;        // used fractions of the joints' limits
  double largest_force = 3.0;              // on a contact, in weights
  // Tolerances between the nodes: m and rad; m^2/s; of the torque limit; m.
  double pose_between = 0.02, spin_between = 0.1, torque_between = 0.1, height_between = 0.005;
  double posture = 2.0, upright = 10.0, rates = 0.1, spin = 20.0;  // weights
  double force = 1.0, moment = 50.0;                               // weights of wrenches
  double place = 5.0, place_rate = 0.05;                           // weights of a chosen place
};

/// A time in which the same soles stand.
struct Mode {
  std::string name;
  std::vector<Contact> contacts;   // at most two
  Bounds duration;                 // s
  double usual;                    // guess of the duration, s
  VectorXd end;                    // guess of q at the end
  std::vector<int> swings{};       // feet in the air: 0 left, 1 right
  double lowest = 0.0;             // of toes and heels in the air throughout, m
  std::optional<double> above{};   // their height at the end, m
  std::optional<double> behind{};  // toes in the air stay behind this x, m
  bool chooses = false;            // s may change: a foot in the air may land elsewhere
};

/// A motion: contacts in their order, and the goal.
struct Task {
  std::string name;
  VectorXd start;  // q at rest or, if periodic, its guess
  std::vector<Mode> modes;
  Vec<double, 2> goal;    // CoM at the end, at rest, m
  bool periodic = false;  // the end is the start, moved by `stride` (m)
  double stride = 0.0;
  /// A place that the plan chooses: the expected one, and bounds of x and y, m.
  struct Choice {
    Vec<double, 2> expected{0.0, 0.0};
    Bounds x, y;
  };
  std::optional<Choice> choice{};

  int size() const { return states + (choice ? 2 : 0); }  // of the state
};

/// The task as an optimal control problem. Refers to `body`.
OptimalControlProblem problem(const Body& body, const Task& task, const Options& options);

}  // namespace saltus::whole_body
