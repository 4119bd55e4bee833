// Motors that follow commanded torques with a lag.
#pragma once

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/robots/whole_body/device_options.hpp"

namespace saltus::robots {

/// Torques of all motors. After a reset the first command acts at once. After construction nothing
/// allocates.
class Motors {
 public:
  /// `step` is the time step of the engine, s. Throws DefinitionError for options that are negative
  /// or not finite, and for a step that is not positive.
  Motors(const MotorOptions& options, int joints, double step);

  /// Discards all commands.
  void reset();
  /// Sets the torques to follow from now on, Nm.
  void command(const VectorXd& torques);
  /// Advances by one step of the engine. Returns the mean torques during that step, Nm.
  const VectorXd& step();

 private:
  // Share of the remaining difference that is covered per step, at its end and on average; largest
  // change per step, Nm.
  double followed_ = 1.0, mean_followed_ = 1.0, largest_change_ = infinity;
  VectorXd wanted_, torques_, exerted_;  // torques_: at the end of the last step
  bool rests_ = true;                    // true if there was no command since the reset
};

}  // namespace saltus::robots
