#include "problems/push_recovery/planner.hpp"

#include <cmath>
#include <limits>

#include "framework/solver/ipopt.hpp"
#include "integrators/zero_order_hold.hpp"
#include "robots/capture_point.hpp"

namespace saltus::push_recovery {

SupportPolygon Scene::hull() const {
  return SupportPolygon::under({{left, left_foot}, {right, right_foot}});
}

Vec<double, 2> Scene::target_point() const {
  if (!two_feet) return left.position.head<2>();
  if (target == Target::centroid) return hull().centroid();
  return 0.5 * (left.position + right.position).head<2>();
}

namespace {

TickData tick_data(const Measurement& measured, const Scene& scene) {
  TickData data;
  data.com = measured.gamma.head<3>();
  data.force = measured.contact_force;
  data.omega = pendulum_frequency(measured.gamma[2] - scene.left.position[2]);
  data.right_foot = scene.right.position;
  const Vec<double, 2> target = scene.target_point();
  data.gamma_desired << target, scene.left.position[2] + scene.com_height, Vec<double, 6>::Zero();
  data.capture_point_desired = target;
  data.hull = scene.hull().half_planes(hull_rows);
  return data;
}

class Mpc final : public Planner {
 public:
  Mpc(const Config& config, const RobotDescription& robot, const Scene& scene)
      : charges_change_(config.weights.wrench_change > 0.0),
        controller_(transcribe(config, robot, scene),
                    make_solver(Ipopt{.tolerance = config.solver_tolerance, .mehrotra = true}),
                    config.mpc_step) {}

  ControlTick tick(const Measurement& measured, const Scene& scene, double impact_time) override {
    MultipleShooting& shooting = controller_.shooting();
    shooting.set_data("tick", tick_data(measured, scene).vector());
    shooting.retime("impact", impact_time);
    if (charges_change_) {
      // Up to the landing the right foot had no wrench from which the first one could differ.
      Vec<double, 12> before = measured.applied;
      if (impact_time > measured.time - same_instant)
        before.tail<6>().setConstant(std::numeric_limits<double>::quiet_NaN());
      shooting.set_previous_input(before);
    }
    return controller_.tick(measured.time, measured.gamma);
  }

 private:
  static MultipleShooting transcribe(const Config& config, const RobotDescription& robot,
                                     const Scene& scene) {
    Model model;
    model.mass = robot.mass;
    model.left = scene.left;
    model.right_rotation = scene.right.rotation;
    model.left_contact = contact_options(config, scene.left_foot);
    model.right_contact = contact_options(config, scene.right_foot);
    model.step = config.mpc_step;
    model.intervals = config.mpc_intervals;
    model.cost_rule = config.mpc_costs;
    Measurement at_rest;
    at_rest.gamma << robot.default_posture().com, Vec<double, 6>::Zero();
    at_rest.contact_force[2] = robot.mass * standard_gravity;
    OptimalControlProblem ocp = problem(model, config.weights, tick_data(at_rest, scene), infinity);
    return MultipleShooting(std::move(ocp), {.intervals_per_phase = config.mpc_intervals,
                                             .integrator = zero_order_hold()});
  }

  bool charges_change_;
  RecedingHorizonController controller_;
};

}  // namespace

std::unique_ptr<Planner> make_mpc(const Config& config, const RobotDescription& robot,
                                  const Scene& scene) {
  return std::make_unique<Mpc>(config, robot, scene);
}

}  // namespace saltus::push_recovery
