// Laws: transformations that do not change the answer of a problem. Each is a function from problem
// to problem.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "saltus/core/random.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus::metamorphic {

/// A problem to solve.
struct Stated {
  OptimalControlProblem problem;
  ShootingOptions options;
};

/// Ratios of new to old numbers.
struct UnitFactors {
  double time = 1.0;                       ///< factor of durations and times
  std::vector<VectorXd> state{}, input{};  ///< one vector per phase; empty: 1
};

/// A transformed problem and the changes that its answer must show.
struct Transformed {
  Stated stated;
  double cost_factor = 1.0;  ///< ratio of the new cost to the old one
  int moved_state = -1;      ///< index of the start state that moved; -1: none
  double moved_by = 0.0;     ///< in units of that state
  UnitFactors units = {};
  bool is_same_plan = true;  ///< false: only cost and status are compared (the start has moved)
  std::string what = {};     ///< the random numbers of the transformation
};

/// One law. Returns nothing if it does not apply, with the reason in `why`.
struct Law {
  const char* name;
  const char* statement;
  std::optional<Transformed> (*apply)(const Stated& stated, const Solution& base, Random& random,
                                      std::string& why);
};
const std::vector<Law>& laws();

/// The problem with a plan of a transformed one as the guess.
Stated guessed_from(const Stated& stated, const Trajectory& plan,
                    const std::vector<double>& durations, const UnitFactors& units);

/// The problem with edited phases and, if given, other jumps. Throws DefinitionError if the problem
/// has links and jumps.
OptimalControlProblem rebuilt(const OptimalControlProblem& problem,
                              const std::function<void(int, PhaseDefinition&)>& edit,
                              const std::function<Jump(int, const Jump&)>& jump = {});

// --- the laws, one file each
std::optional<Transformed> in_other_units(const Stated&, const Solution&, Random&, std::string&);
std::optional<Transformed> split_in_two(const Stated&, const Solution&, Random&, std::string&);

}  // namespace saltus::metamorphic
