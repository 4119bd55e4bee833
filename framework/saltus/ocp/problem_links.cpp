// Couplings of phases other than jumps: links, and integrals that continue across phases.
#include <fmt/format.h>

#include <map>
#include <set>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/ocp/problem.hpp"

namespace saltus {

OptimalControlProblem& OptimalControlProblem::add_link(Link&& link) {
  for (Bounds& b : link.limits.bounds) b = without_sentinels(b);
  links_.push_back(std::move(link));
  return *this;
}

int OptimalControlProblem::phase_index(const std::string& phase) const {
  int found = -1, count = 0;
  std::vector<std::string> names;
  for (std::size_t j = 0; j < phases_.size(); ++j) {
    names.push_back(phases_[j].name);
    if (phases_[j].name != phase) continue;
    found = static_cast<int>(j);
    ++count;
  }
  if (count > 1)
    throw DefinitionError(fmt::format(
        "{} phases are called '{}', so the name is ambiguous: give each phase a unique name", count,
        phase));
  if (count == 0)
    throw DefinitionError(
        fmt::format("there is no phase '{}'{}", phase, did_you_mean(phase, names)));
  return found;
}

void OptimalControlProblem::check_integrals() const {
  std::map<std::string, std::pair<const PhaseDefinition*, double>> first;
  for (const PhaseDefinition& phase : phases_)
    for (const IntegralConstraint& integral : phase.integrals) {
      const auto [it, is_new] =
          first.try_emplace(integral.name, std::pair{&phase, integral.magnitude});
      if (!is_new && it->second.second != integral.magnitude)
        throw DefinitionError(
            fmt::format("phase '{}': integral '{}' continues from phase '{}', where its magnitude "
                        "is {}, not {}",
                        phase.name, integral.name, it->second.first->name, it->second.second,
                        integral.magnitude));
    }
}

void OptimalControlProblem::check_links() const {
  std::set<std::string> names;
  for (const Link& link : links_) {
    const std::string where = fmt::format("problem '{}', link '{}': ", name_, link.name);
    if (link.name.empty()) throw DefinitionError(where + "it has no name");
    if (!names.insert(link.name).second)
      throw DefinitionError(where + "there are two links with this name");
    for (const Link::End& end : link.ends) {
      int j = -1;
      try {
        j = phase_index(end.phase);
      } catch (const DefinitionError& e) {
        throw DefinitionError(where + e.what());
      }
      const Arguments& sizes = phases_[j].sizes;
      if (sizes.nx != end.nx || sizes.np != end.np)
        throw DefinitionError(
            fmt::format("{}it takes {} states and {} parameters of phase '{}', which has {} and {}",
                        where, end.nx, end.np, end.phase, sizes.nx, sizes.np));
    }
    const int rows = link.function.outputs();
    if (link.is_cost) {
      if (rows != 1)
        throw DefinitionError(
            fmt::format("{}a cost must be a scalar, but the formula has {} rows", where, rows));
      continue;
    }
    const std::vector<Bounds>& bounds = link.limits.bounds;
    if (bounds.size() != 1 && static_cast<int>(bounds.size()) != rows)
      throw DefinitionError(fmt::format("{}the formula has {} rows, but {} bounds were given",
                                        where, rows, bounds.size()));
    for (std::size_t i = 0; i < bounds.size(); ++i)
      if (bounds[i].is_empty())
        throw DefinitionError(fmt::format("{}the bounds [{}, {}] of row {} are empty", where,
                                          bounds[i].lower, bounds[i].upper, i));
    if (link.limits.soft)
      if (const std::string error = describe_error(*link.limits.soft); !error.empty())
        throw DefinitionError(where + error);
  }
}

}  // namespace saltus
