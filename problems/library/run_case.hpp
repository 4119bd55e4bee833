// Solves a case of the library with a solver of choice and compares everything that is known of it.
#pragma once

#include <memory>

#include "problems/library/case_outcome.hpp"
#include "problems/library/reference_case.hpp"
#include "problems/library/simulation_case.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/solver/solver_choice.hpp"
#include "saltus/transcription/between_nodes.hpp"

namespace saltus {

/// Scaled KKT error asked of the solvers: two orders below the accuracy asked of the costs, so that
/// what is measured is the transcription.
inline constexpr double library_solver_tolerance = 1e-10;
/// Of our own residual, which is not scaled by rows.
inline constexpr double library_kkt_limit = 100.0 * library_solver_tolerance;

/// A solver as the suite asks for it.
std::unique_ptr<Solver> make_case_solver(SolverChoice choice, int max_iterations);

/// Cold, from the case's own guess.
Solution solve_case(const ReferenceCase& c, SolverChoice choice = SolverChoice::ipopt,
                    const SolveObserver& observer = {});

/// Compares cost, switching times, KKT residual, violations between the nodes, the replay with a
/// tighter integrator, and whatever else the case knows.
CaseOutcome check_case(const ReferenceCase& c, const Solution& solution);

/// Cold too, on a grid that solve_refined() makes finer while the plan goes further beyond a path
/// constraint between the nodes than the case allows; `rounds` solves at most.
RefinedSolution solve_case_refined(const ReferenceCase& c,
                                   SolverChoice choice = SolverChoice::ipopt,
                                   int rounds = RefinementOptions{}.rounds,
                                   const SolveObserver& observer = {});
CaseOutcome check_case(const ReferenceCase& c, const RefinedSolution& refined);

/// Both of them. A definition that does not fit the solver is not_applicable; never throws
/// DefinitionError.
CaseOutcome run_case(const ReferenceCase& c, SolverChoice choice = SolverChoice::ipopt,
                     const SolveObserver& observer = {});
CaseOutcome run_case(const SimulationCase& c);

}  // namespace saltus
