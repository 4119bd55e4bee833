// Log of a closed loop of a biped: states, commands, planner ticks and the motion of the body.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_planner.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"
#include "saltus/robots/whole_body/plant.hpp"
#include "saltus/simulation/loop_log.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::robots::walking {

/// State and command at one instant of the simulation.
struct BipedSample {
  double time = 0.0;             ///< s
  Vec<double, 9> gamma;          ///< CoM m, velocity m/s, angular momentum Nms
  Vec<double, 2> capture_point;  ///< m
  /// Wrenches applied from this instant on, left and right, in level sole axes. For the whole body
  /// these are the wrenches that its controller expects; RunLog::BodySample holds the measured
  /// ones.
  Vec<double, 12> wrenches;
  Vec<double, 3> push;                           ///< mean until the next sample, N
  bool left_stands = true, right_stands = true;  ///< true if that foot stands
  /// True if both feet stand.
  bool two_feet() const { return left_stands && right_stands; }
};

/// Problem of a planner in one tick.
struct UnmetDecision : LoopLog::UnmetTick {
  std::string decision;  ///< "wrenches" or "steps"
  double missed = 0.0;   ///< total violation, m; infinite: no plan
};

/// Complete log of a run. `ticks` are those of the wrench planner. Their `violation` is the largest
/// one of terms with penalty in the plan. `recording`, `plans`, `unmet` and `misses` are empty: the
/// samples below replace the recording, and the problem judges the planners of a biped.
struct RunLog : LoopLog {
  /// Record of one step.
  struct Step {
    Side foot = Side::right;      ///< foot that stepped
    double lift_off = 0.0;        ///< s; if the foot was already in the air: time of the decision
    double due = infinity;        ///< last planned landing, s
    double touchdown = infinity;  ///< s; infinite: not landed at the end of the run
    Vec<double, 3> place = Vec<double, 3>::Zero();      ///< last planned place, m
    Vec<double, 3> landed_at = Vec<double, 3>::Zero();  ///< actual place, m
  };

  /// Support from an instant on, until the next record.
  struct Ground {
    double from = 0.0;                 ///< s
    bool left = false, right = false;  ///< true if that foot stands
    SupportPolygon polygon;            ///< support polygon of the actual soles
  };

  /// Output of the step planner in one tick.
  struct Plan {
    double time = 0.0;     ///< s
    StepPlan plan;         ///< chosen plan, and the alternatives
    double seconds = 0.0;  ///< processor time of the tick, s
  };

  /// Estimate of the controllers at one instant.
  struct BodyEstimate {
    WholeBodyState state;        ///< estimated state of the whole body
    Vec<double, 9> gamma;        ///< estimated CoM m, velocity m/s, angular momentum Nms
    Vec<double, 3> stance_sole;  ///< origin of its contact frame, m
    Side stance = Side::left;    ///< foot of `stance_sole`; steps change it
  };

  /// State of the whole body at the instant of the sample with the same index.
  struct BodySample {
    WholeBodyState state;     ///< simulated state
    VectorXd torques;         ///< of the motors, at the end of the sample, Nm
    Vec<double, 12> planned;  ///< planned wrenches, left and right, axes of the actual soles
    /// Measured (force | torque), world axes: mean over the engine steps since the previous sample,
    /// so that their sum is the impulse of the ground.
    Vec<double, 6> left, right;
    Eigen::Isometry3d left_sole, right_sole;  ///< contact frames
    std::optional<BodyEstimate> estimate;     ///< estimate, if sensors are simulated
  };

  /// Mass and CoM that the controllers estimate.
  struct MassEstimate {
    double mass;               ///< kg
    Vec<double, 3> com_shift;  ///< of the CoM of their model, m, axes of the base
  };

  RobotDescription robot;             ///< the simulated robot
  Scene final_scene;                  ///< feet and ground at the end
  std::vector<BipedSample> samples;   ///< one per control period
  std::vector<BodySample> body;       ///< whole body only, like the next two
  FloatingRobot floating;             ///< the robot in the simulation
  FloatingRobot::Frame pushed;        ///< frame of the link that is pushed
  double ground_friction = infinity;  ///< Coulomb's coefficient, the largest if it varies
  Plant::Ground plant_ground;         ///< shape of the ground; `ground` lists the support
  std::vector<Step> steps;            ///< one per step
  std::vector<Ground> ground;         ///< one at the start, one more at each lift-off and landing
  std::vector<Plan> step_plans;       ///< ticks in which steps are planned or compared
  /// Ticks in which a planner could not satisfy all constraints: the first and the worst of each
  /// planner.
  std::vector<UnmetDecision> unmet_decisions;
  double touchdown = infinity;  ///< first landing, s; infinite: no foot landed
  int lost_contacts = 0;        ///< landings that a foot lost before it carried load
  /// Time of the last landing, s; infinite: none.
  double last_touchdown() const {
    double last = touchdown;
    for (const Step& step : steps)
      if (step.touchdown < infinity) last = step.touchdown;
    return last;
  }
  bool stopped_early = false;                    ///< stopped by a fall or by the user
  std::string stop_reason;                       ///< reason of an early stop
  bool interrupted = false;                      ///< stopped early by the observer
  long control_calls = 0, control_failures = 0;  ///< calls and failures of the whole-body
                                                 ///< controller
  /// True if the whole-body controller has failed: it left more programs unsolved than a fall
  /// explains.
  bool control_failed() const {
    return static_cast<double>(control_failures) > 0.01 * static_cast<double>(control_calls);
  }
  long control_cuts = 0;            ///< number of calls in which torques were cut to their limits
  LatencyHistogram control_solves;  ///< processor time of its programs, one entry per call
  /// Processor time of the parts of the loop, s.
  double plan_seconds = 0.0, control_seconds = 0.0, plant_seconds = 0.0;
  bool numerical_failure = false;  ///< the plant failed to integrate
  /// Last estimate of the controllers; empty if there is none.
  std::optional<MassEstimate> mass_estimate;
};
/// Deprecated name.
using Sample [[deprecated("use BipedSample; removed in 0.4")]] = BipedSample;
/// Deprecated name. `cost` is `objective` now.
using TickRecord [[deprecated("use LoopTick; removed in 0.4")]] = LoopLog::Tick;
/// Deprecated name.
using BodySample [[deprecated("use RunLog::BodySample; removed in 0.4")]] = RunLog::BodySample;

/// State of the loop at one tick of the planner.
struct LoopState {
  /// Activity of the robot, for the progress line.
  enum class Footing { standing, pushed, stepping, landed };

  double time = 0.0;        ///< s
  double com_height = 0.0;  ///< m
  /// Distance of the capture point from the edge of the support, m, positive inside. The support is
  /// the stance sole until the landing, then the hull of both.
  double margin = 0.0;
  Footing footing = Footing::standing;  ///< activity of the robot
};
/// Deprecated name.
using Footing [[deprecated("use LoopState::Footing; removed in 0.4")]] = LoopState::Footing;

/// Called at every tick of the planner. Returning false stops the run; results up to then are kept.
using Observer = std::function<bool(const LoopState&)>;

}  // namespace saltus::robots::walking
