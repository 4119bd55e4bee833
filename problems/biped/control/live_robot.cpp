#include "problems/biped/control/live_robot.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "problems/biped/control/link_request.hpp"
#include "saltus/app/defer_signals.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/control/joint_check.hpp"
#include "saltus/robots/control/link_file.hpp"
#include "saltus/robots/control/recorded_robot.hpp"
#include "saltus/robots/control/robot_server.hpp"
#include "saltus/robots/simulation/simulated_robot.hpp"
#include "saltus/robots/walking/robot_choice.hpp"

namespace saltus::robots::walking {
namespace {

using Json = nlohmann::ordered_json;
using control::JointCheck;
using control::ServerResult;

void require_link(const LinkRequest& request, const char* verb) {
  if (request.link.empty())
    throw InputError(fmt::format("{}: give --link udp:PORT, udp:ADDRESS:PORT or shm:NAME", verb));
}

// ---- check

void print_check(const std::vector<control::LinkJoint>& joints,
                 const std::vector<JointCheck::Report>& reports) {
  fmt::print("{:20} {:>5} {:>9} {:>9} {:>9} {:>9} {:>8}\n", "joint", "sign", "moves at", "delay",
             "followed", "offset", "room");
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const JointCheck::Report& r = reports[i];
    if (!r.is_checked) continue;
    fmt::print("{:20} {:>5} {:>6.2f} Nm {:>6.1f} ms {:>7.0f} % {:>+5.3f} rad {:>4.2f} rad\n",
               joints[i].name, r.sign > 0 ? "right" : (r.sign < 0 ? "WRONG" : "none"), r.torque,
               1e3 * r.delay, 1e2 * r.followed, r.offset, r.room);
  }
}

Json to_json(const std::vector<control::LinkJoint>& joints,
             const std::vector<JointCheck::Report>& reports) {
  Json all = Json::array();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const JointCheck::Report& r = reports[i];
    all.push_back({{"joint", joints[i].name},
                   {"sign", r.sign},
                   {"moves_at_nm", r.torque},
                   {"delay_s", r.delay},
                   {"followed", r.followed},
                   {"velocity_ratio", r.velocity_ratio},
                   {"offset_rad", r.offset},
                   {"findings", r.findings}});
  }
  return all;
}

// ---- serve

// Separate joints that hang from a stand. The largest torque of a joint accelerates it by
// 50 rad/s^2.
class HangingJoints {
 public:
  HangingJoints(WholeBodyState state, const std::vector<control::LinkJoint>& joints, double period)
      : state_(std::move(state)), period_(period) {
    for (const control::LinkJoint& joint : joints) inertia_.push_back(joint.effort / 50.0);
  }
  const WholeBodyState& move(const Robot::Commands& c, control::ControlState state) {
    if (state == control::ControlState::stand) {
      state_.q = c.positions;
      speed_.setZero(state_.q.size());
      return state_;
    }
    if (speed_.size() == 0) speed_.setZero(state_.q.size());
    for (Eigen::Index i = 0; i < state_.q.size(); ++i) {
      const double h = period_ / inertia_[static_cast<std::size_t>(i)];
      const double pull = c.torques[i] + c.stiffness[i] * (c.positions[i] - state_.q[i]);
      speed_[i] = (speed_[i] + h * pull) / (1.0 + h * c.damping[i]);
      state_.q[i] += period_ * speed_[i];
    }
    return state_;
  }

 private:
  WholeBodyState state_;
  VectorXd speed_;
  std::vector<double> inertia_;
  double period_;
};

struct ServeRequest : LinkRequest {
  control::ServerOptions server;
};
void declare_server(LinkOptions& options, control::ServerOptions& server) {
  options.number("--pace", "N", "wall-clock seconds per robot second; default 0: lock-step", 0.0,
                 server.pace);
  options.number("--loss", "FRACTION", "fraction of lost messages in each direction", 0.0,
                 server.loss);
  options.number("--delay", "SECONDS", "delay in each direction", 0.0, server.delay);
  options.number("--jitter", "SECONDS", "largest additional random delay", 0.0, server.jitter);
  options.integer("--seed", "seed of loss and jitter; default 1", 0.0,
                  [&server](int seed) { server.seed = seed; });
  options.number("--guard", "SECONDS", "time without commands until the guard acts; default 0.015",
                 0.0, server.silence);
  options.number("--guard-release", "SECONDS",
                 "time without commands until no torque acts; default 0.3", 0.0, server.release);
  options.number("--wait", "SECONDS", "time to wait for a controller; default 30", 0.0,
                 server.patience);
}

ExitStatus status_of(const ServerResult& result, const char* verb) {
  if (result.end == ServerResult::End::no_controller) {
    fmt::print(stderr,
               "saltus: {}: no controller balances; start `saltus control` with the same --link\n",
               verb);
    return ExitStatus::robot_lost;
  }
  return ExitStatus::ok;
}

}  // namespace

ExitStatus check_live_robot(std::span<const std::string> arguments,
                            const ConfigurableBiped& defaults) {
  constexpr const char* verb = "robot check";
  LinkRequest request;
  JointCheck::Options check;
  OptionParser parser(verb, "moves each joint of a hanging robot and reports faults");
  LinkOptions options(parser, verb, request);
  options.link();
  options.robot();
  options.number("--push", "FRACTION", "largest torque without spring, relative; default 0.1", 0.0,
                 check.torque);
  options.number("--angle", "RAD", "largest motion of each joint; default 0.05", 1e-3, check.angle);
  options.number("--offset", "RAD", "tolerance of the known posture; default 0.01", 0.0,
                 check.offset);
  options.settings();
  options.process("results/robot_check");
  if (parser.prints_help(arguments)) return ExitStatus::ok;
  require_link(request, verb);

  LinkSetup setup{.options = request.control, .name = "robot"};
  const bool is_other = !request.robot.empty() && !request.config && request.assignments.empty();
  if (is_other) {
    control::read_link_file(request.robot, setup.joints, setup.options);
  } else {
    const std::unique_ptr<ConfigurableBiped> problem = defaults.clone();
    const std::string config = apply_settings(request, *problem);
    setup =
        biped_setup(request, *problem, make_model(*problem, robot_of(problem->settings())), config);
  }
  setup.options.stuck.time = 0.0;  // the check itself reports joints that do not move
  setup.options.balance = infinity;
  JointCheck controller(setup.joints, setup.options, check);
  const ExitStatus status = drive(request, setup, controller, [&] {
    return Json{{"joints", to_json(setup.joints, controller.reports())}};
  });
  const std::vector<JointCheck::Report> reports = controller.reports();
  if (controller.updates() == 0) return status;
  print_check(setup.joints, reports);
  fmt::print("sensors: mean specific force {:.2f} m/s^2, mean angular velocity {:.3f} rad/s\n",
             controller.gravity(), controller.turning());
  long wrong = 0;
  const auto find = [&wrong](const std::string& what, const std::string& text) {
    fmt::print("wrong {}: {}\n", what, text);
    ++wrong;
  };
  for (std::size_t i = 0; i < reports.size(); ++i)
    for (const std::string& text : reports[i].findings)
      if (reports[i].is_checked || status == ExitStatus::ok) find(setup.joints[i].name, text);
  if (!(std::abs(controller.gravity() - 9.81) < 0.5))
    find("accelerometer", "at rest it must read 9.81 m/s^2; check unit and sign");
  if (!(controller.turning() < 0.1))
    find("gyroscope", "at rest it must read less than 0.1 rad/s; check unit and bias");
  if (status != ExitStatus::ok) return status;
  if (wrong == 0) fmt::print("all {} joints passed\n", setup.joints.size());
  return wrong == 0 ? ExitStatus::ok : ExitStatus::differs;
}

ExitStatus serve_simulated_robot(std::span<const std::string> arguments,
                                 const ConfigurableBiped& defaults) {
  constexpr const char* verb = "robot serve";
  ServeRequest request;
  OptionParser parser(verb, "simulates the robot of push_recovery for `saltus control`");
  LinkOptions options(parser, verb, request);
  options.link();
  options.settings();
  options.number("--time", "SECONDS", "duration in balance; default 6", 0.0, request.server.time);
  declare_server(options, request.server);
  if (parser.prints_help(arguments)) return ExitStatus::ok;
  require_link(request, verb);

  const std::unique_ptr<ConfigurableBiped> problem = defaults.clone();
  apply_settings(request, *problem);
  const BipedSettings& settings = problem->settings();
  const RobotDescription description = robot_of(settings);
  const BipedModel model = make_model(*problem, description);
  const std::vector<control::LinkJoint> joints = control::joints_of(model.body, model.start.q);
  SimulatedRobot robot(make_engine(model.body, settings, initial_scene(*problem, description).side),
                       model.body, settings.plant, settings.control.period);
  robot.reset(model.start);
  const std::vector<Push> pushes = problem->pushes();
  std::vector<Pulse> pulses(pushes.begin(), pushes.end());
  if (!pushes.empty())
    robot.push_by(pulses, frame_of_push(pushes.front(), model.body,
                                        UrdfModel::read(urdf_of_body(settings.robot))));
  HangingJoints hanging(model.start, joints, robot.period());
  const std::unique_ptr<control::RobotLink> link =
      control::open_link(request.link, control::LinkSide::robot);
  const double height = model.start.base.translation().z();
  const auto has_fallen = [&robot, height] {
    const WholeBodyState& state = robot.engine().state();
    return !state.is_finite() || state.base.translation().z() < 0.6 * height;
  };
  const DeferSignals note;
  const ServerResult result = control::serve_robot(
      robot, joints, *link, request.server,
      [&](const Robot::Commands& commands, control::ControlState state) {
        robot.reset(hanging.move(commands, state));
      },
      [&] { return has_fallen() || DeferSignals::received() != 0; });
  if (result.end == ServerResult::End::no_controller || result.time == 0.0)
    return status_of(result, verb);
  fmt::print("robot: {} in {} after {:.3f} s; guard: {} periods\n",
             has_fallen() ? "has fallen" : "stands", robot.name(), result.time, result.guarded);
  if (!result.failure.empty()) fmt::print(stderr, "saltus: {}: {}\n", verb, result.failure);
  return has_fallen() || !result.failure.empty() ? ExitStatus::differs : ExitStatus::ok;
}

ExitStatus play_log(std::span<const std::string> arguments) {
  constexpr const char* verb = "robot play";
  ServeRequest request;
  std::string folder;
  double tolerance = 0.01;
  OptionParser parser(verb, "replays a log for `saltus control` and compares the commands");
  LinkOptions options(parser, verb, request);
  parser.word("DIR", "folder of a run of `saltus control --log-every 1`", folder);
  options.link();
  options.number("--tolerance", "NM", "largest accepted torque difference; default 0.01", 0.0,
                 tolerance);
  declare_server(options, request.server);
  if (parser.prints_help(arguments)) return ExitStatus::ok;
  require_link(request, verb);
  if (folder.empty()) throw InputError("robot play: give the folder of a run of `saltus control`");

  std::vector<control::LinkJoint> joints;
  control::ControlOptions recorded;
  control::read_link_file(std::filesystem::path(folder) / "robot.yaml", joints, recorded);
  control::RecordedRobot robot(std::filesystem::path(folder) / "trajectory.csv", joints,
                               recorded.period);
  const std::unique_ptr<control::RobotLink> link =
      control::open_link(request.link, control::LinkSide::robot);
  request.server.time = static_cast<double>(robot.readings() - 1) * robot.period();
  const DeferSignals note;
  const ServerResult result = control::serve_robot(
      robot, joints, *link, request.server, [](const Robot::Commands&, control::ControlState) {},
      [&robot] { return robot.is_over() || DeferSignals::received() != 0; });
  if (result.end == ServerResult::End::no_controller) return status_of(result, verb);
  const bool agrees = robot.compared() > 0 && robot.largest() <= tolerance;
  fmt::print(
      "{} readings played, {} commands compared: root mean square {:.2g} Nm, largest difference "
      "{:.2g} Nm ({} at {:.3f} s): {}\n",
      robot.readings(), robot.compared(), robot.rms(), robot.largest(),
      robot.joint().empty() ? "none" : robot.joint(), robot.time(),
      agrees ? "the commands agree" : "the commands differ");
  return agrees ? ExitStatus::ok : ExitStatus::differs;
}

}  // namespace saltus::robots::walking
