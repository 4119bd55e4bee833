// The controllers behind one interface, from the measured state to wrenches, and what those that
// solve an optimal control problem per tick have in common.
#pragma once

#include <cmath>
#include <memory>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/contacts.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/solver/native_solver.hpp"

namespace saltus::walking {

/// omega of the pendulum (1/s) at a height that was measured (m), whatever it is: never below 1 cm.
inline double frequency_of_height(double height) {
  return pendulum_frequency(std::fmax(height, 0.01));
}

/// What a controller knows about a tick.
struct Measurement {
  double time = 0.0;                              ///< s
  Vec<double, 9> gamma = Vec<double, 9>::Zero();  ///< CoM m, velocity m/s, angular momentum Nms
  Vec<double, 12> applied =
      Vec<double, 12>::Zero();  ///< wrenches applied last, level sole axes, left and right
  bool left_bore = true, right_bore = true;  ///< did that foot stand before now, to have one?
  Vec<double, 3> contact_force = Vec<double, 3>::Zero();  ///< their sum, world axes, N
};

/// What a tick needs from the model predictive controller of a biped.
class Planner {
 public:
  virtual ~Planner() = default;
  /// `contacts`: which feet stand when, see contacts.hpp. The result, wrenches of left and right
  /// foot, lasts until the next tick.
  virtual const ControlTick& tick(const Measurement& measured, const Scene& scene,
                                  const Schedule& contacts) = 0;
  /// For what it counts.
  virtual RecedingHorizonController& controller() = 0;
};

/// Of the model predictive controller.
struct PlannerSettings {
  SolverChoice solver = SolverChoice::riccati;  ///< what solves a tick
  double tolerance = 1e-8;                      ///< of the solver, scaled KKT error
  double step = 0.01;                           ///< grid and period of the controller, s
  int intervals = 15;                           ///< of the horizon
  CostRule costs = CostRule::nodes;             ///< sums at the nodes, as in the paper
  double deadline = 0.0;                        ///< wall clock per tick, s; 0: none
  /// To try the loop: this fraction of the ticks has no time to solve, in runs of one to five.
  double missed_fraction = 0.0;
  int missed_seed = 1;  ///< of the random ticks that are left out
};

/// A planner without a plan puts the robot's weight on the foot that stands at the start.
ControllerOptions controller_options(const PlannerSettings& settings, double mass, Side stance);
/// The controller of a problem with one phase of so many intervals, its dynamics affine. `mass` of
/// the robot, kg.
RecedingHorizonController make_tick_controller(OptimalControlProblem problem, int intervals,
                                               const PlannerSettings& settings, double mass,
                                               Side stance = Side::left);

}  // namespace saltus::walking
