#include "saltus/robots/walking/planner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/mpc/riccati_qp.hpp"
#include "saltus/qp/sparse_solver.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/solver/ipopt.hpp"

namespace saltus::push_recovery {

SupportPolygon Scene::hull() const {
  return SupportPolygon::under({{stance, stance_foot}, {swing, swing_foot}});
}

Vec<double, 2> Scene::target_point() const {
  if (!two_feet) return stance.position.head<2>();
  if (target == Target::centroid) return hull().centroid();
  return 0.5 * (stance.position + swing.position).head<2>();
}

Vec<double, 12> reordered(Side stance, const Vec<double, 12>& wrenches) {
  if (stance == Side::left) return wrenches;
  Vec<double, 12> result;
  result << wrenches.tail<6>(), wrenches.head<6>();
  return result;
}

namespace {

// What of the tick's data hangs on the scene alone: it changes when a step is decided, no oftener.
void set_scene(const Scene& scene, Tick<double>& data) {
  data.swing_foot = scene.swing.position;
  const Vec<double, 2> target = scene.target_point();
  data.gamma_desired << target, scene.stance.position[2] + scene.com_height, Vec<double, 6>::Zero();
  data.capture_point_desired = target;
  data.set_hull(scene.hull().half_planes(hull_rows));
  data.standing = scene.two_feet ? 0.0 : 1.0;
}
void set_measurement(const Measurement& measured, const Scene& scene, Tick<double>& data) {
  data.com = measured.gamma.head<3>();
  data.force = measured.contact_force;
  data.omega = frequency_of_height(measured.gamma[2] - scene.stance.position[2]);
}

// Ticks that are denied their solve: runs of one to five, as often as the share asks.
std::function<bool(long)> missed_ticks(const Config& config) {
  if (config.missed_share <= 0.0) return {};
  constexpr int longest = 5;
  constexpr double mean = 0.5 * (1 + longest);
  const double begin = std::min(1.0, config.missed_share / (mean * (1.0 - config.missed_share)));
  return [random = std::mt19937(static_cast<unsigned>(config.missed_seed)), begin,
          left = 0](long) mutable {
    if (left == 0) {
      left = -1;  // at least one tick between runs
      return false;
    }
    if (left < 0) {
      if (std::uniform_real_distribution<double>(0.0, 1.0)(random) >= begin) return false;
      left = std::uniform_int_distribution<int>(1, longest)(random);
    }
    --left;
    return true;
  };
}

class Mpc final : public Planner {
 public:
  Mpc(const Config& config, const RobotDescription& robot, const Scene& scene)
      : charges_change_(config.weights.wrench_change > 0.0),
        scene_(scene),
        data_(data_at_rest(robot, scene)),
        controller_(make_controller(config, robot, scene)) {}

  const ControlTick& tick(const Measurement& measured, const Scene& scene,
                          double impact_time) override {
    if (scene.two_feet != scene_.two_feet || scene.swing.position != scene_.swing.position) {
      scene_ = scene;
      set_scene(scene, data_);
    }
    set_measurement(measured, scene, data_);
    controller_.set_data("tick", data_);
    controller_.retime("impact", impact_time);
    if (charges_change_) {
      // Up to the landing the swing foot had no wrench from which the first one could differ.
      Vec<double, 12> before = measured.applied;
      if (impact_time > measured.time - same_instant)
        before.tail<6>().setConstant(std::numeric_limits<double>::quiet_NaN());
      controller_.set_previous_input(before);
    }
    return controller_.tick(measured.time, measured.gamma);
  }
  RecedingHorizonController& controller() override { return controller_; }

 private:
  static Tick<double> data_at_rest(const RobotDescription& robot, const Scene& scene) {
    Measurement at_rest;
    at_rest.gamma << robot.posture_on(scene.side).com, Vec<double, 6>::Zero();
    at_rest.contact_force[2] = robot.mass * standard_gravity;
    Tick<double> data;
    set_scene(scene, data);
    set_measurement(at_rest, scene, data);
    return data;
  }

  static RecedingHorizonController make_controller(const Config& config,
                                                   const RobotDescription& robot,
                                                   const Scene& scene) {
    MultipleShooting shooting = transcribe(config, robot, scene);
    auto solver = make_tick_solver(config, shooting);
    return {std::move(shooting), std::move(solver), controller_options(config, robot)};
  }

  static MultipleShooting transcribe(const Config& config, const RobotDescription& robot,
                                     const Scene& scene) {
    Model model;
    model.mass = robot.mass;
    model.stance = scene.stance;
    model.swing_rotation = scene.swing.rotation;
    model.stance_contact = contact_options(config, scene.stance_foot);
    model.swing_contact = contact_options(config, scene.swing_foot);
    model.step = config.mpc_step;
    model.intervals = config.mpc_intervals;
    model.cost_rule = config.mpc_costs;
    OptimalControlProblem ocp =
        problem(model, config.weights, data_at_rest(robot, scene), infinity);
    return MultipleShooting(std::move(ocp), {.intervals_per_phase = config.mpc_intervals,
                                             .integrator = zero_order_hold()});
  }

  bool charges_change_;
  Scene scene_;
  Tick<double> data_;
  RecedingHorizonController controller_;
};

}  // namespace

std::unique_ptr<RealTimeSolver> make_tick_solver(const Config& config, MultipleShooting& shooting) {
  if (config.solver == SolverChoice::ipopt)
    return make_real_time_solver(
        make_solver(Ipopt{.tolerance = config.solver_tolerance, .mehrotra = true}));
  return make_real_time_iteration(shooting.nlp(), {.tolerance = config.solver_tolerance},
                                  config.solver == SolverChoice::riccati
                                      ? riccati_qp_solver(shooting)
                                      : QpSolverFactory(make_sparse_qp_solver));
}

ControllerOptions controller_options(const Config& config, const RobotDescription& robot) {
  ControllerOptions options;
  options.period = config.mpc_step;
  if (config.deadline > 0.0) options.deadline = config.deadline;
  options.miss_deadline = missed_ticks(config);
  options.fallback_input = VectorXd::Zero(12);
  options.fallback_input[2] = robot.mass * standard_gravity;  // on the stance foot
  return options;
}

std::unique_ptr<Planner> make_mpc(const Config& config, const RobotDescription& robot,
                                  const Scene& scene) {
  return std::make_unique<Mpc>(config, robot, scene);
}

}  // namespace saltus::push_recovery
