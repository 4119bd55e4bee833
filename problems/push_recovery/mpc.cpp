#include "problems/push_recovery/mpc.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace saltus::push_recovery {
namespace {

Vec<double, 4> ends_of(const robots::FootRectangle& area) {
  return {area.x.lower, area.x.upper, area.y.lower, area.y.upper};
}

// Sets the data of the tick that depend only on the scene, which changes only during a swing.
void set_scene(const Scene& scene, Tick<double>& data) {
  data.left_foot = scene.sole(robots::Side::left).position;
  data.right_foot = scene.sole(robots::Side::right).position;
  data.left_heading = scene.sole(robots::Side::left).rotation.col(0).head<2>();
  data.right_heading = scene.sole(robots::Side::right).rotation.col(0).head<2>();
  const Vec<double, 2> target = scene.target_point();
  data.gamma_desired << target, scene.stance.position[2] + scene.com_height, Vec<double, 6>::Zero();
  data.capture_point_desired = target;
  data.left_support = ends_of(scene.rectangle(robots::Side::left));
  data.right_support = ends_of(scene.rectangle(robots::Side::right));
  if (const robots::SupportOfTwoFeet feet = scene.support(); feet.is_valid()) {
    data.hull_normals = feet.normals();
    data.hull_offsets = feet.offsets();
  }
  data.standing = scene.two_feet ? 0.0 : 1.0;
}
void set_measurement(const Planner::Measurement& measured, const Scene& scene, Tick<double>& data) {
  data.com = measured.gamma.head<3>();
  data.force = measured.contact_force;
  data.omega = lipm_frequency(measured.gamma[2] - scene.stance.position[2]);
}

// Fits the motion through three points of the horizon. Without a plan, it is constant at the
// target.
void set_motion(const Scene& scene, double begin, double length, Tick<double>& data) {
  const robots::walking::StepPlan::Motion& motion = scene.motion;
  data.motion_begin = begin;
  data.com_motion.setZero();
  data.capture_motion.setZero();
  data.com_motion.col(0) = data.capture_motion.col(0) = scene.target_point();
  data.following = motion.samples > 0 ? 1.0 : 0.0;
  if (motion.samples == 0) return;
  const auto through = [&](const auto& samples) {
    std::array<Vec<double, 2>, 3> at;
    for (int i = 0; i < 3; ++i) {
      const double s = std::clamp((begin + 0.5 * i * length - motion.begin) / motion.step, 0.0,
                                  motion.samples - 1.0);
      const int k = std::min(static_cast<int>(s), motion.samples - 2);
      at[i] = samples[k] + (s - k) * (samples[k + 1] - samples[k]);
    }
    Mat<double, 2, 3> polynomial;
    polynomial << at[0], (4.0 * at[1] - 3.0 * at[0] - at[2]) / length,
        2.0 * (at[0] - 2.0 * at[1] + at[2]) / (length * length);
    return polynomial;
  };
  data.com_motion = through(motion.com);
  data.capture_motion = through(motion.capture_point);
}

// Distance beyond which the capture point would come to rest off the support, m. Closer ones are
// brought back by the cost of the capture point, with less angular momentum.
constexpr double far_off = 0.009;

// Horizontal vector from the support to the point at which the capture point would come to rest, m;
// zero inside.
Vec<double, 2> off_support_at_rest(const Planner::Measurement& measured, const Scene& scene,
                                   double mass, double omega) {
  const robots::PlacedFoot stance{scene.stance, scene.stance_foot},
      swing{scene.swing, scene.swing_foot};
  const robots::SupportOfTwoFeet support(stance, scene.two_feet ? swing : stance);
  if (!support.is_valid()) return Vec<double, 2>::Zero();
  const Vec<double, 2> rest =
      robots::capture_point_at_rest(measured.gamma.head<3>(), measured.gamma.segment<3>(3),
                                    measured.gamma.tail<3>(), mass, omega);
  const Mat<double, hull_rows, 2> normals = support.normals();
  int side = 0;
  const double off = (normals * rest - support.offsets()).maxCoeff(&side);
  return std::max(off, 0.0) * normals.row(side).transpose();
}

class Mpc final : public Planner {
 public:
  Mpc(const Config& config, const robots::RobotDescription& robot, const Scene& scene)
      : mass_(robot.mass),
        capturing_momentum_(config.capturing_momentum),
        charges_change_(config.weights.wrench_change > 0.0),
        follows_motion_(config.planning.leads_the_way()),
        horizon_(config.planner.step * config.planner.intervals),
        scene_(scene),
        data_(data_at_rest(robot, scene)),
        controller_(make_tick_controller(problem_of(config, robot, scene), config.planner.intervals,
                                         config.planner, robot.mass, scene.side)) {}

  const ControlTick& tick(const Planner::Measurement& measured, const Scene& scene,
                          const Schedule& contacts) override {
    if (scene.two_feet != scene_.two_feet || scene.side != scene_.side ||
        scene.swing.position != scene_.swing.position ||
        scene.stance.position != scene_.stance.position ||
        scene.swing.rotation != scene_.swing.rotation ||
        scene.stance.rotation != scene_.stance.rotation ||
        scene.stance_foot != scene_.stance_foot || scene.swing_foot != scene_.swing_foot) {
      scene_ = scene;
      set_scene(scene, data_);
    }
    set_measurement(measured, scene, data_);
    data_.gamma_desired[8] = scene.yaw_momentum;
    if (capturing_momentum_ > 0.0) set_momentum(measured, scene);
    if (follows_motion_) set_motion(scene, measured.time, horizon_, data_);
    controller_.set_data("tick", data_);
    controller_.set_schedule(contacts);
    if (charges_change_) {
      // A foot that was in the air has no previous wrench.
      constexpr double none = std::numeric_limits<double>::quiet_NaN();
      Vec<double, 12> before = measured.applied;
      if (!measured.left_bore) before.head<6>().setConstant(none);
      if (!measured.right_bore) before.tail<6>().setConstant(none);
      controller_.set_previous_input(before);
    }
    return controller_.tick(measured.time, measured.gamma);
  }
  RecedingHorizonController& controller() override { return controller_; }

 private:
  // Desired angular momentum about the horizontal axes. To stop a capture point that would come to
  // rest off the support, a pendulum with a flywheel needs m g / omega times the distance. Once
  // begun, this lasts until the capture point is back.
  void set_momentum(const Planner::Measurement& measured, const Scene& scene) {
    const Vec<double, 2> off = off_support_at_rest(measured, scene, mass_, data_.omega);
    is_capturing_ = !off.isZero(0.0) && (is_capturing_ || off.norm() > far_off);
    Vec<double, 2> desired = Vec<double, 2>::Zero();
    if (is_capturing_)
      desired = capturing_momentum_ * mass_ * robots::standard_gravity / data_.omega *
                Vec<double, 2>(-off[1], off[0]);
    data_.gamma_desired.segment<2>(6) = desired;
  }

  static Tick<double> data_at_rest(const robots::RobotDescription& robot, const Scene& scene) {
    Planner::Measurement at_rest;
    at_rest.gamma.head<3>() = scene.two_feet ? Vec<double, 3>(0.0, 0.0, scene.com_height)
                                             : robot.posture_on(scene.side).com;
    at_rest.contact_force[2] = robot.mass * robots::standard_gravity;
    Tick<double> data;
    set_scene(scene, data);
    set_measurement(at_rest, scene, data);
    return data;
  }

  static OptimalControlProblem problem_of(const Config& config,
                                          const robots::RobotDescription& robot,
                                          const Scene& scene) {
    Model model;
    model.mass = robot.mass;
    model.left_contact = cone_options(config.contact, scene.rectangle(robots::Side::left));
    model.right_contact = cone_options(config.contact, scene.rectangle(robots::Side::right));
    model.step = config.planner.step;
    model.intervals = config.planner.intervals;
    model.cost_rule = config.planner.costs;
    model.estimates_support = config.foot_support.is_estimated;
    model.follows_motion = config.planning.leads_the_way();
    return problem(model, config.weights, data_at_rest(robot, scene),
                   first_contacts(config, scene));
  }

  double mass_;                // kg
  double capturing_momentum_;  // as in Config
  bool is_capturing_ = false;
  bool charges_change_, follows_motion_;
  double horizon_;  // s
  Scene scene_;
  Tick<double> data_;
  RecedingHorizonController controller_;
};

}  // namespace

std::unique_ptr<Planner> make_mpc(const Config& config, const robots::RobotDescription& robot,
                                  const Scene& scene) {
  return std::make_unique<Mpc>(config, robot, scene);
}

}  // namespace saltus::push_recovery
