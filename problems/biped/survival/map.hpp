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

namespace saltus::robots::walking {

/// Options of a survival map.
struct MapRequest {
  std::shared_ptr<ConfigurableBiped> problem;  ///< problem that is pushed
  std::string settings;                        ///< all settings except those of the cell, as YAML
  MapGrid grid;                                ///< pushes, step times and controllers
  std::filesystem::path out;                   ///< folder for table and picture
  int jobs = 1;                                ///< number of parallel runs
  bool pictures = true;                        ///< draw the picture at the end
  bool quiet = false;                          ///< print nothing but errors
  bool json = false;                           ///< print the cells as JSON instead of text
  std::string help = {};                       ///< not empty: print this help instead of a map
};

/// Parses the arguments of `map`, for a problem with these defaults. Throws InputError.
MapRequest parse_map_request(const ConfigurableBiped& defaults,
                             std::span<const std::string> arguments);

/// Markdown table, one row per direction: the largest impulse (N s) up to which every push was
/// recovered, by controller and step time, and the pendulum's bound. A star marks recoveries above
/// it. A second table gives the recovered share of the area within the bound.
std::string map_summary(const MapPlan& plan);

/// The known cells as a JSON list of objects, with the names and units of the columns of map.csv.
/// Missing values are null.
std::string map_json(const MapPlan& plan);

/// Runs the missing cells of the map, each in a separate process. SIGINT and SIGTERM end it early:
/// it keeps the finished cells and raises the signal again. Returns `solver_failed` if a run
/// crashed or its plant could not be integrated; a fall is a result. `json` receives map_json() at
/// the end.
ExitStatus run_map(const MapRequest& request, std::string* json = nullptr);

/// The verb `map` for a problem with these defaults.
Verb map_verb(const ConfigurableBiped& defaults);

}  // namespace saltus::robots::walking
