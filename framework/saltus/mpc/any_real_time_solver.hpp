// Creates any solver of a control loop by name, for applications with a solver option. Needs Ipopt.
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
#include "saltus/qp/stage_qp.hpp"
#include "saltus/solver/native_solver.hpp"

namespace saltus {

/// Options that every solver of a control loop supports.
struct RealTimeChoice {
  /// Method of a tick.
  enum class Method {
    step,    ///< real-time iteration: one quadratic model, prepared before the measurement
    optimum  ///< full solve after the measurement, without a limit on its duration
  };

  SolverChoice solver = SolverChoice::riccati;  ///< solver of the program of a tick
  Method method = Method::step;                 ///< Ipopt always solves to the optimum
  double tolerance = 1e-8;  ///< tolerance of the QP solver, or of the scaled KKT error
  int max_iterations = 0;   ///< per tick; 0: the default of the solver
  /// See RealTimeIterationOptions::kernels; other methods ignore it.
  std::span<const qp::RiccatiKernel> kernels = {};
};
/// Names in settings, for Settings::choice().
const std::vector<std::pair<std::string, RealTimeChoice::Method>>& tick_methods();
/// For the program of this transcription only. Throws DefinitionError if the program does not fit
/// the solver.
std::unique_ptr<RealTimeSolver> make_real_time_solver(MultipleShooting& shooting,
                                                      const RealTimeChoice& choice = {});
/// Controller with such a solver and a receding horizon.
RecedingHorizonController make_controller(MultipleShooting shooting, const RealTimeChoice& choice,
                                          ControllerOptions options);
/// Controller with such a solver and a shrinking horizon.
ShrinkingHorizonController make_controller(const OptimalControlProblem& problem,
                                           const ShootingOptions& grid,
                                           const RealTimeChoice& choice,
                                           const ControllerOptions& options);

}  // namespace saltus
