// What a run on the whole body leaves behind: a table of its motion and forces, the robot's shape
// for the replay, and the figures that only a body has.
//
// Wrenches are (force N | torque Nm about the origin of the contact frame) in the axes of their
// sole, planned and measured alike; poses are in the world, quaternions (w, x, y, z).
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "saltus/app/program.hpp"
#include "saltus/robots/walking/body_forces.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::walking {

/// body.csv, one line per control period, units in the names ("q_JOINT [rad]"): t; base_{x..z,
/// qw..qz}; q_JOINT (rad); tau_JOINT (Nm);
/// for both feet FOOT_planned_*, FOOT_measured_*, FOOT_filtered_* (fx fy fz tx ty tz),
/// FOOT_sole_{x..z, qw..qz}, FOOT_slip (m, see `sole_slip`) and FOOT_friction (see
/// `friction_used`). Throws DefinitionError unless there
/// is one body sample per sample and the robot has as many joints as they.
CsvTable body_table(const RunLog& log, const FloatingRobot& robot);

/// robot.json: the bodies (parent, joint, origin, axis, limits, mass, CoM, boxes; per link its
/// visuals as the URDF has them, and boxes in their place), the contact frames, the rectangles of
/// the feet, and where the URDF lies. Lengths in m, limits null where there is none.
nlohmann::ordered_json robot_shape(const FloatingRobot& robot, const RunLog& log);

/// Peaks of the forces (measured over the filter), largest slips, largest fraction of a torque
/// limit and its joint, processor time per simulated second and part, unsolved control steps.
nlohmann::ordered_json body_figures(const RunLog& log, const FloatingRobot& robot);

/// Writes body.csv and robot.json.
void write_body(const OutputFolder& output, const RunLog& log, const FloatingRobot& robot);

}  // namespace saltus::walking
