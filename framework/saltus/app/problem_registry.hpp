// Registration of problems that the program runs by name.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "saltus/app/command_line.hpp"
#include "saltus/app/exit_status.hpp"
#include "saltus/app/log_formats.hpp"
#include "saltus/app/output_folder.hpp"
#include "saltus/app/settings.hpp"

namespace saltus {

/// A problem with its name. `run` does everything from reading the settings to writing the results.
/// `problem_entry` creates it from the two functions that differ between problems.
struct ProblemEntry {
  std::string name;     ///< name for `saltus run`
  std::string summary;  ///< one line for `saltus list`
  /// Reads the settings, runs, and writes the results.
  std::function<ExitStatus(const RunRequest&)> run;
  std::vector<std::string> aliases = {};  ///< alternative names
  std::string kind = {};  ///< kind of problem for `saltus list`: "optimal control", "simulation"
  /// Calls `use` with the declared settings; empty if there are none.
  std::function<void(const std::function<void(const Settings&)>& use)> with_settings = {};
};

/// Inputs of a problem besides its configuration.
struct RunContext {
  const RunRequest& request;            ///< the parsed command line
  OutputFolder& output;                 ///< checked to be writable
  const std::string& effective_config;  ///< all settings as YAML, to store with the results
};

/// Marks the files that run.json lists for removal when this run writes its first file.
void replace_earlier_run(OutputFolder& output);

/// Writes run.json if the run wrote anything to the folder. It holds the data that `saltus rerun`
/// needs in addition to config.yaml, and the names of the files.
void note_run(const OutputFolder& output, const std::string& problem);

/// Records files that a verb adds to the folder of a finished run (plots, other formats), so that
/// they are removed with the run. Create the object before the verb writes.
class AddedFiles {
 public:
  /// Lists the current files of the folder.
  explicit AddedFiles(std::filesystem::path folder);
  /// Adds the new files to run.json. Does nothing if run.json lists no files. Throws InputError if
  /// it cannot be written.
  void note() const;

 private:
  std::filesystem::path folder_;
  std::map<std::string, std::filesystem::file_time_type> before_;
};

/// The standard entry. `declare` binds the keys to the fields of a Config, whose values are the
/// defaults. `run` is called with the resulting Config after all checks. With --help,
/// --print-config or --print-schema the settings are printed instead. Every problem has the setting
/// `log.formats`. If a requested format cannot be written, the status of a successful run is
/// `not_applicable`.
///
///     problem_entry<PushConfig>("push_recovery", "iCub caught by a step", declare_settings, run)
template <class Config>
ProblemEntry problem_entry(std::string name, std::string summary,
                           void (*declare)(Settings&, Config&),
                           std::function<ExitStatus(const Config&, const RunContext&)> run) {
  auto entry = [declare, run = std::move(run), name, summary](const RunRequest& request) {
    Config config{};
    Settings settings;
    declare(settings, config);
    LogFormats logs;
    declare_log_formats(settings, logs);
    if (request.help) {
      fmt::print("{}: {}\n\n{}\nSettings (--set KEY=VALUE, --KEY VALUE, or a YAML file):\n{}", name,
                 summary, request.usage, settings.describe());
      return ExitStatus::ok;
    }
    if (request.print_schema) {
      fmt::print("{}", settings.json_schema(name));
      return ExitStatus::ok;
    }
    settings.apply(request.config_file, request.assignments);
    for (const std::string& warning : settings.warnings())
      fmt::print(stderr, "saltus: {}\n", warning);
    if (request.print_config) {
      fmt::print("# {}: {}\n{}", name, summary, settings.to_documented_yaml());
      return ExitStatus::ok;
    }
    OutputFolder output(request.out);
    replace_earlier_run(output);
    const std::string effective_config = settings.to_yaml();
    const ExitStatus status = run(config, RunContext{request, output, effective_config});
    const bool logged = write_logs(logs, output.path());
    note_run(output, name);
    return logged || status != ExitStatus::ok ? status : ExitStatus::not_applicable;
  };
  const auto with_settings = [declare](const std::function<void(const Settings&)>& use) {
    Config config{};
    Settings settings;
    declare(settings, config);
    LogFormats logs;
    declare_log_formats(settings, logs);
    use(settings);
  };
  return {std::move(name), std::move(summary), std::move(entry), {}, {}, with_settings};
}

}  // namespace saltus
