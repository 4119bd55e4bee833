// `saltus run NAME` for a problem on a biped: one closed-loop run from settings to results.
#pragma once

#include <string>

#include "problems/biped/configurable_biped.hpp"
#include "saltus/app/program.hpp"
#include "saltus/robots/simulation/simulate.hpp"

namespace saltus::robots::walking {

/// Runs the problem, prints, writes tables and summary, and draws pictures. `default_config`: all
/// settings at their defaults, as YAML.
ExitStatus run_biped(const BipedProblem& problem, const std::string& default_config,
                     const RunContext& context);

/// All keys with their values in `problem`, as YAML.
inline std::string settings_of(ConfigurableBiped& problem) {
  Settings settings;
  problem.declare(settings);
  return settings.to_yaml();
}

/// Entry of a problem whose defaults are those of `Problem{}`.
template <class Problem>
ProblemEntry biped_entry(std::string name, std::string summary) {
  return problem_entry<Problem>(
      std::move(name), std::move(summary),
      +[](Settings& settings, Problem& problem) { problem.declare(settings); },
      [](const Problem& problem, const RunContext& context) {
        Problem defaults;
        return run_biped(problem, settings_of(defaults), context);
      });
}

}  // namespace saltus::robots::walking
