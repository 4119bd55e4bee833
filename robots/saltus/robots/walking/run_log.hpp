// What a closed loop leaves behind: states, commands, ticks of the planner, and what the body did.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_plan.hpp"
#include "saltus/robots/walking/unmet_decision.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::walking {

/// State and command at one instant of the simulation.
struct Sample {
  double time = 0.0;             ///< s
  Vec<double, 9> gamma;          ///< CoM m, velocity m/s, angular momentum Nms
  Vec<double, 2> capture_point;  ///< m
  /// Applied from this instant on, left and right, level sole axes; on the whole body those that
  /// its controller expects (what is measured stands in BodySample).
  Vec<double, 12> wrenches;
  Vec<double, 3> push;                           ///< mean until the next sample, N
  bool left_stands = true, right_stands = true;  ///< whether that foot stands
  /// Whether both stand.
  bool two_feet() const { return left_stands && right_stands; }
};

/// One foot that stepped.
struct StepRecord {
  Side foot = Side::right;      ///< that stepped
  double lift_off = 0.0;        ///< s; of a foot that was in the air already: when it was decided
  double due = infinity;        ///< landing as planned last, s
  double touchdown = infinity;  ///< infinite: not yet, when the run ended, s
  Vec<double, 3> place = Vec<double, 3>::Zero();      ///< planned last, m
  Vec<double, 3> landed_at = Vec<double, 3>::Zero();  ///< really, m
};

/// What stands from an instant on, until the next record.
struct GroundRecord {
  double from = 0.0;                 ///< s
  bool left = false, right = false;  ///< whether that foot stands
  SupportPolygon polygon;            ///< of the soles that stand, where they really are
};

/// What the planner of steps said in one tick.
struct PlanRecord {
  double time = 0.0;     ///< s
  StepPlan plan;         ///< what was chosen, and what else was considered
  double seconds = 0.0;  ///< processor time that it took
};

/// One call of the planner.
struct TickRecord {
  double time = 0.0;                                  ///< s
  Provenance provenance = Provenance::fallback;       ///< where the input comes from
  SolveStatus status = SolveStatus::invalid_problem;  ///< of the tick's program
  std::string message;     ///< why there is no plan; empty if there is one
  double seconds = 0.0;    ///< of the tick, s
  int iterations = 0;      ///< of the solver
  double cost = 0.0;       ///< of the plan
  double kkt = 0.0;        ///< largest residual of the optimality conditions
  double violation = 0.0;  ///< of what carries a penalty: the largest in the plan
};

/// What the controllers took for true at that instant.
struct BodyEstimate {
  WholeBodyState state;        ///< of the whole body as estimated
  Vec<double, 9> gamma;        ///< CoM m, velocity m/s, angular momentum Nms, as estimated
  Vec<double, 3> stance_sole;  ///< origin of its contact frame, m
  Side stance = Side::left;    ///< the foot that is meant: steps change it
};

/// What the whole body does at the instant of the sample with the same index.
struct BodySample {
  WholeBodyState state;     ///< as it is
  VectorXd torques;         ///< Nm
  Vec<double, 12> planned;  ///< wrenches of the plan, left and right, axes of the soles as they are
  /// Measured (force | torque), world axes: the mean over the engine's steps since the sample
  /// before, so that their sum is the ground's impulse.
  Vec<double, 6> left, right;
  Eigen::Isometry3d left_sole, right_sole;  ///< contact frames
  std::optional<BodyEstimate> estimate;     ///< with measured senses
};

/// Everything that a run leaves.
struct RunLog {
  RobotDescription robot;             ///< that was simulated
  Scene final_scene;                  ///< feet and ground at the end
  std::vector<Sample> samples;        ///< one per control period
  std::vector<BodySample> body;       ///< of the whole body only, like the next two
  FloatingRobot floating;             ///< the robot as simulated
  FloatingRobot::Frame pushed;        ///< where it is pushed
  double ground_friction = infinity;  ///< Coulomb's coefficient
  std::vector<TickRecord> ticks;      ///< one per solve
  std::vector<StepRecord> steps;      ///< one per step
  std::vector<GroundRecord> ground;   ///< from the start on, one more at each lift-off and landing
  std::vector<PlanRecord> plans;      ///< of ticks in which steps are planned or compared
  /// Of ticks in which a planner could not keep to all that is asked: of each planner the first and
  /// the worst.
  std::vector<UnmetDecision> unmet;
  LoopStatistics loop;          ///< of latency and provenance
  std::string solver;           ///< what solved the ticks
  double touchdown = infinity;  ///< of the first step, s; infinite: no foot ever landed
  /// Of the last foot that came down, s; infinity: none.
  double last_touchdown() const {
    double last = touchdown;
    for (const StepRecord& step : steps)
      if (step.touchdown < infinity) last = step.touchdown;
    return last;
  }
  bool stopped_early = false;                    ///< by a fall or by the user
  std::string stop_reason;                       ///< when stopped early
  bool interrupted = false;                      ///< stopped early by whoever watched
  std::string plant = "centroidal";              ///< what was simulated
  long control_calls = 0, control_failures = 0;  ///< of the whole-body controller
  /// More unsolved programs than a fall leaves behind: the whole-body controller has failed.
  bool control_failed() const {
    return static_cast<double>(control_failures) > 0.01 * static_cast<double>(control_calls);
  }
  long control_cuts = 0;  ///< of its calls, those in which torques were cut to their limits
  LatencyHistogram control_solves;  ///< CPU time of its programs' solution, one entry a call
  /// CPU time of the parts of the whole body's loop, s.
  double plan_seconds = 0.0, control_seconds = 0.0, plant_seconds = 0.0;
  bool numerical_failure = false;  ///< the plant failed to integrate
};

}  // namespace saltus::walking
