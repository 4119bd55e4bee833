// A problem of the library in closed loop: its plan, made once, is where the controller starts; the
// plant is the problem's own dynamics with another integrator, disturbed.
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
  fitting,    ///< receding for a regulator whose figures do not depend on time, else shrinking
  shrinking,  ///< to the end that the problem has
  receding,   ///< always as long as the problem's
  plan        ///< nothing is solved again: the first plan is run out
};
const char* describe(Horizon horizon);

struct LoopConfig {
  bool run = false;
  Horizon horizon = Horizon::fitting;
  TickMethod method = TickMethod::optimum;
  double period = 0.0;       ///< s; 0: a fiftieth of the plan
  double duration = 0.0;     ///< s; 0: to the problem's end; of a receding horizon twice the plan
  double deadline = 0.0;     ///< wall clock per tick, s; 0: none
  double disturbance = 0.0;  ///< see declare_loop()
  double noise = 0.0;
  int seed = 1;
  Scheme integrator = Scheme::cvodes;
  double integrator_tolerance = 1e-9;
  int plan_every = 10;  ///< ticks
};
/// loop.*, and --loop for the first of them.
void declare_loop(Settings& settings, LoopConfig& loop);

/// A sentence why no loop can be closed over the problem; empty: one can.
std::string why_no_loop(const OptimalControlProblem& problem);
/// `fitting` made definite.
Horizon fitting_horizon(const OptimalControlProblem& problem);

struct LibraryLoop {
  LoopLog log;
  Horizon horizon = Horizon::shrinking;
  double cost = 0.0;  ///< of the motion, see PhasedPlant::cost()
  std::vector<PhasedPlant::Miss> misses_at_ends, misses_on_the_way;
  std::optional<double> over_since;  ///< s; where the last phase ended
};
/// The plan in the same plant, piece by piece, undisturbed: what the loop can be measured against.
struct PlanRunOut {
  double cost = 0.0;
  std::vector<PhasedPlant::Miss> misses_at_ends;
  std::string failure;  ///< a sentence; empty: the plant followed it to its end
};
PlanRunOut run_out(const ReferenceCase& c, const Solution& plan, const IntegratorChoice& scheme);

/// From `plan`, an optimum of the case; `solver` is that of the ticks. Throws DefinitionError when
/// an integrator does not fit the plant.
LibraryLoop close_loop(const ReferenceCase& c, const Solution& plan, SolverChoice solver,
                       const LoopConfig& config);

}  // namespace saltus
