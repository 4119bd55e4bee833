#include "saltus/transcription/grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "saltus/transcription/block_program.hpp"

namespace saltus {

Layout::Layout(const OptimalControlProblem& problem, const Grid& grid, BlockProgram& program) {
  const auto add = [&](int count, std::string name) {
    const int first = program.add_variables(count);
    if (count > 0) {
      starts_.push_back(first);
      names_.push_back(std::move(name));
    }
    return first;
  };
  for (int j = 0; j < grid.phases(); ++j) {
    const PhaseDefinition& phase = problem.phases()[j];
    PhaseLayout& layout = phases_.emplace_back();
    const int nc = (phase.input_shape() == InputShape::constant ? 1 : 2) * phase.sizes.nu;
    for (int k = 0; k <= grid.intervals(j); ++k) {
      layout.states.push_back(
          add(phase.sizes.nx, fmt::format("phase '{}', node {}, state", phase.name, k)));
      layout.integrals.push_back(add(static_cast<int>(phase.integrals.size()),
                                     fmt::format("phase '{}', node {}, integral", phase.name, k)));
      if (k < grid.intervals(j))
        layout.inputs.push_back(
            add(nc, fmt::format("phase '{}', interval {}, input", phase.name, k)));
    }
  }
  std::map<std::string, int> shared;
  for (int j = 0; j < grid.phases(); ++j) {
    const PhaseDefinition& phase = problem.phases()[j];
    for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
      const int size = static_cast<int>(block.value.size());
      if (block.unknown && !shared.contains(block.name))
        shared[block.name] = add(size, fmt::format("parameter '{}', entry", block.name));
      for (int i = 0; i < size; ++i)
        phases_[j].parameters.push_back(block.unknown ? shared[block.name] + i : -1);
    }
    if (phase.has_free_duration())
      phases_[j].duration = add(1, fmt::format("phase '{}', duration", phase.name));
  }
  if (problem.start_time_bounds()) start_time_ = add(1, "start time");
}

std::string Layout::describe(int variable) const {
  if (first_slack_ > 0 && variable >= first_slack_)
    return fmt::format("slack {}", variable - first_slack_);
  const auto it = std::upper_bound(starts_.begin(), starts_.end(), variable);
  const auto block = static_cast<std::size_t>(it - starts_.begin()) - 1;
  return fmt::format("{} {}", names_[block], variable - starts_[block]);
}

}  // namespace saltus
