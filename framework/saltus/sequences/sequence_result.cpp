#include "saltus/sequences/search.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {

const char* describe(SequenceResult::Guarantee guarantee) {
  switch (guarantee) {
    case SequenceResult::Guarantee::optimal:
      return "no other sequence costs less, within the requested gap";
    case SequenceResult::Guarantee::bounded:
      return "no sequence costs less than the bound, but the gap to it is open";
    case SequenceResult::Guarantee::enumerated:
      return "every allowed sequence was solved to a local optimum or excluded by a prefix";
    case SequenceResult::Guarantee::incomplete:
      return "the search stopped early: unexplored sequences may cost less";
    case SequenceResult::Guarantee::infeasible:
      return "no sequence is feasible";
    case SequenceResult::Guarantee::inconclusive:
      return "inconclusive: no sequence was confirmed, and not all were proved infeasible";
    case SequenceResult::Guarantee::contradicted:
      return "the search and a solve of a sequence contradict each other";
  }
  return "unknown";
}

double SequenceResult::gap() const {
  if (!found() || lower_bound == -infinity) return infinity;
  return std::max(0.0, cost - lower_bound) / std::max(std::abs(cost), least_cost);
}

}  // namespace saltus
