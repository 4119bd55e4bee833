// A plan, tracked by the whole-body controller on the whole body in DART.
#pragma once

#include <span>
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
  bool fell = false;           // CoM below 0.3 m above the feet or 0.2 m from the plan, or an error
  double fell_at = 0.0;        // s
  double com = 0.0;            // largest distance of the CoM from the plan, m
  double com_at_end = 0.0;     // the same at the end of the run, m
  double feet = 0.0;           // largest distance of a standing sole from its planned place, m
  double slip = 0.0;           // largest motion of a sole while it stands, m
  double torque = 0.0;         // largest fraction of a joint's torque limit that was used
  std::string torque_of;       // and that joint
  double speed = 0.0;          // largest fraction of a joint's speed limit
  std::string speed_of;        // and that joint
  double force = 0.0;          // largest vertical force on a foot, mean of 20 ms, in weights
  double duration = 0.0;       // of the motion, s
  int motion = 0;              // index of the motion
  std::vector<double> begins;  // of the modes after the first, s
  CsvTable table{{"t [s]"}};   // the motion, a row every 5 ms
};

/// A motion with its plan.
struct PlannedTask {
  const Task* task;
  const Trajectory* plan;
  Replanner* replanner = nullptr;  // null: the plan is not updated
};

/// Options of a simulation.
struct TrackingOptions {
  robots::Plant::Ground ground;
  Pulse push{};    // force in world axes, N s
  Frame pushed{};  // where it acts
  /// True: the robot stands until a push moves the capture point by 3 cm. Then it starts the motion
  /// whose chosen place is nearest to the capture point.
  bool waits = false;
};

/// Runs the plan on ideal drives with ideal sensors, then stands still for one second; a periodic
/// plan runs four times, beginning in motion. The controller is WholeBodyController by inverse
/// dynamics, once per ms. `motions`: one motion, or several that the robot can start after
/// waiting. Throws DefinitionError without a motion.
Tracking track(const Body& body, const robots::FloatingRobot& robot,
               std::span<const PlannedTask> motions, const TrackingOptions& options);

}  // namespace saltus::whole_body
