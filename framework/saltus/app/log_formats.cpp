#include "saltus/app/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>
#include <vector>

#include "saltus/app/python_script.hpp"
#include "saltus/app/settings.hpp"

namespace saltus {
namespace {

constexpr std::array<std::string_view, 3> known{"csv", "mat", "mcap"};

std::vector<std::string> names_of(const LogFormats& formats) {
  std::vector<std::string> names;
  std::istringstream stream(formats.names);
  for (std::string name; std::getline(stream, name, ',');) names.push_back(name);
  return names;
}

}  // namespace

std::string validate_formats(const LogFormats& formats) {
  for (const std::string& name : names_of(formats))
    if (std::ranges::find(known, name) == known.end())
      return fmt::format("must name csv, mat or mcap, separated by commas without spaces, not '{}'",
                         name);
  return {};
}

void declare_log_formats(Settings& settings, LogFormats& formats) {
  settings.text(
      "log.formats", formats.names,
      "formats of the tables: csv (always written), mat (run.mat, v7.3 in the layout of "
      "robometry), mcap (run.mcap, JSON for Foxglove and PlotJuggler); python3 needs h5py "
      "for mat, and mcap for mcap");
  settings.rule({"log.formats"}, [&formats] {
    const std::string wrong = validate_formats(formats);
    return wrong.empty() ? wrong : "log.formats " + wrong;
  });
}

bool write_logs(const LogFormats& formats, const std::filesystem::path& results) {
  std::vector<std::string> wanted = names_of(formats);
  std::erase(wanted, "csv");
  if (wanted.empty()) return true;
  const bool all = run_python_module("saltus.logs", results, "logs", wanted);
  if (all) fmt::print("written to {}: run.{}\n", results.string(), fmt::join(wanted, ", run."));
  return all;
}

}  // namespace saltus
