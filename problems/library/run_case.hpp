// Solves a case of the library with a given solver and compares the result with the known values.
#pragma once

#include <memory>

#include "problems/library/case_outcome.hpp"
#include "problems/library/reference_case.hpp"
#include "problems/library/simulation_case.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/between_nodes.hpp"

namespace saltus {

/// Scaled KKT error of the solvers: two orders smaller than the tolerance of the costs, so that the
/// test measures the transcription.
inline constexpr double library_solver_tolerance = 1e-10;
/// Tolerance of the independent residual, which is not scaled by rows.
inline constexpr double library_kkt_limit = 100.0 * library_solver_tolerance;

/// Creates a solver with the options of the suite.
std::unique_ptr<Solver> make_case_solver(SolverChoice choice, int max_iterations);

/// Solves the case cold, from its guess.
Solution solve_case(const ReferenceCase& c, SolverChoice choice = SolverChoice::ipopt,
                    const SolveObserver& observer = {});

/// Compares cost, switching times, KKT residual, violations between the nodes, the replay with a
/// tighter integrator, and the other known values of the case.
CaseOutcome check_case(const ReferenceCase& c, const Solution& solution);

/// Solves the case cold and refines the grid by solve_refined() while the plan violates a path
/// constraint between the nodes by more than the case permits; at most `rounds` solves.
RefinedSolution solve_case_refined(const ReferenceCase& c,
                                   SolverChoice choice = SolverChoice::ipopt,
                                   int rounds = RefinementOptions{}.rounds,
                                   const SolveObserver& observer = {});
CaseOutcome check_case(const ReferenceCase& c, const RefinedSolution& refined);

/// Solves and compares. The outcome is not_applicable if the definition does not fit the solver;
/// never throws DefinitionError.
CaseOutcome run_case(const ReferenceCase& c, SolverChoice choice = SolverChoice::ipopt,
                     const SolveObserver& observer = {});
CaseOutcome run_case(const SimulationCase& c);

}  // namespace saltus
