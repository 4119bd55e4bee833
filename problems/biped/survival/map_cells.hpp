// Cells of a survival map: pushes, their outcomes, and their lines in a CSV file.
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "saltus/robots/walking/biped_problem.hpp"
#include "saltus/robots/walking/biped_settings.hpp"

namespace saltus::robots::walking {

enum class MapController { mpc, capture_point, none };  ///< none: MPC without steps
/// Outcome of a cell.
enum class MapOutcome {
  recovered,
  not_recovered,
  failed,   ///< the run crashed, or the plant could not be integrated
  not_run,  ///< skipped: smaller pushes of this ray failed, see `MapPlan`
};

/// Name in tables and command lines.
std::string name_of(MapController controller);
/// Name in tables.
std::string name_of(MapOutcome outcome);
/// The controller of this name. Otherwise throws InputError that suggests the nearest name.
MapController map_controller(const std::string& name);

/// One push. Cells compare by exact value; the same arithmetic always reproduces it.
struct MapCell {
  MapController controller = MapController::mpc;  ///< controller of the robot
  double step_time = 0.0;  ///< s; 0 without a step, or if the step planner chooses the time
  double direction = 0.0;  ///< deg, counter-clockwise seen from above; 0 is forward, 90 left
  double impulse = 0.0;    ///< N s

  auto operator<=>(const MapCell&) const = default;
};

/// The settings of the run of a cell.
BipedSettings with_cell(BipedSettings settings, const MapCell& cell);

/// Results of a cell. Quantities without a value are NaN, and empty in the CSV.
struct MapRow {
  MapCell cell;                              ///< push and controller
  MapOutcome outcome = MapOutcome::not_run;  ///< outcome of the run
  double bound;                              ///< the plain pendulum's bound, N s
  std::string reason;                        ///< why the push was not recovered
  double angular_momentum_max;               ///< Nms
  double com_height_min, com_height_max;     ///< m
  double icp_settling;                       ///< s
  double icp_furthest;     ///< m, largest distance of the capture point along the push
  double touchdown;        ///< s after the push began
  double final_com_error;  ///< m
  bool stepped = false;    ///< a step was triggered
  int failed_solves = 0;   ///< control periods in which the solver failed
  double seconds = 0.0;    ///< wall clock, s
  std::string known_from;  ///< "step 0.6": copied from that cell, because no step began there

  MapRow();
};

/// Results of a run; `push` is the push of the cell.
MapRow map_row(const MapCell& cell, double bound, const Push& push, const RunLog& log,
               const Verdict& verdict);

/// Column and field of a row, in the order of the table. Commas and quotes in the reason become
/// semicolons and apostrophes.
std::vector<std::pair<std::string, std::string>> named_fields(const MapRow& row);
/// Names of the columns, without a line break.
std::string map_header();
/// Fields of the row as one line, without a line break; numbers are written exactly.
std::string to_line(const MapRow& row);
/// Reads a line; empty if it is not a valid row.
std::optional<MapRow> from_line(std::string_view line);

}  // namespace saltus::robots::walking
