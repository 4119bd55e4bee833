// Applies new data to a shooting program, completely or not at all.
#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

using namespace shooting;

namespace {

bool is_same_input(const VectorXd& a, const VectorXd& b) {
  for (int i = 0; i < a.size(); ++i)
    if (a[i] != b[i] && !(std::isnan(a[i]) && std::isnan(b[i]))) return false;
  return true;
}

}  // namespace

// Builds grid and bounds of the new data separately, where invalid data throw. Nothing throws after
// the swap.
void ShootingProgram::commit(const ProblemData& next) {
  check(problem_, next);
  const bool given_changes = next.has_given_start() != data_.has_given_start();
  const bool moves = given_changes || !next.has_same_times(data_);
  const bool start_changes = next.start_bounds != data_.start_bounds;
  const bool previous_changes = !is_same_input(next.previous_input, data_.previous_input);
  if (moves) propose(next);

  for (int j = 0; j < grid_.phases(); ++j)
    for (int i = 0; i < next.parameters[j].size(); ++i)
      if (next.parameters[j][i] != data_.parameters[j][i])
        place_parameter(j, i, next.parameters[j][i]);
  data_.start_time = next.start_time;
  data_.start_bounds = next.start_bounds;
  data_.durations = next.durations;
  data_.duration_bounds = next.duration_bounds;
  data_.total_time = next.total_time;
  data_.previous_input = next.previous_input;
  if (moves) {
    data_.schedule.adopt(next.schedule);
    problem_.editable_schedule().adopt(next.schedule);
    std::swap(grid_, proposal_.grid);
    refresh();
    return;
  }
  if (start_changes) refresh_start();
  if (previous_changes) refresh_changes();
}

void ShootingProgram::propose(const ProblemData& next) {
  Grid& grid = proposal_.grid;
  for (int j = 0; j < grid.phases(); ++j) grid.set_duration(j, next.durations[j]);
  grid.place_events(next.schedule, next.start_time);
  const bool given = next.has_given_start();
  for (int j = 0; j < grid.phases(); ++j) {
    propose_input_bounds(j);
    propose_state_bounds(j, given);
  }
}

bool ShootingProgram::set_penalty_weight(std::string_view weight_name, double weight) {
  if (!problem_.set_penalty_weight(weight_name, weight)) return false;
  refresh_rows();
  refresh_limits();
  return true;
}

void ShootingProgram::place_parameter(int phase, int i, double value) {
  data_.parameters[phase][i] = value;
  if (layout_.parameter(phase, i) >= 0) return;
  for (const BlockInstance& b : placed_)
    if (b.point.phase == phase && b.parameter_argument >= 0)
      set_constant(b.block, b.parameter_argument + i, value);
}

}  // namespace saltus
