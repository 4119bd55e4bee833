#include "saltus/solve/explain.hpp"

#include <utility>

#include "saltus/solve/negotiable_constraints.hpp"
#include "saltus/solve/remedies.hpp"
#include "saltus/solve/soft_terms.hpp"
#include "saltus/solve/solve_budget.hpp"
#include "saltus/transcription/violation.hpp"

namespace saltus {
namespace {

LeastRelaxation relax(const OptimalControlProblem& problem, const ExplainOptions& options,
                      SolveBudget& solves) {
  LeastRelaxation relaxed = solves.relax(problem);
  if (!options.guess) return relaxed;
  LeastRelaxation other = solves.relax(problem, &*options.guess);
  return other.amount < relaxed.amount - smallest_relaxation ? std::move(other)
                                                             : std::move(relaxed);
}

}  // namespace

Explanation explain(const OptimalControlProblem& problem, const ExplainOptions& options) {
  SolveBudget solves(options);
  Explanation explanation;
  LeastRelaxation relaxed = relax(problem, options, solves);
  explanation.status = relaxed.result.status;
  if (relaxed.ok()) {
    explanation.relaxation = relaxed.amount;
    explanation.trajectory = relaxed.trajectory();
    if (relaxed.is_needed()) {
      RelaxedConstraints gives = relaxed_constraints(relaxed);
      if (options.remedies > 0)
        explanation.remedies = find_remedies(problem, relaxed, gives, options.remedies, solves);
      explanation.shortages = std::move(gives.shortages);
      explanation.events_in = first_phase_with_events(problem);
    } else if (options.soft_terms) {
      explain_soft_terms(problem, options.remedies, solves, explanation);
    }
  }
  explanation.solves = solves.count();
  explanation.seconds = solves.seconds();
  return explanation;
}

}  // namespace saltus
