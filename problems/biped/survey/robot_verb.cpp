#include "problems/biped/survey/robot_verb.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "problems/biped/control/live_robot.hpp"
#include "problems/biped/survey/robot_check.hpp"
#include "problems/biped/survey/robot_file.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/program.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/core/text.hpp"

namespace saltus::survey {
namespace {

namespace fs = std::filesystem;
using robots::walking::BipedSettings;
using robots::walking::ConfigurableBiped;

constexpr const char* summary =
    "checks a robot or its files, writes its files, or serves a robot for `saltus control`";
constexpr const char* usage =
    "saltus robot check FILE.urdf [--config ROBOT.yaml]\n"
    "    Checks masses, limits, meshes, feet, postures and reach, one line each; status 2 if\n"
    "    something is wrong. Without --config the robot is read from the URDF alone.\n"
    "saltus robot new FILE.urdf [--out DIR]\n"
    "    Writes DIR/robot.yaml (feet, joints, sides, postures) and DIR/run.yaml (settings fitted\n"
    "    to its size), and checks them. DIR is the robot's name unless given.\n"
    "saltus robot check --link LINK [--robot FILE]\n"
    "    Moves each joint of a hanging robot and reports signs, offsets, delays and velocities.\n"
    "saltus robot serve --link LINK [--KEY VALUE]\n"
    "    Simulates the robot of push_recovery for `saltus control` in another process.\n"
    "saltus robot play DIR --link LINK\n"
    "    Replays a log of `saltus control` as the robot, and compares the commands.\n"
    "    docs/robot_link.md describes the last three; each has --help.\n";

struct Request {
  std::string action, urdf, config, out;
};

Request parse(std::span<const std::string> arguments) {
  Request request;
  std::vector<std::string> words(arguments.begin(), arguments.end());
  const auto action = std::find_if(words.begin(), words.end(),
                                   [](const std::string& word) { return !word.starts_with("-"); });
  if (action != words.end()) {
    request.action = *action;
    words.erase(action);
  }
  OptionParser parser("robot", summary);
  parser.word("FILE.urdf", "URDF of the robot", request.urdf);
  parser.option("--config", "FILE", "its configuration (robots/README.md)", request.config);
  parser.option("--out", "DIR", "folder for the files of `new`", request.out);
  parser.parse(words);
  if (parser.help_wanted() || request.action.empty()) {
    request.action = "help";
    return request;
  }
  const std::vector<std::string> known{"check", "new"};
  if (std::find(known.begin(), known.end(), request.action) == known.end())
    throw InputError(
        fmt::format("robot: there is no \"{}\"; use check, new, serve or play", request.action));
  if (request.urdf.empty())
    throw InputError(fmt::format("robot {} needs the URDF of the robot", request.action));
  if (request.action == "check" && !request.out.empty())
    throw InputError("robot check: --out belongs to `robot new`; check writes nothing");
  if (request.action == "new" && !request.config.empty())
    throw InputError("robot new: --config belongs to `robot check`; new writes such a file");
  return request;
}

// The problem with its settings scaled to the robot's size.
std::unique_ptr<ConfigurableBiped> fitted(const ConfigurableBiped& defaults,
                                          const robots::RobotDescription& robot) {
  std::unique_ptr<ConfigurableBiped> problem = defaults.clone();
  problem->scale(walking::scale_of(robot));
  return problem;
}

// Prints the findings of `check`. Returns false if one of them is `wrong`.
bool print_check(const robots::UrdfModel& model, const robots::RobotDescription& robot,
                 const ConfigurableBiped& problem) {
  const robots::walking::Step& step = problem.settings().step;
  const std::vector<Finding> findings =
      check_robot(model, robot, step.forward_max, between(step.lateral_min, step.lateral_max));
  for (const std::string& warning : robot.warnings) fmt::print("note  {}\n", warning);
  fmt::print("{}", describe(findings));
  const auto wrong = std::count_if(findings.begin(), findings.end(), [](const Finding& f) {
    return f.level == Finding::Level::wrong;
  });
  fmt::print("\n{}: {}\n", robot.name,
             wrong == 0 ? "ready for standing, pushes and steps"
                        : fmt::format("{} of the findings must be corrected before it can be used",
                                      wrong));
  return wrong == 0;
}

std::string run_settings(const ConfigurableBiped& defaults, const SurveyedRobot& robot,
                         const fs::path& urdf, const fs::path& config) {
  const std::unique_ptr<ConfigurableBiped> problem = defaults.clone();
  Settings keys;
  problem->declare(keys);  // the present values become the defaults
  problem->scale(walking::scale_of(robot.description));
  BipedSettings& settings = problem->settings();
  settings.robot.urdf = urdf.string();
  settings.robot.file = config.string();
  settings.push.link = robot.limbs.trunk;
  return keys.changes_to_yaml();
}

// True for the name of a visible folder directly in the current one.
bool is_folder_name(const std::string& name) {
  return !name.empty() && name.front() != '.' && name.find('/') == std::string::npos &&
         printable(name) == name;
}

ExitStatus make_new(const Request& request, const std::string& name,
                    const ConfigurableBiped& defaults) {
  const fs::path urdf = fs::absolute(request.urdf).lexically_normal();
  const robots::UrdfModel model = robots::UrdfModel::read(urdf);
  if (request.out.empty() && !is_folder_name(model.name()))
    throw InputError(
        fmt::format("{}: the name of the robot, '{}', cannot be a folder name here; give a folder "
                    "with --out DIR",
                    urdf.string(), shortened(model.name())));
  const fs::path folder = fs::absolute(request.out.empty() ? model.name() : request.out);
  for (const char* file : {"robot.yaml", "run.yaml"})
    if (std::error_code absent; fs::exists(folder / file, absent))
      throw InputError(fmt::format("{} exists already; remove it or give another --out",
                                   (folder / file).string()));
  const SurveyedRobot robot = survey_robot(model);
  const OutputFolder out(folder);
  out.write("robot.yaml", to_yaml(robot, model));
  out.write("run.yaml",
            fmt::format("# Settings of {} for {}, fitted to its size by `saltus robot new`.\n{}",
                        name, printable(shortened(robot.description.name)),
                        run_settings(defaults, robot, urdf, folder / "robot.yaml")));
  for (const std::string& note : robot.notes) fmt::print("note  {}\n", note);
  const robots::RobotDescription read_back =
      describe(model, robots::read_robot_description(folder / "robot.yaml",
                                                     robots::RobotDescription::Figures::from_urdf));
  const bool is_good = print_check(model, read_back, *fitted(defaults, read_back));
  fmt::print("Written: {0}/robot.yaml, {0}/run.yaml\n", folder.string());
  if (is_good)
    fmt::print("Next: saltus run {} --config {}/run.yaml --plant dart\n", name, folder.string());
  return is_good ? ExitStatus::ok : ExitStatus::bad_input;
}

ExitStatus check(const Request& request, const ConfigurableBiped& defaults) {
  const robots::UrdfModel model = robots::UrdfModel::read(request.urdf);
  const robots::RobotDescription robot =
      request.config.empty()
          ? survey_robot(model).description
          : describe(model, robots::read_robot_description(
                                request.config, robots::RobotDescription::Figures::from_urdf));
  return print_check(model, robot, *fitted(defaults, robot)) ? ExitStatus::ok
                                                             : ExitStatus::bad_input;
}

}  // namespace

Verb robot_verb(const std::string& problem, const ConfigurableBiped& defaults) {
  const std::shared_ptr<const ConfigurableBiped> shared = defaults.clone();
  return {"robot", summary, [problem, shared](std::span<const std::string> arguments) {
            if (!arguments.empty()) {
              const std::string& action = arguments.front();
              const std::span<const std::string> rest = arguments.subspan(1);
              const auto is_link = [](const std::string& word) {
                return word == "--link" || word.starts_with("--link=");
              };
              if (action == "serve") return robots::walking::serve_simulated_robot(rest, *shared);
              if (action == "play") return robots::walking::play_log(rest);
              if (action == "check" && std::ranges::any_of(rest, is_link))
                return robots::walking::check_live_robot(rest, *shared);
            }
            const Request request = parse(arguments);
            if (request.action == "help") {
              fmt::print("{}", usage);
              return ExitStatus::ok;
            }
            return request.action == "new" ? make_new(request, problem, *shared)
                                           : check(request, *shared);
          }};
}

}  // namespace saltus::survey
