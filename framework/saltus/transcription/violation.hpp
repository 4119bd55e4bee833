// Describes which condition of a problem is violated, when, and by how much. Used after failed
// solves.
#pragma once

#include <string>

#include "saltus/solver/solver.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// One clause in the units of the term: "phase 'flight', term 'landing', row 0 at t = 0.8 s misses
/// its bounds by 0.12". Empty if w is feasible.
///
/// A failed solver distributes the violation over terms and defects according to its norm. If
/// defects dominate, the function simulates the inputs from the start, so that the whole violation
/// appears in terms of the user.
std::string describe_violation(ShootingProgram& program, const VectorXd& w);

/// One clause about the contradictory row or bounds found by presolve(), with the time at w.
std::string describe_contradiction(const ShootingProgram& program,
                                   const NlpResult::Contradiction& c, const VectorXd& w);

/// Terms in conflict with the term in `violated`: those with multipliers of the least violation.
/// One clause such as "in conflict with phase 'climb', term 'ceiling'". Empty if the solver found
/// no such multipliers.
std::string describe_conflict(const ShootingProgram& program, const VectorXd& lambda,
                              const std::string& violated);

/// The first phase with events inside (on(), switch_at(), an automaton). Empty if there is none.
std::string first_phase_with_events(const OptimalControlProblem& problem);
/// One clause about the effect of such events on a search without a feasible point.
std::string events_hint(const std::string& phase);

}  // namespace saltus
