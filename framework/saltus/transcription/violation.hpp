// Which condition of a problem cannot be met, when, and by how much? For solves that failed.
#pragma once

#include <string>

#include "saltus/solver/solver.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// One clause, "phase 'flight', term 'landing', row 0 at t = 0.8 s misses its bounds by 0.12", in
/// the units of the term, or an empty string if w meets everything.
///
/// A solver that gives up spreads what is missing over terms and gaps of the dynamics as suits its
/// norm. Where the gaps are largest they are closed by simulating the inputs from the start, so
/// that all of it shows in the terms that the user wrote.
std::string name_violation(ShootingProgram& program, const VectorXd& w);

/// Which row or bounds presolve() found that nothing meets, with the time at w, one clause.
std::string name_contradiction(const ShootingProgram& program, const Contradiction& c,
                               const VectorXd& w);

/// What cannot be met together with the term that `violated` names: terms that hold back the least
/// violation, by its multipliers. "in conflict with phase 'climb', term 'ceiling'", or an empty
/// string where no solver found such multipliers.
std::string name_conflict(const ShootingProgram& program, const VectorXd& lambda,
                          const std::string& violated);

/// The first phase with events inside (on(), switch_at(), an automaton), or an empty string.
std::string phase_with_events(const OptimalControlProblem& problem);
/// What such events do to a search that found no point, one clause.
std::string events_hint(const std::string& phase);

}  // namespace saltus
