// Motors that follow commanded torques with a lag.
#pragma once

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// First-order lag, then a limit on the rate of change; all joints alike.
struct MotorOptions {
  double bandwidth = 0.0;    ///< Hz, at which the lag takes off 3 dB; 0: no lag
  double torque_rate = 0.0;  ///< largest, Nm/s; 0: no limit

  /// True if torques act at once and as commanded.
  bool is_ideal() const { return bandwidth == 0.0 && torque_rate == 0.0; }
};

/// Torques of all motors. After a reset the first command acts at once. After construction nothing
/// allocates.
class Motors {
 public:
  /// `step` of the engine, s. Throws DefinitionError for options below zero or not finite, and for
  /// a step that is not positive.
  Motors(const MotorOptions& options, int joints, double step);

  /// Forgets all commands.
  void reset();
  /// Torques to follow from now on, Nm.
  void command(const VectorXd& torques);
  /// Moves on by one step of the engine. Returns the mean torques during that step, Nm.
  const VectorXd& step();

 private:
  // Per step: of what is missing, at its end and on average; Nm.
  double followed_ = 1.0, mean_followed_ = 1.0, largest_change_ = infinity;
  VectorXd wanted_, torques_, exerted_;  // torques_: at the end of the last step
  bool rests_ = true;                    // no command since the reset
};

}  // namespace saltus
