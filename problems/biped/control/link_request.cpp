#include "problems/biped/control/link_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "saltus/app/defer_signals.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/control/link_file.hpp"
#include "saltus/robots/walking/robot_choice.hpp"

namespace saltus::robots::walking {
namespace {

using Json = nlohmann::ordered_json;
using control::ControlLog;
using control::ProcessResult;
using control::RobotControl;

double read_number(const std::string& verb, const std::string& flag, const std::string& text,
                   double least) {
  std::size_t used = 0;
  double value = NAN;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
  }
  if (used != text.size() || !(value >= least) || !std::isfinite(value))
    throw InputError(
        fmt::format("{}: {} is '{}'; use a number of at least {}", verb, flag, text, least));
  return value;
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

}  // namespace

LinkOptions::LinkOptions(OptionParser& parser, std::string verb, LinkRequest& request)
    : parser_(parser), verb_(std::move(verb)), request_(request) {}

void LinkOptions::number(const char* flag, const char* what, const char* doc, double least,
                         double& field) {
  parser_.option(flag, what, doc, [verb = verb_, flag, least, &field](const std::string& text) {
    field = read_number(verb, flag, text, least);
  });
}

void LinkOptions::integer(const char* flag, const char* doc, double least,
                          std::function<void(int)> take) {
  parser_.option(
      flag, "N", doc, [verb = verb_, flag, least, take = std::move(take)](const std::string& text) {
        const double value = read_number(verb, flag, text, least);
        if (value != std::floor(value) || value > 1e9)
          throw InputError(fmt::format("{}: {} is '{}'; use a whole number of at least {}", verb,
                                       flag, text, least));
        take(static_cast<int>(value));
      });
}

void LinkOptions::link() {
  parser_.option("--link", "LINK", "udp:PORT, udp:ADDRESS:PORT or shm:NAME", request_.link);
}

void LinkOptions::robot() {
  parser_.option("--robot", "FILE", "joints, gains, filters and guards of the robot as YAML",
                 [&r = request_](const std::string& file) { r.robot = file; });
}

void LinkOptions::settings() {
  parser_
      .option("--config", "FILE", "settings of push_recovery as YAML",
              [&r = request_](const std::string& file) { r.config = file; })
      .repeated("--set", "KEY=VALUE", "one setting; --KEY VALUE means the same",
                [&r = request_](const std::string& text) {
                  r.assignments.push_back(parse_set_argument(text));
                })
      .others([&r = request_](const std::string& flag, const std::optional<std::string>& value) {
        r.assignments.push_back(value ? flag_assignment(flag, *value) : bare_flag_assignment(flag));
      });
}

void LinkOptions::process(const std::string& folder) {
  request_.out = folder;
  parser_.option("--out", "DIR", fmt::format("folder of the log; default {}", folder),
                 [&r = request_](const std::string& name) { r.out = name; });
  number("--wait", "SECONDS", "time to wait for the first message; default 60", 0.0,
         request_.process.arrival);
  integer("--log-every", "log every N-th command; default 5", 1,
          [&r = request_](int n) { r.log_every = n; });
  integer("--priority", "real-time priority, 1 to 99", 1,
          [&r = request_](int n) { r.real_time.priority = n; });
  integer("--cpu", "the only processor to use", 0, [&r = request_](int n) { r.real_time.cpu = n; });
  parser_.flag("--lock-memory", "keep all memory in RAM", request_.real_time.lock_memory);
}

std::string apply_settings(const LinkRequest& request, ConfigurableBiped& problem) {
  Settings settings;
  problem.declare(settings);
  std::vector<Assignment> assignments = request.assignments;
  if (std::ranges::find(assignments, "plant", &Assignment::key) == assignments.end())
    assignments.push_back(flag_assignment("plant", "dart"));  // the whole body
  settings.apply(request.config, assignments);
  for (const std::string& warning : settings.warnings())
    fmt::print(stderr, "saltus: {}\n", warning);
  if (problem.settings().plant.sensors != PlantSettings::Sensors::measured)
    throw InputError(
        "control: a robot in another process has no ideal sensors; leave out "
        "--sensors, or use --sensors measured");
  return settings.to_yaml();
}

BipedModel make_model(const BipedProblem& problem, const RobotDescription& robot) {
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

LinkSetup biped_setup(const LinkRequest& request, const BipedProblem& problem,
                      const BipedModel& model, std::string config) {
  LinkSetup setup{.joints = control::joints_of(model.body, model.start.q),
                  .options = request.control,
                  .name = model.body.name,
                  .config = std::move(config)};
  const double step = problem.settings().plant.engine.step;
  setup.options.period = step;
  if (!request.robot.empty()) control::read_link_file(request.robot, setup.joints, setup.options);
  if (setup.options.period != step)
    throw InputError(fmt::format("{}: the period is {} s, but simulator.step_s is {} s",
                                 request.robot.string(), setup.options.period, step));
  return setup;
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

ExitStatus drive(const LinkRequest& request, const LinkSetup& setup,
                 control::LinkController& controller, const std::function<Json()>& more) {
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
    ControlLog log(output.path(), setup.joints, request.log_every);
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
                 {"readings_replaced", counts.replaced},
                 {"guarded", counts.guarded}}},
               {"torques_cut", robot.cut()},
               {"torque_change_without_motion", robot.stuck().worst()},
               {"log_rows_dropped", dropped},
               {"page_faults", result.page_faults},
               {"interval", to_json(result.interval)},
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
  if (result.stamp.count() > 0) print_times("between messages", result.interval);
  if (!end.sentence.empty()) fmt::print(stderr, "saltus: control: {}\n", end.sentence);
  return end.status;
}

}  // namespace saltus::robots::walking
