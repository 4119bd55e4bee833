// One tick of the controller that catches a push by a step. The mass of iCub stands on the left
// foot and is pushed to the right; the right foot lands after 60 ms or beyond the horizon. The
// mathematics is that of problems/push_recovery/problem.cpp with round numbers, hard capture point
// rows, costs summed at the nodes and a friction pyramid of four circumscribed edges. The result is
// a quadratic program.
// Guess: the constant start, no wrenches.
// Source: S. Dafarra, F. Romano and F. Nori, A receding horizon push recovery strategy for
// balancing the iCub humanoid robot, which gives 10 ms and 15 intervals but no instance. These two
// instances were constructed and solved independently, to a gap of 1e-9.
#include <fmt/format.h>

#include <cmath>

#include "problems/library/cases.hpp"
#include "problems/push_recovery/problem.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/robots/walking/contacts.hpp"

namespace saltus::library {
namespace {

using namespace push_recovery;

constexpr double mass = 30.0;             // kg
constexpr double interval = 0.01;         // s
constexpr double landing = 6 * interval;  // s
constexpr double beyond = 16 * interval;  // s; the horizon ends after 15

OptimalControlProblem problem(double impact_time) {
  const Vec<double, 3> com{0.01, 0.02, 0.5};           // m
  const Vec<double, 3> com_desired{0.0, -0.025, 0.5};  // between the feet, m

  Model model;
  model.mass = mass;
  model.step = interval;
  model.intervals = 15;
  robots::ContactCone::Options contact;
  contact.friction = 1.0 / 3.0;
  contact.edges = 4;
  contact.pyramid = robots::ContactCone::Pyramid::circumscribed;
  contact.foot = {between(-0.05, 0.1), between(-0.03, 0.03)};
  contact.torsional_friction = 1.0 / 75.0;
  contact.normal_force = at_least(10.0);
  model.left_contact = model.right_contact = contact;

  Weights weights;
  weights.gamma << 0, 0, 100, 0, 0, 10, 1, 1, 1;
  weights.gamma_impact << 1000, 1000, 1000, 10, 10, 10, 1, 1, 1;
  weights.wrench << 1e-3, 1e-3, 1e-4, 1e-2, 1e-2, 1e-2;
  weights.capture_point << 1000, 1000;
  weights.capture_point_penalty = 0.0;
  weights.wrench_change = 0.0;

  Tick<double> tick;
  tick.com = com;
  tick.force << 0.0, 0.0, 294.3;  // N
  tick.omega = std::sqrt(9.81 / com[2]);
  tick.left_foot << 0.0, 0.07, 0.0;
  tick.right_foot << 0.0, -0.12, 0.0;
  tick.gamma_desired << com_desired, 0, 0, 0, 0, 0, 0;
  tick.capture_point_desired = com_desired.head<2>();
  Eigen::Matrix<double, 4, 2> corners;  // corners of both soles, m
  corners << -0.05, -0.15, 0.1, -0.15, 0.1, 0.1, -0.05, 0.1;
  tick.set_hull(robots::SupportPolygon::hull(corners).half_planes(hull_rows));

  Vector9 start;
  start << com, 0, -0.35, 0, 0, 0, 0;  // m, m/s, Nms
  OptimalControlProblem ocp =
      push_recovery::problem(model, weights, tick, walking::one_foot_then_two(impact_time));
  ocp.start_at(start);
  return ocp;
}

std::vector<std::string> wrench_names() {
  std::vector<std::string> names;
  for (const char* foot : {"left", "right"})
    for (const char* entry : {"fx [N]", "fy [N]", "fz [N]", "tx [Nm]", "ty [Nm]", "tz [Nm]"})
      names.push_back(fmt::format("{} {}", foot, entry));
  return names;
}

ReferenceCase instance(std::string id, std::string name, std::string summary, double impact_time,
                       double optimum) {
  return {.id = std::move(id),
          .name = std::move(name),
          .summary = std::move(summary),
          .states = {"CoM x [m]", "CoM y [m]", "CoM z [m]", "vx [m/s]", "vy [m/s]", "vz [m/s]",
                     "Lx [Nms]", "Ly [Nms]", "Lz [Nms]"},
          .inputs = wrench_names(),
          .exercises = "model predictive control: an event on the grid, contact cones, exact hold",
          .source = "Dafarra, Romano and Nori; instance constructed, solved independently",
          .problem = [impact_time] { return problem(impact_time); },
          .options = {.intervals_per_phase = 15, .integrator = zero_order_hold()},
          .optimum = optimum,
          .digits = 9,
          .tolerance = 1e-8};  // the gap of the reference, and the solver's tolerance
}

/// The first wrench of the left foot, to three decimals, and the state at the end, to six.
void check(ReferenceCase& c, const Vector6& wrench, const Vector9& end) {
  c.more = [wrench, end](const Solution& s) {
    std::vector<CheckedValue> values;
    for (int i = 0; i < 6; ++i)
      values.push_back(
          {fmt::format("f_l(0)[{}]", i), s.trajectory.input(0.0)[i], wrench[i], 1e-3, 3});
    for (int i = 0; i < 9; ++i)
      values.push_back(
          {fmt::format("gamma(N)[{}]", i), s.trajectory.final_state()[i], end[i], 1e-6, 3});
    return values;
  };
}

}  // namespace

ReferenceCase step_recovery_landing() {
  ReferenceCase c = instance("C09a", "step_recovery_landing",
                             "One tick of push recovery: the swing foot lands 60 ms later.",
                             landing, 0.9698742382);
  check(c, Vector6{{-16.363, 15.652, 254.744, -7.642, -4.325, -0.059}},
        Vector9{{0.007319, -0.021850, 0.495188, -0.012802, -0.178821, -0.013463, 0.082682, 0.006964,
                 -0.000411}});
  return c;
}

ReferenceCase step_recovery_waiting() {
  ReferenceCase c = instance("C09b", "step_recovery_waiting",
                             "One tick of push recovery: the swing foot lands beyond the horizon.",
                             beyond, 1.9847063181);
  check(c, Vector6{{-15.442, 18.639, 313.194, -9.396, -4.325, -0.335}},
        Vector9{{0.007710, -0.036347, 0.497868, -0.008207, -0.456830, -0.099006, 0.400879, 0.019140,
                 0.002189}});
  return c;
}

}  // namespace saltus::library
