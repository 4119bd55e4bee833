// The command line of `saltus map`.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>

#include "problems/biped/survival/map.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/app/silent_output.hpp"
#include "saltus/core/error.hpp"

namespace saltus::robots::walking {
namespace {

constexpr const char* summary =
    "computes which pushes are recovered, by impulse, direction and step time: a table and a polar "
    "plot";

// Time in which the controllers move the CoM from the initial posture to above the sole, s.
constexpr double map_push_start = 1.0;

// Settings that the map varies, and settings that do not affect it.
constexpr std::array varied{"controller", "stepping", "push.impulse", "push.direction",
                            "step.duration"};

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts{""};
  for (const char c : text) {
    if (c == separator)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

double number(const std::string& flag, const std::string& text) {
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
  }
  if (used == 0 || used != text.size() || !std::isfinite(value))
    throw InputError(fmt::format("{}: '{}' is not a number", flag, text));
  return value;
}

int count(const std::string& flag, const std::string& text, int most) {
  const double value = number(flag, text);
  if (!(value >= 1.0 && value <= most) || value != std::round(value))
    throw InputError(fmt::format("{} is '{}'; use a whole number from 1 to {}", flag, text, most));
  return static_cast<int>(value);
}

// Positive numbers, in ascending order, without repetition: a,b,c or first:step:last.
std::vector<double> numbers(const std::string& flag, const std::string& text) {
  constexpr int most = 1000;
  std::vector<double> values;
  if (const auto range = split(text, ':'); range.size() == 3) {
    const double first = number(flag, range[0]), step = number(flag, range[1]),
                 last = number(flag, range[2]);
    if (!(step > 0.0 && last >= first && (last - first) / step < most))
      throw InputError(
          fmt::format("{}: '{}' is not a range; use FIRST:STEP:LAST with at most {} numbers", flag,
                      text, most));
    constexpr double rounding = 1e-9;  // allowance for the last value, as a fraction of the step
    for (int i = 0; first + i * step <= last + rounding * step; ++i)
      values.push_back(first + i * step);
  } else {
    if (range.size() != 1)
      throw InputError(fmt::format("{}: '{}' is not a range; use FIRST:STEP:LAST", flag, text));
    for (const std::string& part : split(text, ',')) values.push_back(number(flag, part));
  }
  std::sort(values.begin(), values.end());
  if (!(values.front() > 0.0))
    throw InputError(fmt::format("{}: {} must be above 0", flag, values.front()));
  if (const auto twice = std::adjacent_find(values.begin(), values.end()); twice != values.end())
    throw InputError(fmt::format("{}: {} is given twice", flag, *twice));
  return values;
}

std::vector<MapController> controllers(const std::string& text) {
  std::vector<MapController> list;
  for (const std::string& name : split(text, ',')) {
    const MapController c = map_controller(name);
    if (std::find(list.begin(), list.end(), c) != list.end())
      throw InputError(fmt::format("--controllers: {} is given twice", name));
    list.push_back(c);
  }
  return list;
}

void refuse_varied(const std::vector<Assignment>& assignments) {
  for (const Assignment& a : assignments)
    if (std::find(varied.begin(), varied.end(), a.key) != varied.end())
      throw InputError(fmt::format(
          "{}: the map itself varies {}; see --impulses, --directions, --step-times and "
          "--controllers",
          a.location, a.key));
}

// The settings as YAML. Varied settings have their defaults, whatever the file contains.
std::string stamp(const ConfigurableBiped& problem) {
  const std::unique_ptr<ConfigurableBiped> stamped = problem.clone();
  BipedSettings& settings = stamped->settings();
  const BipedSettings defaults;
  settings.controller = defaults.controller;
  settings.step.allowed = defaults.step.allowed;
  settings.push.impulse = defaults.push.impulse;
  settings.push.direction = defaults.push.direction;
  settings.step.duration = defaults.step.duration;
  settings.pictures = defaults.pictures;
  Settings keys;
  stamped->declare(keys);
  return fmt::format(
      "# Settings of a survival map. It varies {}; their values here are the defaults.\n{}",
      fmt::join(varied, ", "), keys.to_yaml());
}

}  // namespace

MapRequest parse_map_request(const ConfigurableBiped& defaults,
                             std::span<const std::string> arguments) {
  MapRequest request;
  request.problem = defaults.clone();
  BipedSettings& config = request.problem->settings();
  request.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  request.grid = {directions_far_apart(16), numbers("--impulses", "1:1:16"),
                  numbers("--step-times", "0.3,0.45,0.6"), controllers("mpc,capture_point,none"),
                  false};
  std::optional<std::filesystem::path> config_file;
  std::vector<Assignment> assignments;
  bool are_times_given = false;
  OptionParser parser("map", summary);
  const auto option = [&](const char* flag, const char* what, const char* doc, auto take) {
    parser.option(flag, what, doc, [flag, take](const std::string& value) { take(flag, value); });
  };
  using Text = const std::string&;
  option("--plant", "NAME", "centroidal, dart or mujoco",
         [&](const char*, Text value) { assignments.push_back(flag_assignment("plant", value)); });
  parser.repeated("--set", "KEY=VALUE", "a setting of push_recovery",
                  [&](Text text) { assignments.push_back(parse_set_argument(text)); });
  option("--config", "FILE", "settings of push_recovery as YAML",
         [&](const char*, Text value) { config_file = value; });
  option("--directions", "N", "number of directions, evenly spread; default 16",
         [&](const char* flag, Text value) {
           request.grid.directions = directions_far_apart(count(flag, value, 360));
         });
  option("--impulses", "LIST", "impulses in N s: a,b,c or FIRST:STEP:LAST",
         [&](const char* flag, Text value) { request.grid.impulses = numbers(flag, value); });
  option("--step-times", "LIST", "step times in s: a,b,c or FIRST:STEP:LAST",
         [&](const char* flag, Text value) {
           request.grid.step_times = numbers(flag, value);
           are_times_given = true;
         });
  option("--controllers", "LIST", "list of mpc, capture_point and none",
         [&](const char*, Text value) { request.grid.controllers = controllers(value); });
  parser.flag("--all", "run every cell, even if its outcome is predictable", request.grid.all);
  option("--out", "DIR", "folder of the results",
         [&](const char*, Text value) { request.out = value; });
  option("--jobs", "N", "number of cells in parallel",
         [&](const char* flag, Text value) { request.jobs = count(flag, value, 1024); });
  parser.flag("--quiet", "print only errors", request.quiet);
  parser.flag("--json", "print the cells as JSON instead of text", request.json);
  parser.parse(arguments);
  if (parser.help_wanted()) request.help = parser.help();
  if (request.quiet && request.json)
    throw InputError("--quiet and --json exclude each other; give one of them");
  refuse_varied(assignments);
  config.push.start = map_push_start;
  Settings settings;
  request.problem->declare(settings);
  settings.apply(config_file, assignments);
  for (const std::string& warning : settings.warnings())
    fmt::print(stderr, "saltus: {}\n", warning);
  if (config.more_pushes.rate > 0.0)
    throw InputError(
        "push.random.rate_hz: a map has one given push per cell, so random pushes are not "
        "available; leave it at 0, or use `saltus bench pushes`");
  if (config.step.planner == Step::Planner::ocp) {
    if (are_times_given)
      throw InputError(
          "--step-times: step.planner=ocp chooses the times itself; omit the option, or set "
          "step.planner=icp_formula");
    request.grid.step_times = {};
  }
  request.pictures = config.pictures;
  request.settings = stamp(*request.problem);
  for (const double t : request.grid.step_times)
    if (t < config.push.duration)
      throw InputError(
          fmt::format("--step-times: the foot lands after {} s, before the push ends "
                      "(push.duration is {} s)",
                      t, config.push.duration));
  if (request.out.empty()) {
    const char* const folders[] = {"map_centroidal", "map_dart", "map_mujoco"};
    request.out = std::filesystem::path("results") / folders[static_cast<int>(config.plant.choice)];
  }
  return request;
}

Verb map_verb(const ConfigurableBiped& defaults) {
  const std::shared_ptr<const ConfigurableBiped> problem = defaults.clone();
  return {"map", summary, [problem](std::span<const std::string> arguments) {
            const MapRequest request = parse_map_request(*problem, arguments);
            if (!request.help.empty()) {
              fmt::print("{}", request.help);
              return ExitStatus::ok;
            }
            if (!request.quiet && !request.json) return run_map(request);
            std::string json;
            ExitStatus status = ExitStatus::ok;
            {
              const SilentOutput silence;
              status = run_map(request, &json);
            }
            if (request.json) fmt::print("{}\n", json);
            return status;
          }};
}

}  // namespace saltus::robots::walking
