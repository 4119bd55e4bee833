// Everything a run of the push recovery example can be told, with its defaults.
#pragma once

#include <optional>
#include <string>

#include "problems/push_recovery/problem.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/whole_body/inverse_dynamics_controller.hpp"
#include "saltus/robots/whole_body/measured_plant.hpp"
#include "saltus/robots/whole_body/momentum_controller.hpp"
#include "saltus/solver/solver_choice.hpp"

namespace saltus::push_recovery {

enum class ControllerChoice { mpc, capture_point };
enum class PlantChoice { centroidal, dart, mujoco };
enum class WholeBodyChoice { inverse_dynamics, momentum };
enum class Target { sole_midpoint, centroid };
enum class StepTrigger { push, icp };
enum class Placement { predicted, fixed };
enum class PushShape { rectangle, half_sine, triangle };

struct Push {
  double impulse = 7.0;                      ///< N s
  Vec<double, 3> direction{0.0, -1.0, 0.0};  ///< world axes, any length
  double duration = 0.1;                     ///< s
  double start = 2.4;                        ///< s
  PushShape shape = PushShape::rectangle;    ///< of the force over time; the impulse is the same
  /// Whole body: the link of the URDF that is pushed, and where, in its frame, m. The centroidal
  /// model is pushed on its CoM.
  std::string link = "chest";
  Vec<double, 3> point{0.0, 0.0, 0.0};
};

struct Step {
  double duration = 0.6;  ///< from the trigger to the landing, s
  StepTrigger trigger = StepTrigger::push;
  /// The placement is decided this long after the trigger, when the push is known, s.
  double decision_delay = 0.1;
  Placement placement = Placement::predicted;
  /// Of the swing sole relative to the stance sole: forward, and to the side away from it, m.
  Vec<double, 2> fixed_place{0.0, 0.14};
  double lateral_min = 0.12;  ///< reach to the side away from the stance sole, m
  double lateral_max = 0.30;
  double forward_max = 0.25;  ///< reach to the front and back, m
};

struct Config {
  std::string robot_file;  ///< names, postures and limits; empty: iCub's
  std::string urdf;        ///< empty: the figures of robots/icub, or those of robot_file
  PlantChoice plant = PlantChoice::centroidal;
  ControllerChoice controller = ControllerChoice::mpc;
  SolverChoice solver = SolverChoice::riccati;
  Side stance = Side::left;  ///< the foot that it stands on; the other one steps
  bool stepping = true;
  /// Relative error of all masses and inertias in the controllers' model; the plant has none.
  double mass_error = 0.0;
  Target target = Target::sole_midpoint;
  Push push;
  Step step;

  double mpc_step = 0.01;  ///< grid and period of the controller, s
  int mpc_intervals = 15;
  CostRule mpc_costs = CostRule::nodes;
  double solver_tolerance = 1e-8;
  double deadline = 0.0;  ///< wall clock per tick, s; 0: none
  /// To try the loop: this share of the ticks has no time to solve, in runs of one to five.
  double missed_share = 0.0;
  int missed_seed = 1;

  // Contact, both feet.
  double friction = 1.0 / 3.0;
  int friction_edges = 6;
  FrictionPyramid pyramid = FrictionPyramid::inscribed;
  double torsional_friction = 0.0133;  ///< m
  double normal_force_min = 10.0;      ///< N
  double normal_force_max = 1000.0;

  // Whole body.
  double control_period = 0.002;  ///< s
  double plant_step = 0.001;      ///< s
  double ground_friction = 1.0;
  /// Unknown to the controllers: beyond this distance from the stance sole, on the swing foot's
  /// side, the ground is higher (or lower, < 0), m. The lifted swing foot reaches to 0.17 m.
  double ground_step = 0.0, ground_edge = 0.18;
  double joint_friction = 0.0;  ///< viscous, Nm s/rad
  DartCollision collision = DartCollision::bullet;
  DartLcp lcp = DartLcp::dantzig;
  int delay_ticks = 0;     ///< periods of control by which the torques are late
  MeasurementNoise noise;  ///< of what the controllers see
  WholeBodyChoice whole_body_controller = WholeBodyChoice::inverse_dynamics;
  WholeBodyWeights whole_body;
  MomentumOptions momentum;

  Weights weights;
  bool pictures = true;
};

const char* describe(PushShape shape);

/// Binds every key to its field, with units, ranges and rules.
void declare_settings(Settings& settings, Config& config);

/// The contact options of one foot.
ContactConeOptions contact_options(const Config& config, const FootRectangle& foot);

}  // namespace saltus::push_recovery
