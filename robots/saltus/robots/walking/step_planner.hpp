// Who decides which foot steps, when and where.
#pragma once

#include "saltus/robots/walking/step_plan.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::walking {

/// Asked once per tick of the controller. This one never steps.
class StepPlanner {
 public:
  virtual ~StepPlanner() = default;

  /// The steps to come as it is seen now. The result lasts until the next call.
  virtual const StepPlan& plan(const StepSituation& /*now*/) { return plan_; }
  /// What the last plan is a solution of, with its data; null: none was solved for it.
  virtual const MultipleShooting* shooting() const { return nullptr; }

 protected:
  StepPlan plan_;  ///< what was planned last; sized once
};

}  // namespace saltus::walking
