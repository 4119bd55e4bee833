#include "problems/biped/survival/map_cells.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/robots/walking/body_verdict.hpp"

namespace saltus::robots::walking {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::array controller_names{"mpc", "capture_point", "none"};
constexpr std::array outcome_names{"recovered", "not_recovered", "failed", "not_run"};

template <class Enum, std::size_t n>
std::optional<Enum> find_name(const std::array<const char*, n>& names, std::string_view name) {
  for (std::size_t i = 0; i < n; ++i)
    if (names[i] == name) return static_cast<Enum>(i);
  return std::nullopt;
}

// Unit vector. Exact on the axes, so that a sideways push has no forward component.
Vec<double, 3> unit_vector(double degrees) {
  const double quarter = degrees / 90.0;
  if (quarter == std::round(quarter)) {
    constexpr double turn[4] = {1.0, 0.0, -1.0, 0.0};
    const int i = ((static_cast<int>(quarter) % 4) + 4) % 4;
    return {turn[i], turn[(i + 3) % 4], 0.0};
  }
  const double angle = degrees * std::numbers::pi / 180.0;
  return {std::cos(angle), std::sin(angle), 0.0};
}

std::string text(double value) { return std::isnan(value) ? "" : fmt::format("{}", value); }

std::string one_field(std::string words) {
  for (char& c : words) {
    if (c == ',') c = ';';
    if (c == '"') c = '\'';
    if (c == '\n' || c == '\r') c = ' ';
  }
  return words;
}

bool read(std::string_view field, double& value) {
  if (field.empty()) {
    value = unknown;
    return true;
  }
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size();
}

bool read(std::string_view field, int& value) {
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size();
}

constexpr std::array columns{"controller",
                             "step_time_s",
                             "direction_deg",
                             "impulse_ns",
                             "outcome",
                             "bound_ns",
                             "reason",
                             "angular_momentum_max_nms",
                             "com_height_min_m",
                             "com_height_max_m",
                             "icp_settling_s",
                             "icp_furthest_m",
                             "touchdown_after_push_s",
                             "final_com_error_m",
                             "stepped",
                             "failed_solves",
                             "seconds",
                             "known_from"};

}  // namespace

std::string name_of(MapController controller) {
  return controller_names[static_cast<std::size_t>(controller)];
}

std::string name_of(MapOutcome outcome) { return outcome_names[static_cast<std::size_t>(outcome)]; }

MapController map_controller(const std::string& name) {
  if (const auto found = find_name<MapController>(controller_names, name)) return *found;
  const std::vector<std::string> known(controller_names.begin(), controller_names.end());
  const std::string meant = nearest_name(name, known);
  throw InputError(
      fmt::format("--controllers: '{}' is not a controller; {}", shortened(name),
                  meant.empty() ? "use " + join_names(known) : "did you mean '" + meant + "'?"));
}

BipedSettings with_cell(BipedSettings settings, const MapCell& cell) {
  settings.controller = cell.controller == MapController::capture_point
                            ? BipedSettings::Controller::capture_point
                            : BipedSettings::Controller::mpc;
  settings.step.allowed = cell.controller != MapController::none;
  if (settings.step.allowed && cell.step_time > 0.0) settings.step.duration = cell.step_time;
  settings.push.impulse = cell.impulse;
  settings.push.direction = unit_vector(cell.direction);
  return settings;
}

MapRow::MapRow()
    : bound(unknown),
      angular_momentum_max(unknown),
      com_height_min(unknown),
      com_height_max(unknown),
      icp_settling(unknown),
      icp_furthest(unknown),
      touchdown(unknown),
      final_com_error(unknown) {}

MapRow map_row(const MapCell& cell, double bound, const Push& push, const RunLog& log,
               const Verdict& verdict) {
  MapRow row;
  row.cell = cell;
  row.bound = bound;
  row.outcome = log.numerical_failure || log.control_failed() ? MapOutcome::failed
                : verdict.recovered                           ? MapOutcome::recovered
                                                              : MapOutcome::not_recovered;
  row.reason = verdict.reason;
  // Without a step, a hop does not count as a recovery. Bending the body does if the base ends
  // upright.
  if (cell.controller == MapController::none && verdict.recovered && verdict.body &&
      (verdict.body->feet_moved >= standing_move || verdict.body->tilt_end >= standing_tilt)) {
    row.outcome = MapOutcome::not_recovered;
    row.reason = "the feet moved or the base stayed tilted";
  }
  row.angular_momentum_max = verdict.angular_momentum_max;
  row.com_height_min = verdict.com_height_min;
  row.com_height_max = verdict.com_height_max;
  if (std::isfinite(verdict.icp_settling)) row.icp_settling = verdict.icp_settling;
  row.final_com_error = verdict.final_com_error;
  if (std::isfinite(log.touchdown)) row.touchdown = log.touchdown - push.start;
  const Vec<double, 2> along = push.direction.normalized().head<2>();
  for (const BipedSample& s : log.samples) {
    const double distance = along.dot(s.capture_point);
    if (!(distance <= row.icp_furthest)) row.icp_furthest = distance;  // first: NaN
  }
  row.stepped = !log.steps.empty();
  row.failed_solves = static_cast<int>(
      std::count_if(log.ticks.begin(), log.ticks.end(), [](const LoopLog::Tick& t) {
        return t.status != SolveStatus::time_limit && !is_success(t.status);
      }));
  return row;
}

std::string map_header() { return fmt::format("{}", fmt::join(columns, ",")); }

std::vector<std::pair<std::string, std::string>> named_fields(const MapRow& r) {
  const std::array<std::string, columns.size()> fields{name_of(r.cell.controller),
                                                       text(r.cell.step_time),
                                                       text(r.cell.direction),
                                                       text(r.cell.impulse),
                                                       name_of(r.outcome),
                                                       text(r.bound),
                                                       one_field(r.reason),
                                                       text(r.angular_momentum_max),
                                                       text(r.com_height_min),
                                                       text(r.com_height_max),
                                                       text(r.icp_settling),
                                                       text(r.icp_furthest),
                                                       text(r.touchdown),
                                                       text(r.final_com_error),
                                                       r.stepped ? "1" : "0",
                                                       std::to_string(r.failed_solves),
                                                       fmt::format("{:.3f}", r.seconds),
                                                       one_field(r.known_from)};
  std::vector<std::pair<std::string, std::string>> named;
  for (std::size_t i = 0; i < columns.size(); ++i) named.emplace_back(columns[i], fields[i]);
  return named;
}

std::string to_line(const MapRow& r) {
  std::vector<std::string> fields;
  for (auto& [column, field] : named_fields(r)) fields.push_back(std::move(field));
  return fmt::format("{}", fmt::join(fields, ","));
}

std::optional<MapRow> from_line(std::string_view line) {
  std::array<std::string_view, columns.size()> fields;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::size_t comma = line.find(',');
    if ((comma == std::string_view::npos) != (i + 1 == fields.size())) return std::nullopt;
    fields[i] = line.substr(0, comma);
    line.remove_prefix(std::min(line.size(), fields[i].size() + 1));
  }
  MapRow r;
  const auto controller = find_name<MapController>(controller_names, fields[0]);
  const auto outcome = find_name<MapOutcome>(outcome_names, fields[4]);
  int stepped = 0;
  const bool readable = controller && outcome && read(fields[1], r.cell.step_time) &&
                        read(fields[2], r.cell.direction) && read(fields[3], r.cell.impulse) &&
                        read(fields[5], r.bound) && read(fields[7], r.angular_momentum_max) &&
                        read(fields[8], r.com_height_min) && read(fields[9], r.com_height_max) &&
                        read(fields[10], r.icp_settling) && read(fields[11], r.icp_furthest) &&
                        read(fields[12], r.touchdown) && read(fields[13], r.final_com_error) &&
                        read(fields[14], stepped) && read(fields[15], r.failed_solves) &&
                        read(fields[16], r.seconds);
  if (!readable) return std::nullopt;
  r.cell.controller = *controller;
  r.outcome = *outcome;
  r.reason = fields[6];
  r.stepped = stepped != 0;
  r.known_from = fields[17];
  return r;
}

}  // namespace saltus::robots::walking
