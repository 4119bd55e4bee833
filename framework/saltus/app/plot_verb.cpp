#include "saltus/app/plot_verb.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "saltus/app/option_parser.hpp"
#include "saltus/app/program.hpp"
#include "saltus/app/python_script.hpp"
#include "saltus/core/error.hpp"

namespace saltus {

Verb plot_verb() {
  constexpr const char* summary = "draws all plots of a run or a map again from its tables";
  return {"plot", summary, [](std::span<const std::string> arguments) {
            std::string folder;
            OptionParser parser("plot", summary);
            parser.word("DIR", "the --out folder of a run or a map", folder);
            if (parser.prints_help(arguments)) return ExitStatus::ok;
            if (folder.empty())
              throw InputError("plot needs the folder of a run, as in saltus plot results/demo");
            std::error_code absent;
            if (!std::filesystem::is_directory(folder, absent))
              throw InputError(fmt::format("plot: there is no folder '{}'", folder));
            const AddedFiles pictures(folder);
            const bool is_drawn = run_python_module("saltus.plot", folder, "pictures");
            pictures.note();
            return is_drawn ? ExitStatus::ok : ExitStatus::not_applicable;
          }};
}

Verb view_verb() {
  constexpr const char* summary = "writes a page with plots and an animated scene of a run";
  return {"view", summary, [](std::span<const std::string> arguments) {
            std::string folder, scene;
            std::vector<std::string> more;
            bool opens = false, is_live = false;
            OptionParser parser("view", summary);
            parser.word("DIR", "results folder of Saltus or of your own project", folder)
                .repeated("--with", "DIR", "another run, for comparison",
                          [&](const std::string& other) { more.push_back("--with=" + other); })
                .option("--scene", "FILE", "description of the scene; default: DIR/scene.json",
                        scene)
                .flag("--open", "opens the page in the browser", opens)
                .flag("--live", "updates the page while the run continues", is_live);
            if (parser.prints_help(arguments)) return ExitStatus::ok;
            if (folder.empty())
              throw InputError("view needs the folder of a run, as in saltus view results/demo");
            std::error_code absent;
            if (!is_live && !std::filesystem::is_directory(folder, absent))
              throw InputError(fmt::format("view: there is no folder '{}'", folder));
            if (!scene.empty()) more.push_back("--scene=" + scene);
            if (opens) more.emplace_back("--open");
            if (is_live) more.emplace_back("--live");
            const AddedFiles page(folder);
            const bool is_written = run_python_module("saltus.viewer", folder, "page", more);
            page.note();
            return is_written ? ExitStatus::ok : ExitStatus::not_applicable;
          }};
}

}  // namespace saltus
