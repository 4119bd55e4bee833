// A plan, tracked by the whole-body controller on the whole body in DART.
#pragma once

#include <string>
#include <vector>

#include "problems/whole_body/problem.hpp"
#include "problems/whole_body/replanning.hpp"
#include "saltus/core/csv_table.hpp"
#include "saltus/ocp/pulse.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus::whole_body {

/// Differences between plan and simulation.
struct Tracking {
  bool fell = false;          // CoM below 0.6 of its planned height above the feet, or an error
  double fell_at = 0.0;       // s
  double com = 0.0;           // largest distance of the CoM from the plan, m
  double com_at_end = 0.0;    // the same at the end of the run, m
  double feet = 0.0;          // largest distance of a standing sole from its planned place, m
  double slip = 0.0;          // largest motion of a sole while it stands, m
  double torque = 0.0;        // largest fraction of a joint's torque limit that was used
  std::string torque_of;      // and that joint
  double speed = 0.0;         // largest fraction of a joint's speed limit
  std::string speed_of;       // and that joint
  double force = 0.0;         // largest vertical force on a foot, mean of 20 ms, in weights
  double duration = 0.0;      // until the robot stands at the end, s
  CsvTable table{{"t [s]"}};  // the motion, a row every 5 ms
};

/// Options of a simulation.
struct TrackingOptions {
  robots::Plant::Ground ground;
  Pulse push{};                    // force in world axes, N s; begins with the motion
  Frame pushed{};                  // where it acts
  Replanner* replanner = nullptr;  // empty: the first plan is followed to its end
};

/// Runs the plan on ideal drives with ideal sensors, then stands still for one second; a periodic
/// plan runs four times, beginning in motion. The
/// controller is WholeBodyController by inverse dynamics, once per ms.
Tracking track(const Body& body, const robots::FloatingRobot& robot, const Task& task,
               const Solution& plan, const TrackingOptions& options);

}  // namespace saltus::whole_body
