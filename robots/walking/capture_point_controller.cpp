#include "saltus/robots/walking/capture_point_controller.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/model/named_parameters.hpp"
#include "saltus/robots/centroidal/centroidal.hpp"
#include "saltus/robots/model/contact_term.hpp"

namespace saltus::walking {
namespace {

// Gains of the PD law on the CoM (1/s^2, 1/s, critically damped) and of the damping of the angular
// momentum (1/s): those in print for the balancing robot, rounded.
constexpr double com_stiffness = 50.0;
const double com_damping = 2.0 * std::sqrt(com_stiffness);
constexpr double momentum_damping = 5.0;
// The minimum jerk trajectory ends this long after the landing, s.
constexpr double trajectory_after_landing = 0.5;
// Momentum rate matters most; the wrench weights only distribute it. N^2 against (Nm)^2.
constexpr double linear_weight = 1.0, angular_weight = 1000.0, force_weight = 1e-4,
                 torque_weight = 1e-2;

template <class S>
struct Tick {
  Vec<S, 3> com = Vec<S, 3>::Zero();            // m
  Vec<S, 3> swing_foot = Vec<S, 3>::Zero();     // m
  Vec<S, 3> acceleration = Vec<S, 3>::Zero();   // of the CoM, wanted, m/s^2
  Vec<S, 3> momentum_rate = Vec<S, 3>::Zero();  // angular, wanted, Nm
  using Entries =
      ParameterEntries<&Tick::com, &Tick::swing_foot, &Tick::acceleration, &Tick::momentum_rate>;
};

struct MomentumRate {
  double mass;
  SoleFrame stance;
  Mat<double, 3, 3> swing_rotation;

  template <class S>
  Vec<S, 9> operator()(const S&, const Vec<S, 9>& gamma, const Vec<S, 12>& f,
                       const Vec<S, size_of<Tick>>& p) const {
    const auto tick = view_as<Tick>(p);
    const std::array<Contact<S>, 2> feet{
        contact<S>(stance, Vec<S, 6>(f.template head<6>())),
        contact<S>(SoleFrameOf<S>{tick.swing_foot, swing_rotation.template cast<S>()},
                   Vec<S, 6>(f.template tail<6>()))};
    Vec<S, 9> rate;
    rate << gamma.template segment<3>(3), com_acceleration(mass, feet),
        angular_momentum_rate(tick.com, feet);
    return rate;
  }
};

// One interval: what is wanted of the wrenches now.
OptimalControlProblem wrench_problem(const PlannerSettings& settings,
                                     const ContactSettings& contact_settings,
                                     const RobotDescription& robot, const Scene& scene) {
  const MomentumRate momentum{robot.mass, scene.stance, scene.swing.rotation};
  const auto miss = [momentum](const auto& t, const auto& gamma, const auto& f, const auto& p) {
    auto error = momentum(t, gamma, f, p).template tail<6>().eval();
    const auto tick = view_as<Tick>(p);
    error.template head<3>() -= tick.acceleration;
    error.template tail<3>() -= tick.momentum_rate;
    error.template head<3>() *= momentum.mass;
    return error;
  };
  Phase<9, 12, size_of<Tick>> phase{"now", momentum, exactly(settings.step)};
  phase.data("tick", Tick<double>{});
  keep_in_cone(phase, "stance foot", cone_options(contact_settings, scene.stance_foot), 0);
  keep_in_cone(phase, "swing foot", cone_options(contact_settings, scene.swing_foot), 6,
               during(double_support));
  for (int i = 6; i < 12; ++i) phase.bound_input(i, exactly(0.0), during(single_support));
  Vec<double, 6> rates;
  rates << Vec<double, 3>::Constant(linear_weight), Vec<double, 3>::Constant(angular_weight);
  Vec<double, 12> wrenches;
  wrenches << Vec<double, 3>::Constant(force_weight), Vec<double, 3>::Constant(torque_weight),
      Vec<double, 3>::Constant(force_weight), Vec<double, 3>::Constant(torque_weight);
  phase.track("momentum rate", miss, rates)
      .track(
          "wrenches", [](const auto&, const auto&, const auto& f) { return f; }, wrenches)
      .nominal(Vec<double, 9>::Constant(0.1), Vec<double, 12>::Constant(10.0));
  OptimalControlProblem ocp("wrenches of one tick");
  ocp.schedule(one_foot_then_two()).start_at(VectorXd::Zero(9)).then(phase);
  return ocp;
}

// Position and its first two derivatives at time t of the quintic with zero end velocity and
// acceleration, from (x0, v0, zero acceleration) at t = 0 to x1 at t = T.
struct TrajectoryPoint {
  Vec<double, 3> position, velocity, acceleration;
};
TrajectoryPoint minimum_jerk(const Vec<double, 3>& x0, const Vec<double, 3>& v0,
                             const Vec<double, 3>& x1, double T, double t) {
  const double s = std::clamp(t / T, 0.0, 1.0);
  const double to_goal = s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
  const double to_goal_1 = s * s * (30.0 + s * (-60.0 + 30.0 * s));
  const double to_goal_2 = s * (60.0 + s * (-180.0 + 120.0 * s));
  const double drift = s * (1.0 + s * s * (-6.0 + s * (8.0 - 3.0 * s)));
  const double drift_1 = 1.0 + s * s * (-18.0 + s * (32.0 - 15.0 * s));
  const double drift_2 = s * (-36.0 + s * (96.0 - 60.0 * s));
  const Vec<double, 3> d = x1 - x0;
  return {x0 + d * to_goal + v0 * (T * drift), (d / T) * to_goal_1 + v0 * drift_1,
          (d / (T * T)) * to_goal_2 + (v0 / T) * drift_2};
}

class CapturePointController final : public Planner {
 public:
  CapturePointController(const PlannerSettings& settings, const ContactSettings& contact_settings,
                         const RobotDescription& robot, const Scene& scene)
      : controller_(make_tick_controller(wrench_problem(settings, contact_settings, robot, scene),
                                         1, settings, robot.mass)) {}

  const ControlTick& tick(const Measurement& measured, const Scene& scene,
                          const Schedule& contacts) override {
    const Vec<double, 3> com = measured.gamma.head<3>(), velocity = measured.gamma.segment<3>(3);
    const Vec<double, 2> planar = scene.target_point();
    const Vec<double, 3> target(planar[0], planar[1], scene.stance.position[2] + scene.com_height);
    TrajectoryPoint wanted{target, Vec<double, 3>::Zero(), Vec<double, 3>::Zero()};
    if (scene.two_feet) {
      if (trajectory_start_ == infinity) {
        trajectory_start_ = measured.time;
        com_at_start_ = com;
        velocity_at_start_ = velocity;
      }
      const double landing = std::max(landing_time(contacts), trajectory_start_);
      const double T = landing + trajectory_after_landing - trajectory_start_;
      wanted = minimum_jerk(com_at_start_, velocity_at_start_, target, T,
                            measured.time - trajectory_start_);
    }
    controller_.set_data(
        "tick",
        Tick<double>{.com = com,
                     .swing_foot = scene.swing.position,
                     .acceleration = wanted.acceleration + com_stiffness * (wanted.position - com) +
                                     com_damping * (wanted.velocity - velocity),
                     .momentum_rate = -momentum_damping * measured.gamma.tail<3>()});
    controller_.set_schedule(contacts);
    return controller_.tick(measured.time, measured.gamma);
  }
  RecedingHorizonController& controller() override { return controller_; }

 private:
  RecedingHorizonController controller_;
  double trajectory_start_ = infinity;
  Vec<double, 3> com_at_start_, velocity_at_start_;
};

}  // namespace

std::unique_ptr<Planner> make_capture_point_controller(const PlannerSettings& settings,
                                                       const ContactSettings& contact,
                                                       const RobotDescription& robot,
                                                       const Scene& scene) {
  return std::make_unique<CapturePointController>(settings, contact, robot, scene);
}

}  // namespace saltus::walking
