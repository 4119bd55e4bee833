// `saltus map`: recovery from pushes as a function of impulse, direction and step time.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "problems/biped/configurable_biped.hpp"
#include "problems/biped/survival/map_plan.hpp"
#include "saltus/app/program.hpp"

namespace saltus::walking {

/// Options of a survival map.
struct MapRequest {
  std::shared_ptr<ConfigurableBiped> problem;  ///< problem that is pushed
  std::string settings;       ///< what decides about an outcome besides the cell, as YAML
  MapGrid grid;               ///< of pushes and step times
  std::filesystem::path out;  ///< folder for table and picture
  int jobs = 1;               ///< number of parallel runs
  bool pictures = true;       ///< draw the picture at the end
  bool quiet = false;         ///< print nothing but errors
  bool json = false;          ///< print the cells as JSON instead of text
  std::string help = {};      ///< not empty: print this help instead of a map
};

/// Parses the arguments of `map`, for a problem with these defaults. Throws InputError.
MapRequest parse_map_request(const ConfigurableBiped& defaults,
                             std::span<const std::string> arguments);

/// The largest impulse (N s) up to which everything was recovered, by controller and step time,
/// and the pendulum's bound, a line per direction (Markdown). A star marks recoveries beyond.
/// Then which share of the area within the bound that is, by direction and in all.
std::string map_summary(const MapPlan& plan);

/// The cells that are known as a JSON list of objects, with the names and units of the table
/// (map.csv); what has no value is null.
std::string map_json(const MapPlan& plan);

/// Runs what is missing of the map, each cell in a process of its own. Ends early on SIGINT and
/// SIGTERM: what is there is kept, and the signal is raised again. `solver_failed` if a run crashed
/// or its plant could not be integrated; a fall is a result. `json` takes what map_json() has to
/// say at the end.
ExitStatus run_map(const MapRequest& request, std::string* json = nullptr);

/// The verb `map` for a problem with these defaults.
Verb map_verb(const ConfigurableBiped& defaults);

}  // namespace saltus::walking
