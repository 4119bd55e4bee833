#include "problems/push_recovery/push_recovery.hpp"

#include "problems/push_recovery/criteria.hpp"
#include "problems/push_recovery/mpc.hpp"
#include "saltus/robots/report/run_biped.hpp"
#include "saltus/robots/survival/map.hpp"

namespace saltus::push_recovery {

std::unique_ptr<BipedProblem> PushRecovery::clone() const {
  return std::make_unique<PushRecovery>(*this);
}

std::unique_ptr<Planner> PushRecovery::make_planner(const RobotDescription& nominal,
                                                    const Scene& scene) const {
  return make_mpc(config_, nominal, scene);
}

std::unique_ptr<StepPlanner> PushRecovery::make_step_planner(const Scene& scene) const {
  return std::make_unique<StepLogic>(config_.step, config_.push.start, scene);
}

double PushRecovery::end_time(const StepPlanner& steps, double touchdown) const {
  return push_recovery::end_time(config_.push, steps, touchdown);
}

Verdict PushRecovery::judge(const RunLog& log) const { return push_recovery::judge(config_, log); }

ProblemEntry entry() {
  return biped_entry<PushRecovery>("push_recovery", "iCub is pushed and caught by a step");
}

Verb map_verb() { return walking::map_verb(PushRecovery{}); }

}  // namespace saltus::push_recovery
