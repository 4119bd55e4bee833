// Planners of wrenches, from the measured state to wrenches: their interface, the parts common to
// planners that solve an optimal control problem per tick, and a planner without prediction.
#pragma once

#include <cmath>
#include <memory>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/model/contact_cone.hpp"
#include "saltus/robots/walking/contacts.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/solver/native_solver.hpp"

namespace saltus::robots::walking {

/// Frequency omega of the pendulum (1/s) at a measured height (m), which is limited to at least 1
/// cm.
inline double lipm_frequency(double height) { return pendulum_frequency(std::fmax(height, 0.01)); }
/// Deprecated name.
[[deprecated("use lipm_frequency; removed in 0.4")]] inline double frequency_of_height(
    double height) {
  return lipm_frequency(height);
}

/// Interface of the planner of wrenches.
class Planner {
 public:
  /// Input of a planner in one tick.
  struct Measurement {
    double time = 0.0;                              ///< s
    Vec<double, 9> gamma = Vec<double, 9>::Zero();  ///< CoM m, velocity m/s, angular momentum Nms
    Vec<double, 12> applied =
        Vec<double, 12>::Zero();  ///< wrenches applied last, level sole axes, left and right
    bool left_bore = true, right_bore = true;  ///< true if that foot carried load, so that
                                               ///< `applied` holds its wrench
    Vec<double, 3> contact_force = Vec<double, 3>::Zero();  ///< sum of the contact forces, world
                                                            ///< axes, N
  };

  virtual ~Planner() = default;
  /// Computes the wrenches of left and right foot. `contacts` is the contact schedule, see
  /// contacts.hpp. The result is valid until the next tick.
  virtual const ControlTick& tick(const Measurement& measured, const Scene& scene,
                                  const Schedule& contacts) = 0;
  /// The receding horizon controller, which counts and times the ticks.
  virtual RecedingHorizonController& controller() = 0;
};
/// Deprecated name.
using Measurement [[deprecated("use Planner::Measurement; removed in 0.4")]] = Planner::Measurement;

/// Options of the model predictive controller.
struct PlannerSettings {
  SolverChoice solver = SolverChoice::riccati;  ///< solver of a tick
  double tolerance = 1e-8;                      ///< solver tolerance, scaled KKT error
  double step = 0.01;                           ///< grid and period of the controller, s
  int intervals = 15;                           ///< number of intervals of the horizon
  CostRule costs = CostRule::nodes;             ///< sums at the nodes, as in the paper
  double deadline = 0.0;                        ///< wall clock per tick, s; 0: none
  /// For tests of the loop: fraction of the ticks in which the solver has no time. These ticks come
  /// in runs of one to five.
  double missed_fraction = 0.0;
  int missed_seed = 1;  ///< seed of the missed ticks
};

/// Options whose fallback, if there is no plan, puts the robot's weight on the initial stance foot.
ControllerOptions controller_options(const PlannerSettings& settings, double mass, Side stance);
/// Controller of a problem with one phase, `intervals` intervals and affine dynamics. `mass` of the
/// robot, kg.
RecedingHorizonController make_tick_controller(OptimalControlProblem problem, int intervals,
                                               const PlannerSettings& settings, double mass,
                                               Side stance = Side::left);

/// Limits of the contact wrench of one foot.
struct ContactSettings {
  double friction = 1.0 / 3.0;  ///< Coulomb friction coefficient
  int edges = 6;                ///< edges of the friction pyramid
  ContactCone::Pyramid pyramid = ContactCone::Pyramid::inscribed;  ///< inscribed or circumscribed
  double torsional_friction = 0.0133;                              ///< m
  bool corners = false;              ///< limit torsion to the forces at the foot's corners
  double normal_force_min = 10.0;    ///< N
  double normal_force_max = 1000.0;  ///< N per foot
};

/// Options of the contact cone of one foot.
ContactCone::Options cone_options(const ContactSettings& contact, const FootRectangle& foot);

/// Gains of the capture-point controller.
struct CapturePointGains {
  double after_landing = 0.8;     ///< end of the CoM trajectory after the landing, s
  double com_stiffness = 50.0;    ///< 1/s^2
  double com_damping = 14.1;      ///< 1/s
  double momentum_damping = 5.0;  ///< 1/s
};

/// Momentum control as in section 2.1 of the paper, without a horizon. The CoM tracks a
/// minimum-jerk trajectory to the target by PD control of its position. Until the landing, the
/// trajectory is planned anew from the current state in every tick. Angular momentum is damped. One
/// quadratic program per tick gives the wrenches, with the same contact cones as the receding
/// horizon controller.
std::unique_ptr<Planner> make_capture_point_controller(
    const CapturePointGains& gains, const PlannerSettings& settings, const ContactSettings& contact,
    const RobotDescription& robot, const Scene& scene, const Schedule& contacts);

}  // namespace saltus::robots::walking
