#include "saltus/transcription/replay.hpp"

#include <algorithm>

namespace saltus {

Plan plan_of(const OptimalControlProblem& problem, const Trajectory& trajectory) {
  Plan plan;
  const std::size_t phases = problem.phases().size();
  for (std::size_t j = 0; j < phases; ++j)
    plan.parameters.push_back(trajectory.phases()[j].parameters);
  plan.starts.assign(phases, trajectory.start_time());
  plan.durations.assign(phases, 0.0);
  int phase = -1;
  for (const Trajectory::Piece& piece : trajectory.pieces()) {
    if (piece.phase != phase) plan.starts[piece.phase] = piece.start;
    phase = piece.phase;
    plan.durations[piece.phase] += piece.length;
    plan.intervals.push_back(
        {piece.phase, piece.start, piece.length, piece.state, piece.coefficients, piece.end_state});
  }
  // A phase without intervals begins and ends where the one before it ends.
  for (std::size_t j = 1; j < phases; ++j)
    if (plan.durations[j] == 0.0)
      plan.starts[j] = std::max(plan.starts[j], plan.starts[j - 1] + plan.durations[j - 1]);
  return plan;
}

}  // namespace saltus
