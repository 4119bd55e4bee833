#include "saltus/app/plot_verb.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <span>
#include <string>

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

}  // namespace saltus
