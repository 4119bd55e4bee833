#include "problems/push_recovery/push_recovery.hpp"

#include <cmath>
#include <optional>

#include "problems/biped/control/control_verb.hpp"
#include "problems/biped/report/run_biped.hpp"
#include "problems/biped/survey/robot_verb.hpp"
#include "problems/biped/survival/map.hpp"
#include "problems/push_recovery/criteria.hpp"
#include "problems/push_recovery/mpc.hpp"
#include "problems/push_recovery/unmet_explanations.hpp"
#include "saltus/robots/walking/reactive_steps.hpp"

namespace saltus::push_recovery {

std::unique_ptr<ConfigurableBiped> PushRecovery::clone() const {
  return std::make_unique<PushRecovery>(*this);
}

std::unique_ptr<Planner> PushRecovery::make_planner(const robots::RobotDescription& nominal,
                                                    const Scene& scene) const {
  return make_mpc(config_, nominal, scene);
}

std::unique_ptr<StepPlanner> PushRecovery::make_step_planner(
    const robots::RobotDescription& nominal, const Scene& scene) const {
  Step step = config_.step;
  step.shortest = config_.planning.shortest;
  switch (step.planner) {
    case Step::Planner::ocp:
      return make_step_choice(config_.planning, step, scene, nominal.mass,
                              reach_of_robot(config_.planning, config_.robot, nominal));
    case Step::Planner::reactive:
      return make_reactive_steps(step, scene);
    case Step::Planner::formula:
      break;
  }
  std::optional<double> push_start;
  if (step.known) push_start = pushes().front().start;
  return make_formula_steps(step, push_start, scene);
}

// The reactive planner steps as often as needed, but more than three steps gain little.
std::optional<BipedProblem::StepBounds> PushRecovery::step_bounds(
    const robots::RobotDescription& nominal) const {
  const StepPlanning& planning = config_.planning;
  std::optional<survey::FootReach> reach;
  switch (config_.step.planner) {
    case Step::Planner::formula:
      return std::nullopt;
    case Step::Planner::reactive:
      return BipedProblem::StepBounds{3, planning.shortest, reach_of(config_.step).from_foot};
    case Step::Planner::ocp:
      reach = reach_of_robot(planning, config_.robot, nominal);
      return BipedProblem::StepBounds{planning.most_steps, planning.shortest,
                                      reach ? reach->from_foot : reach_of(config_.step).from_foot};
  }
  return std::nullopt;
}

void PushRecovery::scale(const RobotScale& scale) {
  walking::scale(config_, scale);
  // Every term of the cost keeps its magnitude: gamma = (m, m/s, Nms), wrenches in N and Nm.
  const double M = scale.mass, L = scale.length;
  Weights& w = config_.weights;
  for (Vector9* gamma : {&w.gamma, &w.gamma_impact}) {
    gamma->head<3>() /= L * L;
    gamma->segment<3>(3) /= L;
    gamma->tail<3>() /= M * M * L * L * L;
  }
  w.wrench.head<3>() /= M * M;
  w.wrench.tail<3>() /= M * M * L * L;
  w.wrench_change /= M * M;
  w.capture_point /= L * L;
  w.capture_point_standing /= L * L;
  w.capture_point_penalty /= L * std::sqrt(L);
  StepPlanning& p = config_.planning;  // times are not scaled
  p.foot_speed *= L;
  p.sole_margin *= L;
  p.momentum *= M * L * std::sqrt(L);
  p.torque *= M * L;
  p.weights[2] /= L * L;
}

double PushRecovery::end_time(double push_end, double landing, double touchdown) const {
  return push_recovery::end_time(push_end, landing, touchdown);
}

Verdict PushRecovery::judge(const RunLog& log) const { return push_recovery::judge(config_, log); }

std::unique_ptr<robots::walking::UnmetExplanations> PushRecovery::unmet_explanations(
    const robots::RobotDescription& robot) const {
  return std::make_unique<PushRecoveryExplanations>(limits_on_the_way(config_, robot));
}

ProblemEntry entry() {
  return biped_entry<PushRecovery>("push_recovery",
                                   "iCub is pushed and recovers, with a step if necessary");
}

Verb map_verb() {
  Config config;
  config.step_times_are_given = true;
  return walking::map_verb(PushRecovery(config));
}
Verb robot_verb() { return survey::robot_verb("push_recovery", PushRecovery{}); }
Verb control_verb() { return walking::control_verb(PushRecovery{}); }

}  // namespace saltus::push_recovery
