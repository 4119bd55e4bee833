#include "saltus/app/logs_verb.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <span>
#include <string>

#include "saltus/app/option_parser.hpp"
#include "saltus/app/program.hpp"
#include "saltus/core/error.hpp"

namespace saltus {

Verb logs_verb() {
  constexpr const char* summary = "converts the tables of a run to MAT (v7.3) and MCAP";
  return {"logs", summary, [](std::span<const std::string> arguments) {
            std::string folder;
            LogFormats formats{.names = "mat,mcap"};
            OptionParser parser("logs", summary);
            parser.word("DIR", "results folder of Saltus or of your own project", folder)
                .option("--formats", "LIST", "mat, mcap or mat,mcap; default both", formats.names);
            if (parser.prints_help(arguments)) return ExitStatus::ok;
            if (const std::string wrong = validate_formats(formats); !wrong.empty())
              throw InputError("logs: --formats: " + wrong);
            if (folder.empty())
              throw InputError("logs needs the folder of a run, as in saltus logs results/demo");
            std::error_code absent;
            if (!std::filesystem::is_directory(folder, absent))
              throw InputError(fmt::format("logs: there is no folder '{}'", folder));
            if (!std::filesystem::exists(std::filesystem::path(folder) / "trajectory.csv", absent))
              throw InputError(fmt::format("logs: there is no trajectory.csv in '{}'", folder));
            const AddedFiles logs(folder);
            const bool all = write_logs(formats, folder);
            logs.note();
            return all ? ExitStatus::ok : ExitStatus::not_applicable;
          }};
}

}  // namespace saltus
