#include "problems/biped/control/control_verb.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "saltus/app/defer_signals.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/control/control_process.hpp"
#include "saltus/robots/control/link_file.hpp"
#include "saltus/robots/control/plugin_controller.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/mujoco/mjcf.hpp"
#include "saltus/robots/walking/robot_choice.hpp"

namespace saltus::robots::walking {
namespace {

using Json = nlohmann::ordered_json;
using control::ControlLog;
using control::ProcessResult;
using control::RobotControl;

constexpr const char* summary =
    "balances a robot in another process, or runs a plugin, through UDP or shared memory";

struct Request {
  std::string link, mjcf, plugin, controller;
  std::optional<std::filesystem::path> config, robot;
  std::filesystem::path out = "results/control";
  std::vector<Assignment> assignments;
  control::ControlOptions control;
  control::ProcessOptions process;
  control::RealTimeOptions real_time;
  int log_every = 5;
  bool is_help = false;
};

double number(const std::string& flag, const std::string& text, double least) {
  std::size_t used = 0;
  double value = NAN;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
  }
  if (used != text.size() || !(value >= least) || !std::isfinite(value))
    throw InputError(
        fmt::format("control: {} is '{}'; use a number of at least {}", flag, text, least));
  return value;
}

Request parse(std::span<const std::string> arguments) {
  Request r;
  OptionParser parser("control", summary);
  const auto seconds = [&parser](const char* flag, const char* doc, double& field) {
    parser.option(flag, "SECONDS", doc,
                  [flag, &field](const std::string& text) { field = number(flag, text, 0.0); });
  };
  const auto integer = [&parser](const char* flag, const char* doc, double least, auto& field) {
    parser.option(flag, "N", doc, [flag, least, &field](const std::string& text) {
      const double value = number(flag, text, least);
      if (value != std::floor(value) || value > 1e9)
        throw InputError(fmt::format("control: {} is '{}'; use a whole number of at least {}", flag,
                                     text, least));
      field = static_cast<int>(value);
    });
  };
  parser.option("--link", "LINK", "udp:PORT, udp:ADDRESS:PORT or shm:NAME", r.link)
      .option("--mjcf", "FILE", "write the model of the robot for MuJoCo instead", r.mjcf)
      .option("--plugin", "FILE",
              "run a controller of this shared library, for the joints of --robot", r.plugin)
      .option("--controller", "NAME", "one of the controllers of the plugin", r.controller)
      .option("--robot", "FILE", "joints, gains, filters and guards of the robot as YAML",
              [&](const std::string& file) { r.robot = file; })
      .option("--config", "FILE", "settings of push_recovery as YAML",
              [&](const std::string& file) { r.config = file; })
      .repeated("--set", "KEY=VALUE", "one setting; --KEY VALUE means the same",
                [&](const std::string& text) { r.assignments.push_back(parse_set_argument(text)); })
      .option("--out", "DIR", "folder of the log; default results/control",
              [&](const std::string& folder) { r.out = folder; });
  seconds("--duration", "time in balance after which it stops; default: none", r.control.balance);
  seconds("--stand", "time in which the joints move to the first posture; default 2",
          r.control.stand);
  seconds("--hold", "soft stop: time in which it holds the posture; default 0.3", r.control.hold);
  seconds("--damp", "soft stop: time in which torques fade; default 1", r.control.damp);
  seconds("--silence",
          "time without messages until the soft stop, on the robot's clock; default 0.1 "
          "(in lock-step always 10 s of wall-clock time)",
          r.process.silence);
  seconds("--wait", "time to wait for the first message; default 60", r.process.arrival);
  integer("--log-every", "log one of N commands; default 5", 1, r.log_every);
  integer("--priority", "real-time priority, 1 to 99", 1, r.real_time.priority);
  integer("--cpu", "the only processor to use", 0, r.real_time.cpu);
  parser.flag("--lock-memory", "keep all memory in RAM", r.real_time.lock_memory)
      .others([&](const std::string& flag, const std::optional<std::string>& value) {
        r.assignments.push_back(value ? flag_assignment(flag, *value) : bare_flag_assignment(flag));
      });
  r.is_help = parser.prints_help(arguments);
  if (!r.is_help && r.link.empty() == r.mjcf.empty())
    throw InputError(
        "control: give one of --link LINK and --mjcf FILE; LINK is udp:PORT, udp:ADDRESS:PORT or "
        "shm:NAME");
  if (!r.is_help && !r.plugin.empty()) {
    if (r.config || !r.assignments.empty() || !r.mjcf.empty())
      throw InputError("control: --plugin takes neither --mjcf nor settings of push_recovery");
    if (!r.robot) throw InputError("control: --plugin needs the joints of the robot, --robot FILE");
  }
  if (!r.is_help && r.plugin.empty() && !r.controller.empty())
    throw InputError("control: --controller names a controller of --plugin FILE");
  return r;
}

// The robot as simulated by others, the model of the controller, and the state at the start.
struct Model {
  FloatingRobot body, nominal;
  WholeBodyState start;
};

Model make_model(const BipedProblem& problem, const RobotDescription& robot) {
  const BipedSettings& settings = problem.settings();
  const UrdfModel urdf = UrdfModel::read(urdf_of_body(settings.robot));
  FloatingRobot described = floating_robot(urdf, robot);
  if (settings.control.self_collision || !robot.capsules.empty())
    add_capsules(described, urdf, robot);
  DriveFactors drives = settings.robot.drives;
  drives.torque_speed_line = settings.plant.drives.torque_speed_line;
  FloatingRobot body = with_drives_scaled(described, settings.plant.drives);
  WholeBodyState start = standing_state(body, urdf, robot, problem.posture(robot));
  return {std::move(body), with_drives_scaled(std::move(described), drives), std::move(start)};
}

Json to_json(const LatencyHistogram& times) {
  return {{"count", times.count()},
          {"median_us", 1e6 * times.median()},
          {"p99_us", 1e6 * times.p99()},
          {"p999_us", 1e6 * times.p999()},
          {"max_us", 1e6 * times.max()}};
}

void print_times(const char* what, const LatencyHistogram& times) {
  if (times.count() == 0) return;
  fmt::print("{}: median {:.0f} us, 99 % {:.0f} us, 99.9 % {:.0f} us, largest {:.0f} us\n", what,
             1e6 * times.median(), 1e6 * times.p99(), 1e6 * times.p999(), 1e6 * times.max());
}

struct Outcome {
  ExitStatus status;
  const char* name;
  std::string sentence;
};
Outcome outcome(const ProcessResult& result, const RobotControl& robot) {
  switch (result.end) {
    case ProcessResult::End::no_robot:
      if (robot.counts().refused > 0)
        return {ExitStatus::bad_input, "refused",
                fmt::format("{} messages arrived and all were refused: {}; use the model that "
                            "`saltus control --mjcf` writes with the same settings",
                            robot.counts().refused, control::describe(robot.last_refusal()))};
      return {ExitStatus::robot_lost, "no robot",
              "no message arrived; start the robot with the address of --link"};
    case ProcessResult::End::silence:
      return {ExitStatus::robot_lost, "silence", robot.fault()};
    case ProcessResult::End::fault:
      return {ExitStatus::soft_stop, "fault", robot.fault()};
    case ProcessResult::End::request:
      break;
  }
  return {ExitStatus::ok, "request", {}};
}

// A robot with these joints, its controller, and their names for the log.
struct Setup {
  std::vector<control::LinkJoint> joints = {};
  control::ControlOptions options = {};
  std::string name = {}, config = {};
};

ExitStatus drive(const Request& request, const Setup& setup, control::LinkController& controller,
                 const std::function<Json()>& more) {
  RobotControl robot(controller, setup.joints, setup.options);
  control::Codec codec(control::names_of(setup.joints));
  const std::unique_ptr<control::RobotLink> link =
      control::open_link(request.link, control::LinkSide::controller);
  OutputFolder output(request.out);
  replace_earlier_run(output);
  if (!setup.config.empty()) output.write("config.yaml", std::string_view(setup.config));
  output.write("robot.yaml", std::string_view(control::to_link_file(setup.joints, setup.options)));
  ProcessResult result;
  long dropped = 0;
  {
    ControlLog log(output.path() / "trajectory.csv", setup.joints, request.log_every);
    apply(request.real_time);
    const int port = control::port_of(*link);
    fmt::print("robot: {}, {} joints, period {} s; listening at {}\n", setup.name, codec.joints(),
               setup.options.period, port > 0 ? fmt::format("UDP port {}", port) : request.link);
    std::fflush(stdout);
    const DeferSignals note;
    result = run_control(
        *link, codec, robot, request.process, [] { return DeferSignals::received() != 0; }, &log);
    dropped = log.dropped();
  }
  const control::LinkCounts& counts = robot.counts();
  const Outcome end = outcome(result, robot);
  Json results{{"end", end.name},
               {"fault", end.sentence},
               {"balanced_s", robot.balanced()},
               {"wall_s", result.seconds},
               {"messages",
                {{"received", counts.received},
                 {"used", counts.used},
                 {"lost", robot.lost()},
                 {"late", counts.late},
                 {"duplicate", counts.duplicate},
                 {"refused", counts.refused},
                 {"readings_replaced", counts.replaced}}},
               {"torques_cut", robot.cut()},
               {"torque_change_without_motion", robot.stuck().worst()},
               {"log_rows_dropped", dropped},
               {"page_faults", result.page_faults},
               {"answer", to_json(result.answer)},
               {"stamp_to_command", to_json(result.stamp)}};
  results.update(more());
  output.write("summary.json", results);
  write_run_file(output, "control");
  fmt::print(
      "controlled for {:.3f} s; messages: {} received, {} lost, {} late, {} duplicate, {} "
      "refused; {} readings replaced\n",
      robot.balanced(), counts.received, robot.lost(), counts.late, counts.duplicate,
      counts.refused, counts.replaced);
  print_times("from arrival to command", result.answer);
  print_times("from time stamp to command", result.stamp);
  if (!end.sentence.empty()) fmt::print(stderr, "saltus: control: {}\n", end.sentence);
  return end.status;
}

ExitStatus run_plugin(const Request& request) {
  Setup setup{.options = request.control, .name = request.plugin};
  control::read_link_file(*request.robot, setup.joints, setup.options);
  control::PluginController controller(request.plugin, request.controller,
                                       static_cast<int>(setup.joints.size()), setup.options.period);
  const ExitStatus status = drive(request, setup, controller, [&controller] {
    return Json{{"tick", to_json(controller.ticks())},
                {"ticks_without_plan", controller.without_plan()}};
  });
  print_times("tick of the controller", controller.ticks());
  return status;
}

ExitStatus balance(const Request& request, const BipedProblem& problem, std::string config) {
  const BipedSettings& settings = problem.settings();
  if (settings.plant.sensors != PlantSettings::Sensors::measured)
    throw InputError(
        "control: a robot in another process has no ideal sensors; leave out "
        "--sensors, or use --sensors measured");
  const RobotDescription robot = robot_of(settings);
  const Model model = make_model(problem, robot);
  Setup setup{.joints = control::joints_of(model.body, model.start.q),
              .options = request.control,
              .name = model.body.name,
              .config = std::move(config)};
  setup.options.period = settings.plant.engine.step;
  if (request.robot) control::read_link_file(*request.robot, setup.joints, setup.options);
  if (setup.options.period != settings.plant.engine.step)
    throw InputError(fmt::format("{}: the period is {} s, but simulator.step_s is {} s",
                                 request.robot->string(), setup.options.period,
                                 settings.plant.engine.step));
  BalanceController controller =
      make_balance_controller(problem, robot, model.nominal, make_dart_dynamics(model.nominal),
                              initial_scene(problem, robot), setup.options.period);
  control::BalanceLink link(controller, model.start);
  return drive(request, setup, link, [] { return Json::object(); });
}

ExitStatus run(const Request& request, ConfigurableBiped& problem) {
  if (!request.plugin.empty()) return run_plugin(request);
  Settings settings;
  problem.declare(settings);
  std::vector<Assignment> assignments = request.assignments;
  if (std::ranges::find(assignments, "plant", &Assignment::key) == assignments.end())
    assignments.push_back(flag_assignment("plant", "dart"));  // the whole body
  settings.apply(request.config, assignments);
  for (const std::string& warning : settings.warnings())
    fmt::print(stderr, "saltus: {}\n", warning);
  if (request.mjcf.empty()) return balance(request, problem, settings.to_yaml());
  const RobotDescription robot = robot_of(problem.settings());
  const Model model = make_model(problem, robot);
  const OutputFolder output = folder_of_file("--mjcf", request.mjcf);
  Plant::Options engine = problem.settings().plant.engine;
  engine.self_collision = problem.settings().control.self_collision;
  output.write(std::filesystem::path(request.mjcf).filename().string(),
               std::string_view(mujoco_engine::to_mjcf(model.body, engine, model.start)));
  fmt::print("Written: {}\n", request.mjcf);
  return ExitStatus::ok;
}

}  // namespace

Verb control_verb(const ConfigurableBiped& defaults) {
  const std::shared_ptr<const ConfigurableBiped> shared = defaults.clone();
  return {"control", summary, [shared](std::span<const std::string> arguments) {
            const Request request = parse(arguments);
            if (request.is_help) return ExitStatus::ok;
            return run(request, *shared->clone());
          }};
}

}  // namespace saltus::robots::walking
