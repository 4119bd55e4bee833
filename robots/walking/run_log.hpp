// What a closed loop leaves behind: states, commands, ticks of the planner, and what the body did.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_plan.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::walking {

/// State and command at one instant of the simulation.
struct Sample {
  double time = 0.0;  ///< s
  Vec<double, 9> gamma;
  Vec<double, 2> capture_point;
  /// Applied from this instant on, left and right, sole axes; on the whole body those that its
  /// controller expects (what is measured stands in BodySample).
  Vec<double, 12> wrenches;
  Vec<double, 3> push;  ///< N
  bool left_stands = true, right_stands = true;
  bool two_feet() const { return left_stands && right_stands; }
};

/// One foot that stepped.
struct StepRecord {
  Side foot = Side::right;
  double lift_off = 0.0;        ///< s; of a foot that was in the air already: when it was decided
  double due = infinity;        ///< landing as planned last, s
  double touchdown = infinity;  ///< infinite: not yet, when the run ended, s
  Vec<double, 3> place = Vec<double, 3>::Zero();      ///< planned last, m
  Vec<double, 3> landed_at = Vec<double, 3>::Zero();  ///< really, m
};

/// What the planner of steps said in one tick.
struct PlanRecord {
  double time = 0.0;  ///< s
  StepPlan plan;
  double seconds = 0.0;  ///< processor time that it took
};

/// One call of the planner.
struct TickRecord {
  double time = 0.0;
  Provenance provenance = Provenance::fallback;
  SolveStatus status = SolveStatus::invalid_problem;
  std::string message;
  double seconds = 0.0;
  int iterations = 0;
  double cost = 0.0;
  double kkt = 0.0;
  double violation = 0.0;  ///< of what carries a penalty: the largest in the plan
};

/// What the controllers took for true at that instant.
struct BodyEstimate {
  WholeBodyState state;
  Vec<double, 9> gamma;
  Vec<double, 3> stance_sole;  ///< origin of its contact frame, m
  Side stance = Side::left;    ///< the foot that is meant: steps change it
};

/// What the whole body does at the instant of the sample with the same index.
struct BodySample {
  WholeBodyState state;
  VectorXd torques;                         ///< Nm
  Vec<double, 12> planned;                  ///< wrenches of the plan, left and right, sole axes
  Vec<double, 6> left, right;               ///< measured (force | torque), world axes
  Eigen::Isometry3d left_sole, right_sole;  ///< contact frames
  std::optional<BodyEstimate> estimate;     ///< with measured senses
};

struct RunLog {
  RobotDescription robot;
  Scene final_scene;
  std::vector<Sample> samples;
  std::vector<BodySample> body;       ///< of the whole body only, like the next two
  FloatingRobot floating;             ///< the robot as simulated
  FloatingRobot::Frame pushed;        ///< where it is pushed
  double ground_friction = infinity;  ///< Coulomb's coefficient
  std::vector<TickRecord> ticks;
  std::vector<StepRecord> steps;
  std::vector<PlanRecord> plans;  ///< of ticks in which steps are planned or compared
  LoopStatistics loop;
  std::string solver;
  double touchdown = infinity;  ///< of the first step, s; infinite: no foot ever landed
  double last_touchdown() const {
    double last = touchdown;
    for (const StepRecord& step : steps)
      if (step.touchdown < infinity) last = step.touchdown;
    return last;
  }
  bool stopped_early = false;
  std::string stop_reason;   ///< when stopped early
  bool interrupted = false;  ///< stopped early by whoever watched
  std::string plant = "centroidal";
  long control_calls = 0, control_failures = 0;  ///< of the whole-body controller
  /// More unsolved programs than a fall leaves behind: the whole-body controller has failed.
  bool control_failed() const {
    return static_cast<double>(control_failures) > 0.01 * static_cast<double>(control_calls);
  }
  long control_cuts = 0;  ///< of its calls, those in which torques were cut to their limits
  /// CPU time of the parts of the whole body's loop, s.
  double plan_seconds = 0.0, control_seconds = 0.0, plant_seconds = 0.0;
  bool numerical_failure = false;  ///< the plant failed to integrate
};

}  // namespace saltus::walking
