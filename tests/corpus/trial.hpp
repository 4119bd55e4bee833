// One trial of the corpus: a problem, its known answer, and the verdict on the solver's result.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "saltus/core/random.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/native_solver.hpp"
#include "tests/corpus/outside.hpp"

namespace saltus::corpus {

/// Outcome of a trial.
enum class Outcome {
  right,       ///< ok() and the plan is right
  reported,    ///< not ok() and correct: there is no solution, or the plan is wrong
  wrong,       ///< ok() and the plan is wrong: a silent wrong answer
  unreported,  ///< ok() and right at the nodes, but the flow amplifies errors and the ends are
               ///< missed without any warning
  refused,     ///< not ok(), although the returned plan is right
  unsolved,    ///< not ok() and the plan is wrong, although a solution exists
};

struct Verdict {
  Outcome outcome = Outcome::reported;
  std::string reason;  ///< one sentence
  /// The open-loop end errors exceed their tolerance but are within the stated accuracy of the
  /// integration.
  bool is_imprecise = false;
};

/// A problem with the information for the judge.
struct Instance {
  OptimalControlProblem problem;
  SolveOptions options;
  std::vector<OutsidePhase> phases;
  bool is_solvable = true;          ///< false: the right answer is not ok()
  bool may_be_either = false;       ///< both answers about solvability are right
  bool is_kkt_judged = true;        ///< false: single shooting is meaningless (unstable flows)
  std::optional<double> optimum;    ///< the least cost in closed form
  double optimum_tolerance = 1e-3;  ///< relative to the optimum
  double cost_scale = 0.0;          ///< size of costs that can be zero at the plan
  double amplification = 1.0;       ///< growth factor over the horizon of an error at the start
  /// Additional check of an ok() answer. Returns the error, or empty if the answer is right.
  std::function<std::string(const Solution&)> further;
  /// Replaces solve() and all checks above.
  std::function<Verdict(SolverChoice)> run;
};

/// A family of random problems.
struct CorpusClass {
  const char* name;
  const char* ranges;  ///< drawn ranges, for the table
  int full, gate;      ///< numbers of trials
  Instance (*make)(Random& random);
};
const std::vector<CorpusClass>& corpus_classes();

/// Solves and judges. Never throws.
Verdict run_trial(const CorpusClass& family, std::uint64_t seed,
                  std::optional<SolverChoice> choice);

// --- the classes, one file each
Instance tiny_start(Random& random);
Instance idle_bounds(Random& random);
Instance penalty_weights(Random& random);
Instance constant_rows(Random& random);
Instance mode_searches(Random& random);
Instance pillars(Random& random);
Instance thin_walls(Random& random);
Instance unstable_horizons(Random& random);
Instance aliasing(Random& random);
Instance higher_order(Random& random);
Instance scales(Random& random);
Instance near_infeasible(Random& random);
Instance hybrid_events(Random& random);
Instance split_phases(Random& random);

}  // namespace saltus::corpus
