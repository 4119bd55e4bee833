#include "saltus/robots/report/scripts.hpp"

#include <fmt/format.h>

#include <vector>

#include "saltus/app/python_script.hpp"

namespace saltus::walking {

void draw(const std::filesystem::path& results, const char* what, const std::string& script) {
  run_python_script("robots/report/scripts/" + script, results, what);
}

std::string results_text(const std::filesystem::path& results,
                         std::filesystem::file_time_type begin) {
  namespace fs = std::filesystem;
  std::error_code absent;
  const auto is_new = [&](const char* name) {
    const auto written = fs::last_write_time(results / name, absent);
    return !absent && written >= begin;
  };
  std::string text = fmt::format("results in {}\n", results.string());
  std::vector<std::string> pictures;
  for (const char* name : {"capture_point.png", "com.png", "forces.png", "measured_forces.png",
                           "feet.png", "torques.png"})
    if (is_new(name)) pictures.emplace_back(name);
  const auto add = [&text](const std::string& names, const char* what) {
    text += fmt::format("  {:<31} {}\n", names, what);
  };
  add("summary.json, config.yaml", "verdict and figures; all settings in force");
  add(is_new("body.csv") ? "trajectory, body, ticks (.csv)" : "trajectory.csv, ticks.csv",
      "the run in tables");
  if (!pictures.empty()) text += fmt::format("  {}\n", fmt::join(pictures, ", "));
  const bool report = is_new("report.html"), replay = is_new("replay.html");
  if (report) add("report.html", "all of it on one page");
  if (replay) add("replay.html", "the robot moves: play, pause, scrub, slow motion");
  if (report) {
    const std::string page = fs::absolute(results / "report.html").lexically_normal().string();
    text += fmt::format(
        "To look at it, open report.html in a browser, it needs no network{}: xdg-open {}\n",
        replay ? " and links to the replay" : "", page);
  }
  return text;
}

}  // namespace saltus::walking
