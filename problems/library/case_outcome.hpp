// What came out of a case of the library, in figures that can be printed, kept and compared.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "problems/library/checked_value.hpp"

namespace saltus {

enum class Verdict {
  met,             ///< every checked value is within its tolerance
  missed,          ///< the solver finished, but a checked value is not
  failed,          ///< the solver gave up
  skipped,         ///< something from outside is absent, and the reason says what
  not_applicable,  ///< not a problem for this solver
};
/// A word for tables: "ok", "MISSED", "FAILED", "skipped", "n/a".
const char* word_for(Verdict verdict);

struct CaseOutcome {
  std::string id, name, exercises, source;
  bool is_simulation = false;  ///< no solver took part
  Verdict verdict = Verdict::failed;
  std::string status;  ///< a sentence of the solver, or why the case did not run
  /// Everything that was compared; first what the table shows: the cost, of simulations the value
  /// that comes nearest to its tolerance.
  std::vector<CheckedValue> checked;
  /// Largest violation of a path constraint between the nodes, in its own units; absent: unknown.
  std::optional<double> between_nodes;
  /// Grids that were made finer, because the plan went beyond a path constraint between the nodes.
  int refinements = 0;
  int iterations = 0;    ///< on all grids, like the seconds
  double seconds = 0.0;  ///< wall clock of the solver, of simulations of everything

  bool is_wrong() const { return verdict == Verdict::missed || verdict == Verdict::failed; }
  /// A sentence for each checked value outside its tolerance; of failures the status.
  std::vector<std::string> reasons() const;
  /// The first of them, and the names of what else is outside its tolerance.
  std::string reason_in_brief() const;
  /// "refined once: ...", empty: not refined.
  std::string refined_in_words() const;
};

/// met or missed, by the checked values.
Verdict judge(const std::vector<CheckedValue>& checked);
/// Puts the value first that comes nearest to its tolerance.
void bring_worst_to_front(std::vector<CheckedValue>& checked);

}  // namespace saltus
