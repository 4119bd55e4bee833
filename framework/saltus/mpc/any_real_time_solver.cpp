#include "saltus/mpc/any_real_time_solver.hpp"

#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"

namespace saltus {
namespace {

std::unique_ptr<RealTimeSolver> whole_solve_by_ipopt(NonlinearProgram& program,
                                                     const RealTimeChoice& choice) {
  IpoptOptions options{.tolerance = choice.tolerance, .mehrotra = program.is_linear_quadratic()};
  if (choice.max_iterations > 0) options.max_iterations = choice.max_iterations;
  return make_real_time_solver(make_ipopt(options));
}

std::unique_ptr<RealTimeSolver> whole_solve_by_sqp(const RealTimeChoice& choice) {
  NativeSolverOptions options{.tolerance = choice.tolerance, .qp = qp_method(choice.solver)};
  if (choice.max_iterations > 0) options.max_iterations = choice.max_iterations;
  return make_real_time_solver(make_native_solver(options), /*use_multipliers=*/true);
}

std::unique_ptr<RealTimeSolver> iteration(NonlinearProgram& program, const RealTimeChoice& choice) {
  RealTimeIterationOptions options{.tolerance = choice.tolerance, .kernels = choice.kernels};
  if (choice.max_iterations > 0) options.max_iterations = choice.max_iterations;
  // The default solver of the iteration fills the stages of a shooting program directly.
  if (choice.solver != SolverChoice::riccati) options.qp = qp_method(choice.solver);
  return make_real_time_iteration(program, std::move(options));
}

}  // namespace

const std::vector<std::pair<std::string, RealTimeChoice::Method>>& tick_methods() {
  static const std::vector<std::pair<std::string, RealTimeChoice::Method>> methods{
      {"step", RealTimeChoice::Method::step}, {"optimum", RealTimeChoice::Method::optimum}};
  return methods;
}

std::unique_ptr<RealTimeSolver> make_real_time_solver(MultipleShooting& shooting,
                                                      const RealTimeChoice& choice) {
  if (choice.solver == SolverChoice::ipopt) return whole_solve_by_ipopt(shooting.nlp(), choice);
  return choice.method == RealTimeChoice::Method::optimum ? whole_solve_by_sqp(choice)
                                                          : iteration(shooting.nlp(), choice);
}

RecedingHorizonController make_controller(MultipleShooting shooting, const RealTimeChoice& choice,
                                          ControllerOptions options) {
  auto solver = make_real_time_solver(shooting, choice);
  return {std::move(shooting), std::move(solver), std::move(options)};
}

ShrinkingHorizonController make_controller(const OptimalControlProblem& problem,
                                           const ShootingOptions& grid,
                                           const RealTimeChoice& choice,
                                           const ControllerOptions& options) {
  return {problem, remaining_controllers(problem, grid, [&](MultipleShooting rest) {
            return make_controller(std::move(rest), choice, options);
          })};
}

}  // namespace saltus
