// The outcome of a case of the library as numbers that can be printed, stored and compared.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "problems/library/checked_value.hpp"

namespace saltus {

enum class Verdict {
  met,             ///< every checked value is within its tolerance
  missed,          ///< the solver finished, but a checked value is not
  failed,          ///< the solver did not converge
  skipped,         ///< external data are absent; the reason names them
  not_applicable,  ///< the solver does not support the problem
};
/// Word in tables: "ok", "MISSED", "FAILED", "skipped", "n/a".
const char* word_for(Verdict verdict);

struct CaseOutcome {
  std::string id, name, exercises, source;
  bool is_simulation = false;  ///< no solver is used
  Verdict verdict = Verdict::failed;
  std::string status;  ///< sentence of the solver, or the reason why the case did not run
  /// All compared values. The table shows the first one: the cost, or for simulations the value
  /// that is nearest to its tolerance.
  std::vector<CheckedValue> checked;
  /// Largest violation of a path constraint between the nodes, in units of the constraint; absent:
  /// unknown.
  std::optional<double> between_nodes;
  /// Number of grid refinements because of violated path constraints between the nodes.
  int refinements = 0;
  int iterations = 0;    ///< total of all grids, like the seconds
  double seconds = 0.0;  ///< wall-clock time of the solver, or of the whole simulation

  bool is_wrong() const { return verdict == Verdict::missed || verdict == Verdict::failed; }
  /// One sentence per checked value outside its tolerance; the status if the solver failed.
  std::vector<std::string> reasons() const;
  /// The first of these sentences, and the names of the other values outside their tolerance.
  std::string reason_in_brief() const;
  /// "refined once: ..."; empty if the grid was not refined.
  std::string refined_in_words() const;
};

/// Returns met or missed, depending on the checked values.
Verdict judge(const std::vector<CheckedValue>& checked);
/// Moves the value that is nearest to its tolerance to the front.
void bring_worst_to_front(std::vector<CheckedValue>& checked);

}  // namespace saltus
