// Main function of programs with verbs: runs the verb of the first argument, and converts errors to
// one sentence and an exit status.
#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json_fwd.hpp>

#include "saltus/app/settings.hpp"
#include "saltus/core/csv_table.hpp"

namespace saltus {

// Exit statuses of the programs of the project.

/// Exit status of a program. A robot that falls is a valid result: `ok`.
enum class ExitStatus {
  ok = 0,              ///< the run finished; its results contain the outcome
  internal_error = 1,  ///< unexpected error; please report it
  bad_input = 2,       ///< a file, key, flag or value is invalid; nothing was written
  solver_failed = 3,   ///< a solver failed; the results written so far name it and the reason
  not_applicable = 4,  ///< not applicable to this problem; a message explains why
  differs = 5,         ///< a comparison found a difference, or a check found a defect
  robot_lost = 6,      ///< a robot in another process sends no messages
  soft_stop = 7,       ///< a robot in another process was stopped after a fault
};

// Command line of `saltus run`.

/// Parsed form of `saltus run PROBLEM [--config FILE] [--set KEY=VALUE]... [--out DIR] [--KEY
/// VALUE]... [--quiet] [--json] [--print-config] [--print-schema]`. Any other flag names a setting:
/// `--KEY VALUE`, `--KEY=VALUE` and `--set KEY=VALUE` are equivalent, and `--KEY` alone sets a
/// boolean setting to true. `Settings` checks whether the problem has such a setting.
struct RunRequest {
  std::string problem;                               ///< name or alias of the problem
  std::optional<std::filesystem::path> config_file;  ///< value of --config
  std::vector<Assignment> assignments;  ///< settings of --set and other flags, in order
  std::filesystem::path out;            ///< results/PROBLEM unless --out is given
  bool quiet = false;                   ///< print only errors
  bool json = false;                    ///< print the summary as JSON instead of text
  bool help = false;                    ///< describe the settings instead of running
  std::string usage = {};     ///< usage text with the flags that every problem supports, set with
                              ///< --help
  bool print_config = false;  ///< print the resulting settings instead of running
  bool print_schema = false;  ///< print the JSON schema of the settings instead of running
};

/// Parses the arguments after the word `run`. Throws InputError if the problem is missing (unless
/// help is requested), a second one is given, --config or --out is repeated, or a value is missing.
RunRequest parse_run_request(std::span<const std::string> arguments);

// Formats of the tables of a run: CSV, and formats of other tools.

class Settings;

/// Formats of the tables of a run. CSV is always written: the plots and `saltus rerun` read it.
struct LogFormats {
  std::string names = "csv";  ///< "csv", "mat", "mcap" in any order, separated by commas
};

/// Declares `log.formats`, which rejects unknown names.
void declare_log_formats(Settings& settings, LogFormats& formats);

/// Error text that follows the name of the setting, such as "must name csv, ..."; empty if the
/// names are valid.
std::string validate_formats(const LogFormats& formats);

/// Writes run.mat and run.mcap from the tables of the folder as requested, with the Python package,
/// and prints the names of the files. If a Python package is missing, prints a message to the
/// error stream. Returns true if all requested files exist. Throws InputError if files cannot be
/// written.
bool write_logs(const LogFormats& formats, const std::filesystem::path& results);

// Output folder of a run, without partially written files.

/// A folder that is checked to be writable before any work begins, and created with the first file.
/// Every file is written to a temporary name and renamed: a reader, also after an interrupted run,
/// sees the old file or the new one. All errors throw InputError.
class OutputFolder {
 public:
  /// Throws InputError naming the folder if files cannot be created in it.
  explicit OutputFolder(std::filesystem::path path);

  /// Path of the folder.
  const std::filesystem::path& path() const { return path_; }

  /// Marks files of an earlier run for removal before the first write, so that files of two runs
  /// are never mixed. A run that writes nothing removes nothing.
  void clear_when_written(std::vector<std::string> names) { earlier_ = std::move(names); }
  /// Time when this folder was opened, by the file clock.
  std::filesystem::file_time_type begin() const { return begin_; }

  /// Writes a text unchanged.
  void write(std::string_view name, std::string_view content) const;
  /// Writes indented JSON. Non-finite numbers become null.
  void write(std::string_view name, const nlohmann::ordered_json& value) const;
  /// Writes a table as CSV.
  void write(std::string_view name, const CsvTable& table) const;

 private:
  std::filesystem::path path_;
  std::filesystem::file_time_type begin_;
  mutable std::vector<std::string> earlier_;
};

/// Output folder of the file given by `flag`, checked to be writable. Throws InputError if it is
/// not, or if the file is a folder.
OutputFolder folder_of_file(std::string_view flag, const std::filesystem::path& file);

// Registration of problems that the program runs by name.

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
void write_run_file(const OutputFolder& output, const std::string& problem);

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
    write_run_file(output, name);
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

/// A verb besides `list`, `run` and `help`. It receives the arguments after its name.
struct Verb {
  std::string name;     ///< the word on the command line
  std::string summary;  ///< one line for `saltus help`
  /// Runs the verb.
  std::function<ExitStatus(std::span<const std::string> arguments)> run;
};

/// A verb implemented by another program in the same folder: the process is replaced by that
/// program, with the verb and its arguments. Throws InputError if the program is missing.
Verb verb_of_program(std::string name, std::string summary, std::string program);

/// `int main(int argc, char** argv) { return saltus_main(argc, argv, problems); }`
///
/// InputError and DefinitionError end with one sentence on the error stream and status 2.
/// Unexpected exceptions end with status 1.
int saltus_main(int argc, const char* const* argv, std::span<const ProblemEntry> problems,
                std::span<const Verb> more_verbs = {});

}  // namespace saltus
