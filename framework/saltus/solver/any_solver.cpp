#include "saltus/solver/ipopt.hpp"

#include "saltus/solver/native_solver.hpp"

namespace saltus {

std::unique_ptr<Solver> make_solver(SolverChoice choice, const SolverLimits& limits) {
  if (choice == SolverChoice::ipopt)
    return make_ipopt({.tolerance = limits.tolerance,
                       .max_iterations = limits.max_iterations,
                       .time_limit = limits.time_limit});
  return make_native_solver({.tolerance = limits.tolerance,
                             .max_iterations = limits.max_iterations,
                             .time_limit = limits.time_limit,
                             .qp = qp_method(choice)});
}

}  // namespace saltus
