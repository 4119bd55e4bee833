#include "saltus/app/rerun.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <utility>

#include "saltus/app/json_text.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/version.hpp"
#include "saltus/core/csv_table.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/file_content.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* run_file = "run.json";

// Names of values that differ between identical runs: computing times and versions.
bool is_timing(const std::string& name) {
  static const std::set<std::string> names{"solve time [s]",
                                           "solve time [us]",
                                           "processor time [us]",
                                           "check time [s]",
                                           "solve_us_by_provenance",
                                           "solve_s",
                                           "check_s",
                                           "seconds",
                                           "worst_tick",
                                           "deadline_misses",
                                           "saltus"};
  // Only computing times are in microseconds, or in seconds per simulated second.
  return name.ends_with("_us") || name.ends_with("_s_per_s") || names.contains(name);
}

std::string content_of(const fs::path& file) {
  constexpr std::size_t longest_table = std::size_t{1} << 32U;  // runs write 100 MB per minute
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    throw InputError(fmt::format(
        "rerun: '{}' cannot be read: {}", file.string(),
        std::filesystem::exists(file, error) ? "it is not a file" : "there is no such file"));
  return file_content(file, file.extension() == ".csv" ? longest_table : max_file_size);
}

FileComparison compare_tables(const std::string& name, const std::string& before,
                              const std::string& after) {
  std::istringstream one(before), other(after);
  std::string line, other_line;
  std::getline(one, line);
  std::getline(other, other_line);
  if (line != other_line) return {name, false, "has different columns"};
  const std::vector<std::string> columns = csv_cells(line);
  long rows = 0;
  while (true) {
    const bool has_one = !std::getline(one, line).fail();
    const bool has_other = !std::getline(other, other_line).fail();
    if (has_one != has_other)
      return {name, false, fmt::format("{} after {} rows", has_one ? "ends" : "continues", rows)};
    if (!has_one) break;
    ++rows;
    if (line == other_line) continue;
    const std::vector<std::string> cells = csv_cells(line), other_cells = csv_cells(other_line);
    if (cells.size() != columns.size() || other_cells.size() != columns.size())
      return {name, false, fmt::format("has a wrong number of cells in row {}", rows)};
    for (std::size_t i = 0; i < columns.size(); ++i)
      if (cells[i] != other_cells[i] && !is_timing(columns[i]))
        return {name, false,
                fmt::format("differs first in row {}, column '{}': {} was {}", rows,
                            shortened(columns[i]), shortened(other_cells[i]), shortened(cells[i]))};
  }
  const bool is_timed = std::ranges::any_of(columns, is_timing);
  return {name, true,
          fmt::format("bit-identical ({} rows{})", rows,
                      is_timed ? ", except for computing times" : "")};
}

// Path of the first entry that differs; empty if none does.
std::string first_difference(const Json& before, const Json& after, const std::string& way) {
  if (before.is_object() && after.is_object()) {
    const auto below = [&way](const std::string& key) {
      return way.empty() ? key : fmt::format("{}.{}", way, key);
    };
    for (const auto& [key, value] : before.items()) {
      if (is_timing(key)) continue;
      if (!after.contains(key)) return below(key) + " is missing";
      std::string found = first_difference(value, after.at(key), below(key));
      if (!found.empty()) return found;
    }
    for (const auto& [key, value] : after.items())
      if (!before.contains(key) && !is_timing(key)) return below(key) + " is new";
    return {};
  }
  if (before.is_array() && after.is_array() && before.size() == after.size()) {
    for (std::size_t i = 0; i < before.size(); ++i) {
      std::string found = first_difference(before[i], after[i], fmt::format("{}[{}]", way, i));
      if (!found.empty()) return found;
    }
    return {};
  }
  if (before.dump() == after.dump()) return {};
  return fmt::format("{}: {} was {}", way, shortened(after.dump()), shortened(before.dump()));
}

FileComparison compare_summaries(const std::string& name, const std::string& before,
                                 const std::string& after) {
  reject_deep_json(before, name);
  reject_deep_json(after, name);
  const Json one = Json::parse(before, nullptr, /*allow_exceptions=*/false);
  const Json other = Json::parse(after, nullptr, /*allow_exceptions=*/false);
  if (one.is_discarded() || other.is_discarded()) return {name, false, "is not JSON"};
  const std::string difference = first_difference(one, other, "");
  return {name, difference.empty(),
          difference.empty() ? "bit-identical (except for computing times)"
                             : "differs first at " + shortened(difference)};
}

// True if a later run may remove the file. The file run.json may come from an untrusted source.
bool is_removable(const fs::path& name) {
  static const std::set<std::string> kinds{".csv",  ".gif", ".html", ".json", ".mat",
                                           ".mcap", ".mp4", ".png",  ".txt",  ".yaml"};
  return name == name.filename() && kinds.contains(name.extension().string());
}

// Files of a folder that may belong to a run, and their times.
std::map<std::string, fs::file_time_type> files_with_times(const fs::path& folder) {
  std::map<std::string, fs::file_time_type> files;
  std::error_code unknown;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, unknown))
    if (is_removable(entry.path().filename()) && entry.is_regular_file(unknown))
      files[entry.path().filename().string()] = entry.last_write_time(unknown);
  return files;
}

// Returns a discarded value if the text is not JSON. Throws InputError if it cannot be read or is
// nested too deeply.
Json parsed_run_file(const fs::path& folder) {
  const fs::path file = folder / run_file;
  const std::string text = content_of(file);
  reject_deep_json(text, file.string());
  return Json::parse(text, nullptr, /*allow_exceptions=*/false);
}

// Files of the run whose run.json is in the folder; empty if it lists none.
std::vector<std::string> files_of_run(const fs::path& folder) {
  std::vector<std::string> files;
  try {
    const Json run = parsed_run_file(folder);
    if (!run.is_object() || !run.contains("files") || !run["files"].is_array()) return files;
    for (const Json& name : run["files"])
      if (name.is_string() && is_removable(name.get<std::string>())) files.push_back(name);
  } catch (const InputError&) {  // the run is unknown
  }
  return files;
}

Json saltus_json() { return {{"version", version()}, {"commit", commit()}}; }

// Reads run.json. Throws InputError that names missing entries.
Json read_run_file(const fs::path& folder) {
  std::error_code absent;
  if (!fs::is_directory(folder, absent))
    throw InputError(fmt::format("rerun: there is no folder '{}'", folder.string()));
  for (const char* name : {run_file, "config.yaml"})
    if (!fs::exists(folder / name, absent))
      throw InputError(
          fmt::format("rerun: there is no {} in '{}'; the folder of a finished run has it", name,
                      folder.string()));
  Json run = parsed_run_file(folder);
  if (run.is_discarded() || !run.contains("problem") || !run["problem"].is_string() ||
      !run.contains("folder") || !run["folder"].is_string())
    throw InputError(fmt::format("rerun: '{}' does not name the problem of the run",
                                 (folder / run_file).string()));
  return run;
}

}  // namespace

void replace_earlier_run(OutputFolder& output) {
  output.clear_when_written(files_of_run(output.path()));
}

void write_run_file(const OutputFolder& output, const std::string& problem) {
  std::error_code unknown;
  if (!fs::exists(output.path() / "config.yaml", unknown)) return;
  std::set<std::string> files{run_file};
  for (const auto& [name, written] : files_with_times(output.path()))
    if (written >= output.begin()) files.insert(name);
  output.write(run_file, Json{{"problem", problem},
                              {"folder", fs::current_path(unknown).string()},
                              {"saltus", saltus_json()},
                              {"files", files}});
}

AddedFiles::AddedFiles(fs::path folder)
    : folder_(std::move(folder)), before_(files_with_times(folder_)) {}

void AddedFiles::note() const {
  const std::vector<std::string> of_the_run = files_of_run(folder_);
  if (of_the_run.empty()) return;
  std::set<std::string> files(of_the_run.begin(), of_the_run.end());
  for (const auto& [name, written] : files_with_times(folder_)) {
    const auto earlier = before_.find(name);
    if (earlier == before_.end() || earlier->second != written) files.insert(name);
  }
  if (files.size() == of_the_run.size()) return;
  Json run = parsed_run_file(folder_);
  run["files"] = files;
  OutputFolder(folder_).write(run_file, run);
}

std::vector<FileComparison> compare_runs(const fs::path& before, const fs::path& after) {
  std::set<std::string> names;
  const bool have_shapes = fs::exists(before / "robot.json") && fs::exists(after / "robot.json");
  for (const fs::path& folder : {before, after}) {
    const std::vector<std::string> files = files_of_run(folder);
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      const bool is_of_the_run =
          files.empty() || std::find(files.begin(), files.end(), name) != files.end();
      if (is_of_the_run && (entry.path().extension() == ".csv" || name == "summary.json" ||
                            (have_shapes && name == "robot.json")))
        names.insert(name);
    }
  }
  std::vector<FileComparison> comparisons;
  for (const std::string& name : names) {
    if (!fs::exists(before / name) || !fs::exists(after / name)) {
      comparisons.push_back({name, false, fs::exists(before / name) ? "is missing" : "is new"});
      continue;
    }
    const std::string one = content_of(before / name), other = content_of(after / name);
    comparisons.push_back(name.ends_with(".csv") ? compare_tables(name, one, other)
                                                 : compare_summaries(name, one, other));
  }
  return comparisons;
}

ExitStatus rerun(std::span<const std::string> arguments, std::span<const ProblemEntry> problems) {
  std::string word, out;
  OptionParser parser("rerun", "Repeats a run and compares the results bit by bit.");
  parser.word("folder", "folder of the run", word)
      .option("--out", "DIR",
              "folder of the new results; by default they are kept only if they differ", out);
  if (parser.prints_help(arguments)) return ExitStatus::ok;
  if (word.empty()) throw InputError("rerun needs the folder of a run");
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(fs::absolute(word), error);
  const Json run = read_run_file(folder);
  const std::string name = run["problem"];
  const auto problem = std::ranges::find(problems, name, &ProblemEntry::name);
  if (problem == problems.end())
    throw InputError(fmt::format("rerun: this program has no problem '{}'", shortened(name)));
  const fs::path again =
      out.empty() ? folder.parent_path() / fmt::format("{}.again", folder.filename().string())
                  : fs::absolute(out);
  if (fs::exists(again, error) && !fs::is_empty(again, error))
    throw InputError(
        fmt::format("rerun: '{}' exists already; give another folder with --out", again.string()));

  // Relative file names in settings refer to the folder in which the run was made.
  fs::current_path(run["folder"].get<std::string>(), error);
  if (error)
    fmt::print(stderr,
               "saltus: the run was made in {}, which no longer exists; files are searched for "
               "here\n",
               run["folder"].get<std::string>());
  RunRequest request;
  request.problem = name;
  request.config_file = folder / "config.yaml";
  request.out = again;
  const ExitStatus status = problem->run(request);

  if (!fs::exists(again, error)) return status;
  bool is_same = true;
  for (const FileComparison& file : compare_runs(folder, again)) {
    fmt::print("{}: {}\n", file.name, file.text);
    is_same = is_same && file.is_same;
  }
  const Json made_by = run.contains("saltus") ? run["saltus"] : Json();
  if (made_by.dump() != saltus_json().dump())
    fmt::print("made by another version: {}, now {}\n", made_by.dump(), saltus_json().dump());
  const bool is_removed = is_same && out.empty();
  if (is_removed) fs::remove_all(again, error);
  if (is_removed) fmt::print("{} is removed\n", again.string());
  fmt::print("{}\n", is_same ? "bit-identical"
                             : fmt::format("different; the new results are in {}", again.string()));
  return is_same ? ExitStatus::ok : ExitStatus::differs;
}

}  // namespace saltus
