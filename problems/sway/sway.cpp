// State (CoM position, velocity, angular momentum about the CoM), in the world (m, m/s, Nms);
// inputs the contact wrenches of both feet in the axes of their soles (N, Nm), left then right.
#include "problems/sway/sway.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "problems/biped/keys/keys.hpp"
#include "problems/biped/report/run_biped.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/model/named_parameters.hpp"
#include "saltus/robots/centroidal/centroidal.hpp"
#include "saltus/robots/model/contact_cone.hpp"

namespace saltus::sway {

using namespace robots::walking;
using Vector9 = Vec<double, 9>;

namespace {

constexpr double follows_within = 0.01;  // m

struct Config : BipedSettings {
  double amplitude = 0.03;  // amplitude of the CoM about the middle of the feet, along y, m
  double period = 4.0;      // s
  int cycles = 3;
  Vector9 state_weights{1e5, 1e5, 1e5, 1e3, 1e3, 1e3, 400, 400, 400};
  Vec<double, 6> wrench_weights{0.002, 0.002, 1e-4, 0.02, 0.02, 0.02};  // for each foot

  Config() {
    planner.step = 0.02;
    planner.intervals = 20;
    push.impulse = 0.0;
  }
};

// Reference of the state at time t (s): (m, m/s, Nms).
Vector9 reference(const Config& config, const Scene& scene, double t) {
  const double rate = 2.0 * std::numbers::pi / config.period;
  const Vec<double, 2> middle = 0.5 * (scene.stance.position + scene.swing.position).head<2>();
  Vector9 gamma = Vector9::Zero();
  gamma.head<3>() << middle[0], middle[1] + config.amplitude * std::sin(rate * t), scene.com_height;
  gamma[4] = config.amplitude * rate * std::cos(rate * t);
  return gamma;
}

// Expansion point of the angular momentum.
template <class S>
struct Tick {
  Vec<S, 3> com = Vec<S, 3>::Zero();    // last measurement, m
  Vec<S, 3> force = Vec<S, 3>::Zero();  // sum of the contact forces applied last, world axes, N
  using Entries = ParameterEntries<&Tick::com, &Tick::force>;
};

struct Dynamics {
  double mass;
  robots::SoleFrame left, right;

  template <class S>
  Vec<S, 9> operator()(const S&, const Vec<S, 9>& gamma, const Vec<S, 12>& f,
                       const Vec<S, size_of<Tick>>& p) const {
    const auto tick = view_as<Tick>(p);
    const std::array<robots::Contact<S>, 2> feet{
        robots::contact<S>(left, Vec<S, 6>(f.template head<6>())),
        robots::contact<S>(right, Vec<S, 6>(f.template tail<6>()))};
    return robots::linearised_centroidal_dynamics(mass, gamma, feet,
                                                  robots::ExpansionPoint<S>{tick.com, tick.force});
  }
};

OptimalControlProblem problem(const Config& config, const robots::RobotDescription& robot,
                              const Scene& scene) {
  const PlannerSettings& planner = config.planner;
  Phase<9, 12, size_of<Tick>> phase{"sway", Dynamics{robot.mass, scene.stance, scene.swing},
                                    exactly(planner.step * planner.intervals)};
  phase.data("tick", Tick<double>{});
  robots::keep_in_cone(phase, "left foot", cone_options(config.contact, scene.stance_foot), 0,
                       during(double_support));
  robots::keep_in_cone(phase, "right foot", cone_options(config.contact, scene.swing_foot), 6,
                       during(double_support));

  std::vector<double> times;
  for (double t = 0.0; t < config.period * config.cycles + 10.0; t += 0.02) times.push_back(t);
  MatrixXd states(9, times.size());
  for (std::size_t i = 0; i < times.size(); ++i)
    states.col(static_cast<Eigen::Index>(i)) = reference(config, scene, times[i]);
  Vec<double, 12> wrench_weights;
  wrench_weights << config.wrench_weights, config.wrench_weights;
  phase
      .track(
          "state", [](const auto&, const auto& gamma) { return gamma; }, config.state_weights, {},
          Reference(times, states))
      .track(
          "wrenches", [](const auto&, const auto&, const auto& f) { return f; }, wrench_weights)
      .nominal(Vector9::Constant(0.1), Vec<double, 12>::Constant(10.0));
  OptimalControlProblem ocp("sway");
  ocp.schedule(two_feet_throughout())
      .costs(planner.costs)
      .start_at(reference(config, scene, 0.0))
      .then(phase);
  return ocp;
}

class SwayPlanner final : public Planner {
 public:
  SwayPlanner(const Config& config, const robots::RobotDescription& robot, const Scene& scene)
      : controller_(make_tick_controller(problem(config, robot, scene), config.planner.intervals,
                                         config.planner, robot.mass)) {}

  const ControlTick& tick(const Planner::Measurement& measured, const Scene&,
                          const Schedule& contacts) override {
    controller_.set_data("tick", Tick<double>{measured.gamma.head<3>(), measured.contact_force});
    controller_.set_schedule(contacts);
    return controller_.tick(measured.time, measured.gamma);
  }
  RecedingHorizonController& controller() override { return controller_; }

 private:
  RecedingHorizonController controller_;
};

class Sway final : public ConfigurableBiped {
 public:
  std::unique_ptr<ConfigurableBiped> clone() const override {
    return std::make_unique<Sway>(*this);
  }
  const Config& settings() const override { return config_; }
  Config& settings() override { return config_; }

  void declare(Settings& s) override {
    declare_biped(s, config_);
    s.number("sway.amplitude", config_.amplitude, "m", "lateral amplitude of the CoM",
             between(0.0, 0.1));
    s.number("sway.period", config_.period, "s", "period of one cycle", above(0.5));
    s.integer("sway.cycles", config_.cycles, "", "number of cycles", between(1.0, 100.0));
    s.vector("weights.state", config_.state_weights, "",
             "weights of CoM, CoM velocity and angular momentum", at_least(0.0));
    s.vector("weights.wrench", config_.wrench_weights, "",
             "weights of force (N) and torque (Nm) of a foot", at_least(0.0));
    declare_pictures(s, config_);
    s.removed("step.known", "true", "0.4");
    s.removed("step.trigger", "push", "0.4");
  }

  const robots::StandingPosture& posture(const robots::RobotDescription& robot) const override {
    return posture_on_both_feet(robot);
  }
  std::vector<Push> pushes() const override {
    return config_.push.impulse > 0.0 ? std::vector<Push>{config_.push} : std::vector<Push>{};
  }
  std::unique_ptr<Planner> make_planner(const robots::RobotDescription& nominal,
                                        const Scene& scene) const override {
    return std::make_unique<SwayPlanner>(config_, nominal, scene);
  }
  double end_time(double, double, double) const override { return config_.period * config_.cycles; }

  Verdict judge(const RunLog& log) const override {
    Verdict v = figures_of(log, config_.period, pushes());
    double farthest = 0.0;
    for (const BipedSample& s : log.samples)
      if (s.time > config_.period) {
        const Vector9 wanted = reference(config_, log.final_scene, s.time);
        farthest = std::max(farthest, (s.gamma - wanted).head<3>().norm());
      }
    if (farthest > follows_within)
      v.fail(fmt::format("the CoM was {:.0f} mm away from its reference", 1e3 * farthest));
    v.recovered = v.reason.empty();
    return v;
  }

 private:
  Config config_;
};

}  // namespace

std::unique_ptr<ConfigurableBiped> make_sway() { return std::make_unique<Sway>(); }

ProblemEntry entry() {
  return biped_entry<Sway>("sway", "a biped on both feet sways from side to side");
}

}  // namespace saltus::sway
