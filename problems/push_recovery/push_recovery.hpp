// Push recovery in closed loop: the paper's planner, the step logic, and the criteria of the
// README.
#pragma once

#include "problems/biped/configurable_biped.hpp"
#include "problems/push_recovery/config.hpp"
#include "saltus/app/program.hpp"
#include "saltus/robots/simulation/simulate.hpp"

namespace saltus::push_recovery {

class PushRecovery final : public ConfigurableBiped {
 public:
  explicit PushRecovery(Config config = {}) : config_(std::move(config)) {}
  std::unique_ptr<ConfigurableBiped> clone() const override;
  const Config& settings() const override { return config_; }
  Config& settings() override { return config_; }
  void declare(Settings& settings) override { declare_settings(settings, config_); }
  void scale(const RobotScale& scale) override;
  std::unique_ptr<Planner> make_planner(const robots::RobotDescription& nominal,
                                        const Scene& scene) const override;
  std::unique_ptr<StepPlanner> make_step_planner(const robots::RobotDescription& nominal,
                                                 const Scene& scene) const override;
  std::optional<BipedProblem::StepBounds> step_bounds(
      const robots::RobotDescription& nominal) const override;
  double end_time(double push_end, double landing, double touchdown) const override;
  Verdict judge(const RunLog& log) const override;
  std::unique_ptr<robots::walking::UnmetExplanations> unmet_explanations(
      const robots::RobotDescription& robot) const override;

 private:
  Config config_;
};

/// Entry for `saltus run push_recovery`, `saltus map`, `saltus robot` and `saltus control`.
ProblemEntry entry();
Verb map_verb();
Verb robot_verb();
Verb control_verb();

}  // namespace saltus::push_recovery
