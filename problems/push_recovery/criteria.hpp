// Criteria of the README for a run to count as recovered.
#pragma once

#include "problems/push_recovery/config.hpp"
#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::push_recovery {

// Values for iCub; they scale for other robots, see reference_mass.
inline constexpr double height_lowest = 0.45, height_highest = 0.60;  // m
inline constexpr double angular_momentum_limit = 1.0;                 // Nms
inline constexpr double rest_after = 4.0, rest_length = 1.0;          // s
inline constexpr double rest_speed = 0.05;                            // m/s
inline constexpr double rest_com_error = 0.02;                        // m
inline constexpr double rest_angular_momentum = 0.1;                  // Nms

/// Limits for the whole run, scaled to the size of the robot.
struct LimitsOnTheWay {
  Bounds height = between(height_lowest, height_highest);  ///< height of the CoM, m
  double momentum = angular_momentum_limit;                ///< angular momentum about the CoM, Nms
};
LimitsOnTheWay limits_on_the_way(const Config& config, const robots::RobotDescription& robot);

/// Time (s) after which the run can be judged: the last push is over at `push_end`, the last foot
/// has landed, and the robot has had time to settle. `landing` is infinite while none is due,
/// `touchdown` until a foot has landed.
double end_time(double push_end, double landing, double touchdown);

/// Judges a run. CoM height and angular momentum must stay within limits. The robot must rest at
/// the target from `rest_after` past the last landing or the end of the last push, whichever is
/// later. In whole-body runs no planted foot may slip by `planted_slip`. The reason is the first
/// cause. For a fall, it names the fall and the first cause.
Verdict judge(const Config& config, const RunLog& log);

}  // namespace saltus::push_recovery
