// Who decides when the next contact is made, and where.
#pragma once

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus::walking {

/// Asked once per tick of the planner. This one never steps.
class StepPlanner {
 public:
  virtual ~StepPlanner() = default;

  /// `t` s, capture point in the world (m), omega 1/s.
  virtual void update(double /*t*/, const Vec<double, 2>& /*capture_point*/, double /*omega*/) {}

  bool is_stepping() const { return landing_time() < infinity; }
  /// Absolute time of the landing, infinite while no step is due, s.
  virtual double landing_time() const { return infinity; }
  /// A touch of the ground before this time is not the landing, s.
  virtual double earliest_landing() const { return infinity; }
  /// Where the contact frame of the swing foot lands, in the world, m.
  virtual const Vec<double, 3>& place() const { return nowhere_; }

 private:
  Vec<double, 3> nowhere_ = Vec<double, 3>::Zero();
};

}  // namespace saltus::walking
