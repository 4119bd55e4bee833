// Interface of step planners, which decide which foot steps, when and where.
#pragma once

#include "saltus/robots/walking/step_plan.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::walking {

/// Called once per tick of the controller. This base class never steps.
class StepPlanner {
 public:
  virtual ~StepPlanner() = default;

  /// Steps planned in the current situation. The reference is valid until the next call.
  virtual const StepPlan& plan(const StepSituation& /*now*/) { return plan_; }
  /// Program of the last plan, with its data; null if none was solved.
  virtual const MultipleShooting* shooting() const { return nullptr; }

 protected:
  StepPlan plan_;  ///< last plan; sized once
};

}  // namespace saltus::walking
