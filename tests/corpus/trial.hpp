// One trial of the corpus: a problem, what is known of its answer, and the verdict on what the
// solver said.
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
  right,    ///< ok() and right
  said,     ///< not ok(), and rightly so: there is no solution, or the plan is not right
  wrong,    ///< ok() and wrong: a silent wrong answer
  unsaid,   ///< ok(), right at the nodes, and the flow enlarges errors so that the ends are missed;
            ///< nothing says so
  refused,  ///< not ok(), although the returned plan is right
  unsolved,  ///< not ok(), the plan is not right, but there is a solution
};

struct Verdict {
  Outcome outcome = Outcome::said;
  std::string reason;  ///< one sentence
  /// The ends are missed in open loop by more than their tolerance, within the stated accuracy of
  /// the integration.
  bool is_imprecise = false;
};

/// A problem with what the judge needs.
struct Instance {
  OptimalControlProblem problem;
  SolveOptions options;
  std::vector<OutsidePhase> phases;
  bool is_solvable = true;          ///< false: not ok() is the right answer
  bool may_be_either = false;       ///< neither answer is wrong as far as solvability goes
  bool is_kkt_judged = true;        ///< false: single shooting means nothing (unstable flows)
  std::optional<double> optimum;    ///< the least cost, by closed form
  double optimum_tolerance = 1e-3;  ///< relative to it
  double cost_scale = 0.0;          ///< of costs that may be zero at the plan
  double amplification = 1.0;       ///< of an error at the start over the horizon
  /// More to ask of an answer that is ok(); empty: right.
  std::function<std::string(const Solution&)> further;
  /// Replaces solve() and all of the above.
  std::function<Verdict(SolverChoice)> run;
};

/// A family of random problems.
struct CorpusClass {
  const char* name;
  const char* ranges;  ///< what is drawn, for the table
  int full, gate;      ///< trials
  Instance (*make)(Random& random);
};
const std::vector<CorpusClass>& corpus_classes();

/// Solves and judges; never throws.
Verdict run_trial(const CorpusClass& family, std::uint64_t seed,
                  std::optional<SolverChoice> choice);

// --- the classes, a file each
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
