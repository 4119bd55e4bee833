#include "saltus/ocp/problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

bool is_entry_of(const PhaseDefinition::ParameterBlock& block, std::string_view name) {
  return name.size() > block.name.size() && name.starts_with(block.name) &&
         name[block.name.size()] == '.' && !block.entries.empty();
}

std::vector<std::string> names_of(std::span<const ParameterEntry> entries) {
  std::vector<std::string> names;
  for (const ParameterEntry& entry : entries) names.emplace_back(entry.name);
  return names;
}

// Throws with a list of the valid names.
[[noreturn]] void throw_unknown_name(const OptimalControlProblem& problem, std::string_view name) {
  std::vector<std::string> data;
  for (const PhaseDefinition& phase : problem.phases())
    for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
      if (is_entry_of(block, name)) {
        const std::vector<std::string> entries = names_of(block.entries);
        const std::string_view entry = name.substr(block.name.size() + 1);
        throw DefinitionError(fmt::format("parameter '{}' has no entry '{}', it has {}{}",
                                          block.name, entry, join_names(entries),
                                          did_you_mean(entry, entries)));
      }
      if (!block.unknown && std::ranges::find(data, block.name) == data.end())
        data.push_back(block.name);
    }
  throw DefinitionError(fmt::format("problem '{}' has no data parameter '{}'{}{}", problem.name(),
                                    name, data.empty() ? "" : ", it has " + join_names(data),
                                    did_you_mean(name, data)));
}

}  // namespace

std::optional<OptimalControlProblem::ParameterRange> find_parameter(const PhaseDefinition& phase,
                                                                    std::string_view name) {
  int first = 0;
  for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
    if (block.name == name)
      return OptimalControlProblem::ParameterRange{first, static_cast<int>(block.value.size()),
                                                   &block};
    if (is_entry_of(block, name))
      for (const ParameterEntry& entry : block.entries)
        if (name.substr(block.name.size() + 1) == entry.name)
          return OptimalControlProblem::ParameterRange{first + entry.first, entry.size(), &block};
    first += static_cast<int>(block.value.size());
  }
  return std::nullopt;
}

void check_data(const OptimalControlProblem& problem, std::string_view name, int size,
                std::span<const ParameterEntry> entries) {
  bool found = false;
  for (const PhaseDefinition& phase : problem.phases()) {
    const std::optional<OptimalControlProblem::ParameterRange> range = find_parameter(phase, name);
    if (!range) continue;
    found = true;
    const PhaseDefinition::ParameterBlock& block = *range->block;
    if (block.unknown)
      throw DefinitionError(
          fmt::format("parameter '{}' is an unknown: the solver determines it", name));
    if (!entries.empty() && !block.entries.empty() && !std::ranges::equal(entries, block.entries))
      throw DefinitionError(fmt::format("parameter '{}' has the entries {}, but {} were given",
                                        name, join_names(names_of(block.entries)),
                                        join_names(names_of(entries))));
    if (size != range->size)
      throw DefinitionError(
          fmt::format("parameter '{}' has {} entries, but {} were given", name, range->size, size));
  }
  if (!found) throw_unknown_name(problem, name);
}

}  // namespace saltus
