// A biped without prediction that takes given steps, for tests of the simulation and the reports.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::robots::walking {

/// Returns the same plan in every tick.
class FixedPlan final : public StepPlanner {
 public:
  explicit FixedPlan(const StepPlan& plan) { plan_ = plan; }
};

/// iCub on both feet until `end` (s), with the capture-point controller.
class FixedSteps final : public BipedProblem {
 public:
  FixedSteps(const StepPlan& plan, double end) : plan_(plan), end_(end) {
    settings_.controller = BipedSettings::Controller::capture_point;
    settings_.scene.stance = Stance::both;
    settings_.pictures = false;
  }
  const BipedSettings& settings() const override { return settings_; }
  BipedSettings& settings() override { return settings_; }
  std::vector<Push> pushes() const override { return all; }
  std::unique_ptr<Planner> make_planner(const RobotDescription&, const Scene&) const override {
    throw DefinitionError("the controller without prediction needs no planner");
  }
  std::unique_ptr<StepPlanner> make_step_planner(const RobotDescription&,
                                                 const Scene&) const override {
    return std::make_unique<FixedPlan>(plan_);
  }
  double end_time(double, double, double) const override { return end_; }
  Verdict judge(const RunLog& log) const override { return figures_of(log, 0.0, all); }

  std::vector<Push> all;

 private:
  StepPlan plan_;
  double end_;
  BipedSettings settings_;
};

}  // namespace saltus::robots::walking
