#include "saltus/transcription/multiple_shooting.hpp"

#include <algorithm>

namespace saltus {

OptimalControlProblem current_problem(const MultipleShooting& shooting) {
  OptimalControlProblem problem = shooting.problem();
  const ProblemData& data = shooting.data();
  VectorXd guess = problem.start_guess();
  for (int i = 0; i < guess.size(); ++i)
    guess[i] = std::clamp(guess[i], data.start_bounds[i].lower, data.start_bounds[i].upper);
  problem.start_within(data.start_bounds, guess);
  if (problem.start_time_bounds())
    problem.start_time(*problem.start_time_bounds(), data.start_time);
  else
    problem.start_time(data.start_time);
  problem.total_time(data.total_time);
  problem.editable_schedule().adopt(data.schedule);
  for (int j = 0; j < static_cast<int>(problem.phases().size()); ++j) {
    PhaseDefinition& phase = problem.editable_phase(j);
    if (phase.has_free_duration()) {
      phase.duration = data.duration_bounds[j];
      phase.duration_guess = data.durations[j];
    } else {
      phase.duration = exactly(data.durations[j]);
    }
    int first = 0;
    for (PhaseDefinition::ParameterBlock& block : phase.parameters) {
      block.value = data.parameters[j].segment(first, block.value.size());
      first += static_cast<int>(block.value.size());
    }
  }
  return problem;
}

}  // namespace saltus
