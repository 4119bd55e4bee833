// The closed loop: controller and plant, tick by tick, and what came of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "problems/push_recovery/config.hpp"
#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/walking/body_verdict.hpp"
#include "saltus/robots/walking/planner.hpp"
#include "saltus/robots/walking/progress.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::push_recovery {

/// State and command at one instant of the simulation.
struct Sample {
  double time = 0.0;  ///< s
  Vec<double, 9> gamma;
  Vec<double, 2> capture_point;
  /// Applied from this instant on, left and right, sole axes; on the whole body those that its
  /// controller expects (what is measured stands in BodySample).
  Vec<double, 12> wrenches;
  Vec<double, 3> push;  ///< N
  bool two_feet = false;
};

/// One call of the controller.
struct TickRecord {
  double time = 0.0;
  Provenance provenance = Provenance::fallback;
  SolveStatus status = SolveStatus::invalid_problem;
  std::string message;
  double seconds = 0.0;
  int iterations = 0;
  double cost = 0.0;
  double kkt = 0.0;
  double softness = 0.0;  ///< largest violation of the hull in the plan, m
};

/// What the whole body does at the instant of the sample with the same index.
struct BodySample {
  WholeBodyState state;
  VectorXd torques;                         ///< Nm
  Vec<double, 12> planned;                  ///< wrenches of the plan, left and right, sole axes
  Vec<double, 6> left, right;               ///< measured (force | torque), world axes
  Eigen::Isometry3d left_sole, right_sole;  ///< contact frames
};

struct RunLog {
  RobotDescription robot;
  Scene final_scene;
  std::vector<Sample> samples;
  std::vector<BodySample> body;  ///< of the whole body only, like the next two
  FloatingRobot floating;        ///< the robot as simulated
  FloatingRobot::Frame pushed;   ///< where it is pushed
  std::vector<TickRecord> ticks;
  LoopStatistics loop;
  std::string solver;
  double touchdown = infinity;  ///< s; infinite: the foot never landed
  bool stopped_early = false;
  std::string stop_reason;  ///< when stopped early
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

/// Verdict by the criteria of the README: over the whole run CoM height and angular momentum, and
/// from 4 s after the landing (without a step: after the push) for one second rest at the target;
/// on the whole body no planted foot slips by `planted_slip`.
struct Verdict {
  bool recovered = false;
  std::string reason;  ///< when not
  double final_com_error = 0.0, icp_settling = infinity;
  double com_height_min = infinity, com_height_max = -infinity, angular_momentum_max = 0.0;
  bool fell_before_push = false;    ///< whatever came of it says nothing about the push
  std::optional<BodyVerdict> body;  ///< of the whole body only
};

// Bounds for iCub, which has this mass and CoM height on one foot. For another robot lengths of the
// CoM scale with its height h, and angular momentum with m h sqrt(g h).
inline constexpr double reference_mass = 33.0616727, reference_height = 0.5578762015;  // kg, m
inline constexpr double height_lowest = 0.45, height_highest = 0.60;                   // m
inline constexpr double angular_momentum_limit = 1.0;                                  // Nms
inline constexpr double rest_after = 4.0, rest_length = 1.0;                           // s
inline constexpr double rest_speed = 0.05;                                             // m/s
inline constexpr double rest_com_error = 0.02;                                         // m
inline constexpr double rest_angular_momentum = 0.1;                                   // Nms
inline constexpr double icp_settled_within = 0.01;                                     // m

RunLog simulate(const Config& config, const RobotDescription& robot, const Observer& observer = {});
Verdict judge(const Config& config, const RunLog& log);

}  // namespace saltus::push_recovery
