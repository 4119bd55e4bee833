#include "saltus/ocp/interval_problem_of.hpp"

namespace saltus {

IntervalProblem interval_problem_of(const PhaseDefinition& phase) {
  IntervalProblem interval;
  interval.arguments = phase.sizes;
  interval.dynamics = phase.dynamics;
  interval.switching = phase.switching;
  interval.algebraic = phase.algebraic;
  interval.nominal_state = phase.nominal_state;
  interval.differentiate_parameter.assign(phase.sizes.np, false);
  return interval;
}

}  // namespace saltus
