#include "problems/push_recovery/config.hpp"

#include <fmt/format.h>

#include <cmath>

namespace saltus::push_recovery {
namespace {

void declare_weights(Settings& s, Weights& w) {
  s.vector("weights.gamma", w.gamma, "", "on CoM, CoM velocity and angular momentum, all along",
           at_least(0.0));
  s.vector("weights.gamma_impact", w.gamma_impact, "",
           "the same, added after the impact and at "
           "the end of the horizon",
           at_least(0.0));
  s.vector("weights.wrench", w.wrench, "", "on force (N) and torque (Nm) of each foot",
           at_least(0.0));
  s.vector("weights.capture_point", w.capture_point, "", "on the capture point after the impact",
           at_least(0.0));
  s.vector("weights.capture_point_standing", w.capture_point_standing, "",
           "on the capture point as long as no step is planned", at_least(0.0));
  s.number("weights.wrench_change", w.wrench_change, "", "on first differences of the wrenches",
           at_least(0.0));
  s.number("weights.capture_point_penalty", w.capture_point_penalty, "1/(m s)",
           "price of a capture point outside the hull; 0 forbids it", at_least(0.0));
}

void declare_noise(Settings& s, MeasurementNoise& n) {
  s.number("noise.position", n.position, "m", "whole body: standard deviation, base's position",
           at_least(0.0));
  s.number("noise.angle", n.angle, "rad", "whole body: base's orientation and joints",
           at_least(0.0));
  s.number("noise.velocity", n.velocity, "m/s",
           "whole body: base's velocity, as an estimator leaves it", at_least(0.0));
  s.number("noise.angular_velocity", n.angular_velocity, "rad/s",
           "whole body: angular velocity of the base, velocities of the joints, likewise",
           at_least(0.0));
  s.number("noise.force", n.force, "",
           "whole body: relative, wrenches measured at the feet; only the landing is told by them",
           at_least(0.0));
  s.integer("noise.seed", n.seed, "", "which noise", at_least(0.0));
}

bool is_multiple(double whole, double part) {
  constexpr double rounding = 1e-6;  // of decimals that have no exact binary form
  const double ratio = whole / part;
  return ratio > 0.5 && std::abs(ratio - std::round(ratio)) < rounding * ratio;
}

// The loop on the whole body counts steps of the engine: every period is a whole number of them.
std::string clock_complaint(const Config& c) {
  if (c.plant == PlantChoice::centroidal) return "";
  if (!is_multiple(c.control_period, c.plant_step))
    return fmt::format("control.period ({} s) must be a whole multiple of simulator.step ({} s)",
                       c.control_period, c.plant_step);
  if (!is_multiple(c.mpc_step, c.control_period))
    return fmt::format("mpc.step ({} s) must be a whole multiple of control.period ({} s)",
                       c.mpc_step, c.control_period);
  return "";
}

}  // namespace

const char* describe(PushShape shape) {
  constexpr const char* names[] = {"rectangle", "half_sine", "triangle"};
  return names[static_cast<int>(shape)];
}

void declare_settings(Settings& s, Config& c) {
  s.choice<PlantChoice>(
      "plant", c.plant,
      {{"centroidal", PlantChoice::centroidal},
       {"dart", PlantChoice::dart},
       {"mujoco", PlantChoice::mujoco}},
      "what is pushed: the centroidal model, or the whole body in DART or MuJoCo");
  s.text("robot.urdf", c.urdf,
         "URDF of the robot; empty: the official model if it was fetched, else the "
         "figures that come with the program");
  s.alias("urdf", "robot.urdf");
  s.text("robot.config", c.robot_file,
         "file that names soles, base, joints, limits and postures of the robot "
         "(robots/README.md); empty: iCub's");
  s.choice<ControllerChoice>(
      "controller", c.controller,
      {{"mpc", ControllerChoice::mpc}, {"capture_point", ControllerChoice::capture_point}},
      "receding horizon, or the capture-point controller without prediction");
  s.choice<SolverChoice>(
      "solver", c.solver, solver_choices(),
      "solver of the optimal control problem: stage by stage, one sparse system, "
      "or as a nonlinear program");
  s.choice<Side>("stance", c.stance, {{"left", Side::left}, {"right", Side::right}},
                 "the foot that it stands on; the other one steps");
  s.flag("stepping", c.stepping, "may the robot step?");
  s.number("model.mass_error", c.mass_error, "",
           "relative error of all masses and inertias in the controllers' model",
           between(-0.5, 1.0));
  s.choice<Target>("target", c.target,
                   {{"sole_midpoint", Target::sole_midpoint}, {"centroid", Target::centroid}},
                   "where the CoM shall come to rest after the step");

  s.number("push.impulse", c.push.impulse, "N s", "size of the push", at_least(0.0));
  s.vector("push.direction", c.push.direction, "", "direction of the push, world axes");
  s.number("push.duration", c.push.duration, "s", "how long it lasts", above(0.0));
  s.number("push.start", c.push.start, "s", "when it begins", at_least(0.0));
  s.choice<PushShape>("push.shape", c.push.shape,
                      {{describe(PushShape::rectangle), PushShape::rectangle},
                       {describe(PushShape::half_sine), PushShape::half_sine},
                       {describe(PushShape::triangle), PushShape::triangle}},
                      "of the force over time; the impulse is the same");
  s.rule({"push.direction"},
         [&c] { return c.push.direction.norm() > 0.0 ? "" : "push.direction must not be zero"; });

  s.number("step.duration", c.step.duration, "s", "from the trigger to the landing", above(0.0));
  s.choice<StepTrigger>(
      "step.trigger", c.step.trigger, {{"push", StepTrigger::push}, {"icp", StepTrigger::icp}},
      "a step is taken when the capture point leaves the sole; its time counts from "
      "the push, or from then");
  s.number("step.decision_delay", c.step.decision_delay, "s",
           "the place of the foot is fixed this long after the trigger", at_least(0.0));
  s.choice<Placement>("step.placement", c.step.placement,
                      {{"predicted", Placement::predicted}, {"fixed", Placement::fixed}},
                      "at the predicted capture point, or at step.fixed_place");
  s.vector("step.fixed_place", c.step.fixed_place, "m",
           "swing sole relative to the stance sole: forward, and to the side away from it");
  s.rule({"step.fixed_place"}, [&c] {
    return c.step.fixed_place[1] > 0.0
               ? ""
               : fmt::format(
                     "step.fixed_place counts away from the stance sole, on either side: its "
                     "second entry must be positive, not {}",
                     c.step.fixed_place[1]);
  });
  s.number("step.lateral_min", c.step.lateral_min, "m", "least lateral distance of the soles",
           above(0.0));
  s.number("step.lateral_max", c.step.lateral_max, "m", "largest lateral distance", above(0.0));
  s.number("step.forward_max", c.step.forward_max, "m", "reach to the front and back",
           at_least(0.0));
  s.rule({"step.lateral_min", "step.lateral_max"}, [&c] {
    return c.step.lateral_min <= c.step.lateral_max
               ? ""
               : fmt::format("step.lateral_min ({}) exceeds step.lateral_max ({})",
                             c.step.lateral_min, c.step.lateral_max);
  });

  s.number("mpc.step", c.mpc_step, "s", "grid and period of the controller", between(1e-4, 10.0));
  s.integer("mpc.intervals", c.mpc_intervals, "", "length of the horizon in steps",
            between(1.0, 1000.0));
  s.choice<CostRule>("mpc.costs", c.mpc_costs,
                     {{"nodes", CostRule::nodes}, {"integrated", CostRule::integrated}},
                     "running costs summed at the nodes or integrated");
  s.number("solver_tolerance", c.solver_tolerance, "", "scaled KKT error", strictly_between(0, 1));

  s.number("mpc.deadline", c.deadline, "s", "wall clock per tick; 0: none", at_least(0.0));
  s.number("mpc.missed_share", c.missed_share, "",
           "share of the ticks that are denied their solve, to try the loop", between(0.0, 0.9));
  s.integer("mpc.missed_seed", c.missed_seed, "", "which ticks those are", at_least(0.0));

  s.number("contact.friction", c.friction, "", "coefficient of friction", above(0.0));
  s.integer("contact.edges", c.friction_edges, "", "edges of the friction pyramid: 3, 4, 6, 8, 12",
            between(3.0, 12.0));
  s.rule({"contact.edges"}, [&c] {
    const int n = c.friction_edges;
    const bool known = n == 3 || n == 4 || n == 6 || n == 8 || n == 12;
    return known ? "" : fmt::format("contact.edges is {}; use 3, 4, 6, 8 or 12", n);
  });
  s.choice<FrictionPyramid>("contact.pyramid", c.pyramid,
                            {{"inscribed", FrictionPyramid::inscribed},
                             {"circumscribed", FrictionPyramid::circumscribed}},
                            "inside the friction cone, or around it");
  s.number("contact.torsional_friction", c.torsional_friction, "m", "largest |tz| / fz",
           at_least(0.0));
  s.number("contact.fz_min", c.normal_force_min, "N", "least normal force of a foot in contact",
           at_least(0.0));
  s.number("contact.fz_max", c.normal_force_max, "N", "largest normal force", above(0.0));
  s.rule({"contact.fz_min", "contact.fz_max"}, [&c] {
    return c.normal_force_min <= c.normal_force_max
               ? ""
               : fmt::format("contact.fz_min ({}) exceeds contact.fz_max ({})", c.normal_force_min,
                             c.normal_force_max);
  });
  s.text("push.link", c.push.link,
         "whole body: the link that is pushed (the centroidal model: CoM)");
  s.vector("push.point", c.push.point, "m", "whole body: where on that link, in its frame");
  s.number("control.period", c.control_period, "s",
           "of the whole-body controller; a whole multiple of simulator.step", above(0.0));
  s.number("simulator.step", c.plant_step, "s", "whole body: of the engine", above(0.0));
  s.rule({"control.period", "mpc.step", "simulator.step"}, [&c] { return clock_complaint(c); });
  s.number("simulator.friction", c.ground_friction, "", "whole body: of the ground", above(0.0));
  s.number("simulator.ground_step", c.ground_step, "m",
           "whole body: the ground on the swing foot's side is this much higher, unknown to the "
           "controllers",
           between(-0.1, 0.1));
  s.number("simulator.ground_edge", c.ground_edge, "m",
           "lateral distance from the stance sole where it begins", between(0.05, 1.0));
  s.number("simulator.joint_friction", c.joint_friction, "Nm s/rad", "whole body: viscous",
           at_least(0.0));
  s.integer("simulator.delay_ticks", c.delay_ticks, "",
            "whole body: control periods by which torques are late", between(0.0, 100.0));
  declare_noise(s, c.noise);
  s.choice<DartCollision>("dart.collision", c.collision,
                          {{"dart", DartCollision::dart},
                           {"fcl", DartCollision::fcl},
                           {"bullet", DartCollision::bullet},
                           {"ode", DartCollision::ode}},
                          "collision detector");
  s.choice<DartLcp>("dart.lcp", c.lcp, {{"dantzig", DartLcp::dantzig}, {"pgs", DartLcp::pgs}},
                    "contact solver");
  s.choice<WholeBodyChoice>(
      "whole_body.controller", c.whole_body_controller,
      {{"inverse_dynamics", WholeBodyChoice::inverse_dynamics},
       {"momentum", WholeBodyChoice::momentum}},
      "one program over accelerations and wrenches, or the momentum control of the literature "
      "(wrenches first, then torques)");
  WholeBodyWeights& w = c.whole_body;
  s.number("whole_body.linear_momentum", w.linear_momentum, "1/N^2", "weight", at_least(0.0));
  s.number("whole_body.angular_momentum", w.angular_momentum, "1/(Nm)^2", "weight", at_least(0.0));
  s.number("whole_body.posture", w.posture, "s^4/rad^2", "weight", above(0.0));
  s.number("whole_body.swing_foot", w.swing_foot, "s^4/m^2", "weight", at_least(0.0));
  s.number("whole_body.wrench", w.wrench, "1/N^2", "weight", above(0.0));
  MomentumOptions& m = c.momentum;
  s.number("momentum.linear_momentum", m.linear_momentum, "1/N^2", "weight", at_least(0.0));
  s.number("momentum.angular_momentum", m.angular_momentum, "1/(Nm)^2", "weight", at_least(0.0));
  s.number("momentum.wrench", m.wrench, "1/N^2", "weight of the difference to the plan",
           above(0.0));
  s.number("momentum.torque", m.torque, "1/(Nm)^2", "weight", at_least(0.0));
  s.number("momentum.posture", m.posture, "1/s^2", "stiffness", at_least(0.0));
  s.number("momentum.posture_damping", m.posture_damping, "1/s", "of the same", at_least(0.0));
  s.number("momentum.swing_regularisation", m.swing_regularisation, "m/(s^2 Nm)",
           "of the pseudo-inverse", above(0.0));
  declare_weights(s, c.weights);
  s.flag("pictures", c.pictures, "draw the pictures at the end (needs python3 with matplotlib)");
}

ContactConeOptions contact_options(const Config& config, const FootRectangle& foot) {
  ContactConeOptions options;
  options.friction = config.friction;
  options.edges = config.friction_edges;
  options.pyramid = config.pyramid;
  options.foot = foot;
  options.torsional_friction = config.torsional_friction;
  options.normal_force = between(config.normal_force_min, config.normal_force_max);
  return options;
}

}  // namespace saltus::push_recovery
