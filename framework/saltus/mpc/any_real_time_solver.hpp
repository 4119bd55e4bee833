// All solvers of a control loop by name, for programs that let their users choose. Needs Ipopt.
//
//     auto controller = make_controller(MultipleShooting(problem, grid),
//                                       {.solver = SolverChoice::riccati}, {.period = 0.01});
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/mpc/shrinking_horizon.hpp"
#include "saltus/qp/riccati_solver.hpp"
#include "saltus/solver/solver_choice.hpp"

namespace saltus {

/// What a tick is for.
enum class TickMethod {
  step,    ///< the real-time iteration: one quadratic model, made ahead of the measurement
  optimum  ///< the program is solved, after the measurement, and whatever that takes
};
/// As users write them, for Settings::choice().
const std::vector<std::pair<std::string, TickMethod>>& tick_methods();

/// What every solver of a control loop can be asked for.
struct RealTimeChoice {
  SolverChoice solver = SolverChoice::riccati;  ///< what solves the program of a tick
  TickMethod method = TickMethod::step;         ///< Ipopt knows no steps: it always solves
  double tolerance = 1e-8;                      ///< of the quadratic model, or scaled KKT error
  int max_iterations = 0;                       ///< per tick; 0: the solver's own limit
  /// See RealTimeIterationOptions::kernels; of no use elsewhere.
  std::span<const qp::RiccatiKernel> kernels = {};
};
/// For the program of this transcription and no other. Throws DefinitionError when the program does
/// not fit the solver.
std::unique_ptr<RealTimeSolver> make_real_time_solver(MultipleShooting& shooting,
                                                      const RealTimeChoice& choice = {});
/// The controllers with such a solver: of a horizon that moves on, and of one that shrinks.
RecedingHorizonController make_controller(MultipleShooting shooting, const RealTimeChoice& choice,
                                          ControllerOptions options);
/// A controller for the problem with this choice of solver.
ShrinkingHorizonController make_controller(const OptimalControlProblem& problem,
                                           const ShootingOptions& grid,
                                           const RealTimeChoice& choice,
                                           const ControllerOptions& options);

}  // namespace saltus
