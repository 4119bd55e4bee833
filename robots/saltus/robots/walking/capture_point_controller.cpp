#include "saltus/robots/walking/planner.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/model/named_parameters.hpp"
#include "saltus/robots/centroidal/centroidal.hpp"
#include "saltus/robots/model/contact_cone.hpp"

namespace saltus::robots::walking {
namespace {

// The rate of momentum has the largest weight; the weights of the wrenches only distribute it. N^2
// and (Nm)^2.
constexpr double linear_weight = 1.0, angular_weight = 1000.0, force_weight = 1e-4,
                 torque_weight = 1e-2;

template <class S>
struct Tick {
  Vec<S, 3> com = Vec<S, 3>::Zero();            // m
  Vec<S, 3> left_foot = Vec<S, 3>::Zero();      // m
  Vec<S, 3> right_foot = Vec<S, 3>::Zero();     // m
  Vec<S, 3> acceleration = Vec<S, 3>::Zero();   // desired acceleration of the CoM, m/s^2
  Vec<S, 3> momentum_rate = Vec<S, 3>::Zero();  // desired rate of angular momentum, Nm
  using Entries = ParameterEntries<&Tick::com, &Tick::left_foot, &Tick::right_foot,
                                   &Tick::acceleration, &Tick::momentum_rate>;
};

struct MomentumRate {
  double mass;
  Mat<double, 3, 3> left_rotation, right_rotation;

  template <class S>
  Vec<S, 9> operator()(const S&, const Vec<S, 9>& gamma, const Vec<S, 12>& f,
                       const Vec<S, size_of<Tick>>& p) const {
    const auto tick = view_as<Tick>(p);
    const std::array<Contact<S>, 2> feet{
        contact<S>(SoleFrameOf<S>{tick.left_foot, left_rotation.template cast<S>()},
                   Vec<S, 6>(f.template head<6>())),
        contact<S>(SoleFrameOf<S>{tick.right_foot, right_rotation.template cast<S>()},
                   Vec<S, 6>(f.template tail<6>()))};
    Vec<S, 9> rate;
    rate << gamma.template segment<3>(3), com_acceleration(mass, feet),
        angular_momentum_rate(tick.com, feet);
    return rate;
  }
};

// Problem with one interval that determines the current wrenches.
OptimalControlProblem wrench_problem(const PlannerSettings& settings,
                                     const ContactSettings& contact_settings,
                                     const RobotDescription& robot, const Scene& scene,
                                     const Schedule& contacts) {
  const MomentumRate momentum{robot.mass, scene.sole(Side::left).rotation,
                              scene.sole(Side::right).rotation};
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
  keep_in_cone(phase, "left foot", cone_options(contact_settings, scene.rectangle(Side::left)), 0,
               during(left_support, double_support));
  keep_in_cone(phase, "right foot", cone_options(contact_settings, scene.rectangle(Side::right)), 6,
               during(right_support, double_support));
  for (int i = 0; i < 6; ++i) {
    phase.bound_input(i, exactly(0.0), during(right_support));
    phase.bound_input(6 + i, exactly(0.0), during(left_support));
  }
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
  ocp.schedule(contacts).start_at(VectorXd::Zero(9)).then(phase);
  ocp.costs(CostRule::nodes);  // the current rate of momentum, not its mean over the interval
  return ocp;
}

// Position and its first two derivatives.
struct Motion {
  Vec<double, 3> position, velocity, acceleration;
};

// Motion at time t (s) on the quintic from `start` to rest at `goal` after time T.
Motion minimum_jerk(const Motion& start, const Vec<double, 3>& goal, double T, double t) {
  const double s = std::clamp(t / T, 0.0, 1.0);
  const Vec<double, 3> d = goal - start.position, v = start.velocity * T,
                       a = start.acceleration * (T * T);
  const Vec<double, 3> c2 = 0.5 * a, c3 = 10.0 * d - 6.0 * v - 1.5 * a,
                       c4 = -15.0 * d + 8.0 * v + 1.5 * a, c5 = 6.0 * d - 3.0 * v - 0.5 * a;
  return {start.position + s * (v + s * (c2 + s * (c3 + s * (c4 + s * c5)))),
          (v + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * (5.0 * c5))))) / T,
          (2.0 * c2 + s * (6.0 * c3 + s * (12.0 * c4 + s * (20.0 * c5)))) / (T * T)};
}

// Start of the minimum-jerk motion to rest at `goal` in time T. The initial acceleration is free,
// so the initial jerk is zero.
Motion least_jerk_start(const Vec<double, 3>& com, const Vec<double, 3>& velocity,
                        const Vec<double, 3>& goal, double T) {
  return {com, velocity, 20.0 / 3.0 * (goal - com) / (T * T) - 4.0 * velocity / T};
}

class CapturePointController final : public Planner {
 public:
  CapturePointController(const CapturePointGains& gains, const PlannerSettings& settings,
                         const ContactSettings& contact_settings, const RobotDescription& robot,
                         const Scene& scene, const Schedule& contacts)
      : gains_(gains),
        controller_(
            make_tick_controller(wrench_problem(settings, contact_settings, robot, scene, contacts),
                                 1, settings, robot.mass, scene.side)) {}

  const ControlTick& tick(const Planner::Measurement& measured, const Scene& scene,
                          const Schedule& contacts) override {
    const Vec<double, 3> com = measured.gamma.head<3>(), velocity = measured.gamma.segment<3>(3);
    const Vec<double, 2> planar = scene.target_point();
    const Vec<double, 3> target(planar[0], planar[1], scene.stance.position[2] + scene.com_height);
    Motion wanted{target, Vec<double, 3>::Zero(), Vec<double, 3>::Zero()};
    if (scene.two_feet) {
      const double landing = landing_time(contacts);
      if (measured.time <= landing || trajectory_start_ == infinity) {
        trajectory_start_ = measured.time;
        trajectory_time_ = std::max(landing - measured.time, 0.0) + gains_.after_landing;
        start_ = least_jerk_start(com, velocity, target, trajectory_time_);
      }
      wanted = minimum_jerk(start_, target, trajectory_time_, measured.time - trajectory_start_);
    }
    controller_.set_data(
        "tick", Tick<double>{.com = com,
                             .left_foot = scene.sole(Side::left).position,
                             .right_foot = scene.sole(Side::right).position,
                             .acceleration = wanted.acceleration +
                                             gains_.com_stiffness * (wanted.position - com) +
                                             gains_.com_damping * (wanted.velocity - velocity),
                             .momentum_rate = -gains_.momentum_damping * measured.gamma.tail<3>()});
    controller_.set_schedule(contacts);
    return controller_.tick(measured.time, measured.gamma);
  }
  RecedingHorizonController& controller() override { return controller_; }

 private:
  CapturePointGains gains_;
  RecedingHorizonController controller_;
  double trajectory_start_ = infinity, trajectory_time_ = 0.0;  // s
  Motion start_;
};

}  // namespace

std::unique_ptr<Planner> make_capture_point_controller(
    const CapturePointGains& gains, const PlannerSettings& settings, const ContactSettings& contact,
    const RobotDescription& robot, const Scene& scene, const Schedule& contacts) {
  return std::make_unique<CapturePointController>(gains, settings, contact, robot, scene, contacts);
}

}  // namespace saltus::robots::walking
