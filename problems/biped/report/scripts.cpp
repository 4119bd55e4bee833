#include "problems/biped/report/scripts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "saltus/app/option_parser.hpp"
#include "saltus/app/program.hpp"
#include "saltus/app/python_script.hpp"
#include "saltus/core/error.hpp"

namespace saltus::robots::walking {

void draw(const std::filesystem::path& results, const char* what, const std::string& module) {
  run_python_module("saltus.walking." + module, results, what);
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
  for (const fs::directory_entry& entry : fs::directory_iterator(results, absent)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() == ".png" && is_new(name.c_str())) pictures.push_back(name);
  }
  std::ranges::sort(pictures);
  const auto add = [&text](const std::string& names, const char* what) {
    text += fmt::format("  {:<31} {}\n", names, what);
  };
  add("summary.json, config.yaml", "verdict and figures; all settings");
  add(is_new("body.csv") ? "trajectory, body, ticks (.csv)" : "trajectory.csv, ticks.csv",
      "tables of the run");
  if (!pictures.empty()) text += fmt::format("  {}\n", fmt::join(pictures, ", "));
  const bool report = is_new("report.html"), view = is_new("view.html");
  if (report) add("report.html", "report on one page");
  if (view) add("view.html", "animation of the robot with all curves: play, pause, scrub, zoom");
  if (report) {
    const std::string page = fs::absolute(results / "report.html").lexically_normal().string();
    text += fmt::format("Open report.html in a browser; it needs no network{}: xdg-open {}\n",
                        view ? " and links to view.html" : "", page);
  }
  return text;
}

Verb movie_verb() {
  constexpr const char* summary = "makes a video of a whole-body run from its view";
  return {"movie", summary, [](std::span<const std::string> arguments) {
            std::string folder;
            OptionParser parser("movie", summary);
            parser.word("DIR", "the --out folder of a run with --plant dart or mujoco", folder);
            if (parser.prints_help(arguments)) return ExitStatus::ok;
            if (folder.empty())
              throw InputError("movie needs the folder of a run, as in saltus movie results/demo");
            if (!std::filesystem::exists(std::filesystem::path(folder) / "view.html"))
              throw InputError(fmt::format(
                  "movie: there is no {}/view.html; a run with --plant dart or mujoco writes it",
                  folder));
            const AddedFiles movie(folder);
            const bool is_drawn = run_python_module("saltus.walking.movie", folder, "movie");
            movie.note();
            return is_drawn ? ExitStatus::ok : ExitStatus::not_applicable;
          }};
}

}  // namespace saltus::robots::walking
