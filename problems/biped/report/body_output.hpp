// Output of a whole-body run: a table of motion and forces, the shape of the robot for the replay,
// and the body section of the summary.
//
// Planned and measured wrenches are (force N | torque Nm about the origin of the contact frame) in
// the axes of their sole. Poses are in the world, quaternions (w, x, y, z).
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "saltus/app/program.hpp"
#include "saltus/robots/walking/body_forces.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots::walking {

/// body.csv, one line per control period, units in the names ("q_JOINT [rad]"): t; base_{x..z,
/// qw..qz}; q_JOINT (rad); tau_JOINT (Nm); for both feet FOOT_planned_*, FOOT_measured_*,
/// FOOT_filtered_* (fx fy fz tx ty tz), FOOT_sole_{x..z, qw..qz}, FOOT_slip (m, see `sole_slip`)
/// and FOOT_friction (see `friction_used`). Throws DefinitionError unless there is one body sample
/// per sample, with the joints of the robot.
CsvTable body_table(const RunLog& log, const FloatingRobot& robot);

/// robot.json of a robot with these rectangles of its feet: the bodies (parent, joint, origin,
/// axis, limits, mass, CoM, boxes; for each link the visuals of the URDF, and boxes to draw without
/// them), the contact frames, the rectangles of the feet, and the path of the URDF. Lengths in m;
/// missing limits are null.
nlohmann::ordered_json robot_shape(const FloatingRobot& robot, const FootRectangle& left,
                                   const FootRectangle& right);

/// Peak forces (filtered), largest slips, largest fraction of a torque limit with its joint,
/// processor time of each part per simulated second, and number of unsolved control steps.
nlohmann::ordered_json body_figures(const RunLog& log, const FloatingRobot& robot);

/// Writes body.csv and robot.json.
void write_body(const OutputFolder& output, const RunLog& log, const FloatingRobot& robot);

}  // namespace saltus::robots::walking
