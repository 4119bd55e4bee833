// When does a run count as recovered? The criteria of the README.
#pragma once

#include "problems/push_recovery/config.hpp"
#include "saltus/robots/walking/verdict.hpp"

namespace saltus::push_recovery {

// For iCub; for another robot they scale, see reference_mass.
inline constexpr double height_lowest = 0.45, height_highest = 0.60;  // m
inline constexpr double angular_momentum_limit = 1.0;                 // Nms
inline constexpr double rest_after = 4.0, rest_length = 1.0;          // s
inline constexpr double rest_speed = 0.05;                            // m/s
inline constexpr double rest_com_error = 0.02;                        // m
inline constexpr double rest_angular_momentum = 0.1;                  // Nms

/// What must hold over the whole run, for a robot of its size.
struct LimitsOnTheWay {
  Bounds height = between(height_lowest, height_highest);  ///< of the CoM, m
  double momentum = angular_momentum_limit;                ///< about the CoM, Nms
};
LimitsOnTheWay limits_on_the_way(const Config& config, const RobotDescription& robot);

/// When enough has been seen to judge (s): the last push is over at `push_end`, the last foot has
/// landed, and the robot has had the time to settle. `landing` is infinite while none is due,
/// `touchdown` until a foot has landed.
double end_time(double push_end, double landing, double touchdown);

/// Over the whole run CoM height and angular momentum, and from `rest_after` the last landing or
/// the end of the last push, whichever is later, on rest at the target; on the whole body no
/// planted foot slips by `planted_slip`. The reason is the cause that came first; a fall's tells
/// both.
Verdict judge(const Config& config, const RunLog& log);

}  // namespace saltus::push_recovery
