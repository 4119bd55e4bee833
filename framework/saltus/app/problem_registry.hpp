// How a problem presents itself to the program that runs it by name.
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

/// A problem by name. `run` does everything from reading the settings to writing the results;
/// `problem_entry` makes it from the two functions that differ between problems.
struct ProblemEntry {
  std::string name;     ///< under which `saltus run` finds it
  std::string summary;  ///< one line for `saltus list`
  /// Reads the settings, runs, writes the results.
  std::function<ExitStatus(const RunRequest&)> run;
  std::vector<std::string> aliases = {};  ///< other names under which it is found
  std::string kind = {};                  ///< for `saltus list`: "optimal control", "simulation"
  /// Calls `use` with the settings as they are declared; empty if there are none.
  std::function<void(const std::function<void(const Settings&)>& use)> with_settings = {};
};

/// What a problem is given besides its configuration.
struct RunContext {
  const RunRequest& request;            ///< the command line, as it was read
  OutputFolder& output;                 ///< known to be writable
  const std::string& effective_config;  ///< all settings as YAML, to be kept beside the results
};

/// What the run before left in the folder, by its run.json, goes as soon as this one writes.
void replace_earlier_run(OutputFolder& output);

/// Leaves run.json in the folder, if the run left anything there: what `saltus rerun` needs to know
/// beside config.yaml, and which files are of this run.
void note_run(const OutputFolder& output, const std::string& problem);

/// What a verb adds to the folder of a run that is over (pictures, other formats) is of that run
/// from then on, and goes with it. Made before the verb writes.
class AddedFiles {
 public:
  /// Takes note of what lies there.
  explicit AddedFiles(std::filesystem::path folder);
  /// Names in run.json what was written since; nothing where run.json does not tell of files.
  /// Throws InputError if it cannot be written.
  void note() const;

 private:
  std::filesystem::path folder_;
  std::map<std::string, std::filesystem::file_time_type> before_;
};

/// The usual entry. `declare` binds the keys to the fields of a Config, whose values are the
/// defaults; `run` is called with what file and command line made of it, after everything has been
/// checked. With --help, --print-config or --print-schema the settings are printed instead. Every
/// problem has the setting `log.formats`: what is asked for beside CSV and cannot be written makes
/// a good run `not_applicable`.
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
