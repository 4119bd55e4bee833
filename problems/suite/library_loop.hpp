// A library problem in closed loop. The controller starts from a plan that is computed once; the
// plant has the dynamics of the problem, another integrator, and disturbances.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "problems/library/reference_case.hpp"
#include "problems/suite/integrator_names.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/mpc/any_real_time_solver.hpp"
#include "saltus/simulation/closed_loop.hpp"

namespace saltus {

enum class Horizon {
  fitting,    ///< receding for a time-invariant regulator, otherwise shrinking
  shrinking,  ///< until the end of the problem
  receding,   ///< with the length of the problem
  plan        ///< no further solve: the first plan is followed to its end
};
const char* describe(Horizon horizon);

struct LoopConfig {
  bool run = false;
  Horizon horizon = Horizon::fitting;
  RealTimeChoice::Method method = RealTimeChoice::Method::optimum;
  double period = 0.0;  ///< s; 0: 1/50 of the duration of the plan
  /// s; 0: to the end of the problem, or twice the duration of the plan for a receding horizon
  double duration = 0.0;
  double deadline = 0.0;     ///< wall clock per tick, s; 0: none
  double disturbance = 0.0;  ///< see declare_loop()
  double noise = 0.0;
  int seed = 1;
  Scheme integrator = Scheme::cvodes;
  double integrator_tolerance = 1e-9;
  int plan_every = 10;           ///< ticks
  std::string live_folder = {};  ///< see LoopOptions; not a setting
};
/// Declares the keys loop.*; --loop sets the first of them.
void declare_loop(Settings& settings, LoopConfig& loop);

/// The reason why the problem has no closed loop; empty if it has one.
std::string why_no_loop(const OptimalControlProblem& problem);
/// Resolves `fitting` to one of the other values.
Horizon fitting_horizon(const OptimalControlProblem& problem);

struct LibraryLoop {
  LoopLog log;
  Horizon horizon = Horizon::shrinking;
  double cost = 0.0;  ///< cost of the motion, see PhasedPlant::cost()
  std::vector<PhasedPlant::Miss> end_misses, path_misses;
  std::optional<double> over_since;  ///< s; end of the last phase
};
/// The plan in the same plant without disturbances, as a reference for the loop.
struct PlanRunOut {
  double cost = 0.0;
  std::vector<PhasedPlant::Miss> end_misses;
  std::string failure;  ///< one sentence; empty if the plant followed the plan to its end
};
PlanRunOut run_out(const ReferenceCase& c, const Solution& plan, const IntegratorChoice& scheme);

/// Starts from `plan`, an optimum of the case; `solver` solves the ticks. Throws DefinitionError if
/// an integrator does not fit the plant.
LibraryLoop close_loop(const ReferenceCase& c, const Solution& plan, SolverChoice solver,
                       const LoopConfig& config);

}  // namespace saltus
