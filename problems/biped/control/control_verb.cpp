#include "problems/biped/control/control_verb.hpp"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "problems/biped/control/link_request.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/control/link_file.hpp"
#include "saltus/robots/control/plugin_controller.hpp"
#include "saltus/robots/mujoco/mjcf.hpp"
#include "saltus/robots/walking/robot_choice.hpp"
#include "saltus/robots/whole_body/recursive_dynamics.hpp"

namespace saltus::robots::walking {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* summary =
    "balances a robot in another process, or runs a plugin, through UDP or shared memory";

struct Request : LinkRequest {
  std::string mjcf, plugin, controller;
  bool is_help = false;
};

void parse(std::span<const std::string> arguments, Request& r) {
  OptionParser parser("control", summary);
  LinkOptions options(parser, "control", r);
  options.link();
  parser.option("--mjcf", "FILE", "write the model of the robot for MuJoCo instead", r.mjcf)
      .option("--plugin", "FILE", "run a controller of this plugin, for the joints of --robot",
              r.plugin)
      .option("--controller", "NAME", "name of the controller, if the plugin has several",
              r.controller);
  options.robot();
  options.settings();
  const auto seconds = [&options](const char* flag, const char* doc, double& field) {
    options.number(flag, "SECONDS", doc, 0.0, field);
  };
  seconds("--duration", "time in balance after which it stops; default: none", r.control.balance);
  seconds("--stand", "time in which the joints move to the first posture; default 2",
          r.control.stand);
  seconds("--hold", "soft stop: time in which it holds the posture; default 0.3", r.control.hold);
  seconds("--damp", "soft stop: time in which torques fade; default 1", r.control.damp);
  seconds("--silence",
          "time without messages until the soft stop, on the robot's clock; default 0.1 "
          "(in lock-step always 10 s of wall-clock time)",
          r.process.silence);
  options.process("results/control");
  r.is_help = parser.prints_help(arguments);
  if (r.is_help) return;
  if (r.link.empty() == r.mjcf.empty())
    throw InputError(
        "control: give one of --link LINK and --mjcf FILE; LINK is udp:PORT, udp:ADDRESS:PORT or "
        "shm:NAME");
  if (!r.plugin.empty()) {
    if (r.config || !r.assignments.empty() || !r.mjcf.empty())
      throw InputError("control: --plugin takes neither --mjcf nor settings of push_recovery");
    if (r.robot.empty())
      throw InputError("control: --plugin needs --robot FILE with the joints of the robot");
  } else if (!r.controller.empty()) {
    throw InputError("control: --controller needs --plugin FILE");
  }
}

ExitStatus run_plugin(const Request& request) {
  LinkSetup setup{.options = request.control, .name = request.plugin};
  control::read_link_file(request.robot, setup.joints, setup.options);
  control::PluginController controller(request.plugin, request.controller,
                                       static_cast<int>(setup.joints.size()), setup.options.period);
  const ExitStatus status = drive(request, setup, controller, [&controller] {
    return Json{{"tick", to_json(controller.ticks())},
                {"ticks_without_plan", controller.without_plan()}};
  });
  print_times("tick of the controller", controller.ticks());
  return status;
}

ExitStatus write_model(const Request& request, const BipedProblem& problem,
                       const BipedModel& model) {
  const OutputFolder output = folder_of_file("--mjcf", request.mjcf);
  Plant::Options engine = problem.settings().plant.engine;
  engine.self_collision = problem.settings().control.self_collision;
  output.write(std::filesystem::path(request.mjcf).filename().string(),
               std::string_view(mujoco_engine::to_mjcf(model.body, engine, model.start)));
  fmt::print("Written: {}\n", request.mjcf);
  return ExitStatus::ok;
}

ExitStatus run(const Request& request, ConfigurableBiped& problem) {
  if (!request.plugin.empty()) return run_plugin(request);
  const std::string config = apply_settings(request, problem);
  const RobotDescription robot = robot_of(problem.settings());
  const BipedModel model = make_model(problem, robot);
  if (!request.mjcf.empty()) return write_model(request, problem, model);
  const LinkSetup setup = biped_setup(request, problem, model, config);
  BalanceController controller =
      make_balance_controller(problem, robot, model.nominal, make_recursive_dynamics(model.nominal),
                              initial_scene(problem, robot), setup.options.period);
  control::BalanceLink link(controller, model.start);
  return drive(request, setup, link, [] { return Json::object(); });
}

}  // namespace

Verb control_verb(const ConfigurableBiped& defaults) {
  const std::shared_ptr<const ConfigurableBiped> shared = defaults.clone();
  return {"control", summary, [shared](std::span<const std::string> arguments) {
            Request request;
            parse(arguments, request);
            if (request.is_help) return ExitStatus::ok;
            return run(request, *shared->clone());
          }};
}

}  // namespace saltus::robots::walking
