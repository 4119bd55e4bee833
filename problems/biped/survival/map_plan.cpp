#include "problems/biped/survival/map_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace saltus::robots::walking {

std::vector<double> directions_far_apart(int n) {
  // Multiples of the angle with the most factors of two come first. Opposite directions are
  // adjacent.
  std::vector<int> order;
  for (int stride = n; stride >= 1; stride = stride == 1 ? 0 : std::max(1, stride / 2)) {
    std::vector<int> fresh;
    for (int i = 0; i < n; i += stride)
      if (std::find(order.begin(), order.end(), i) == order.end()) fresh.push_back(i);
    const auto opposite_first = [n](int a, int b) {
      return std::pair(a % ((n + 1) / 2), a) < std::pair(b % ((n + 1) / 2), b);
    };
    std::sort(fresh.begin(), fresh.end(), opposite_first);
    order.insert(order.end(), fresh.begin(), fresh.end());
  }
  std::vector<double> degrees;
  for (const int i : order) degrees.push_back(360.0 * i / n);
  return degrees;
}

MapPlan::MapPlan(MapGrid grid, std::function<double(const MapCell&)> bound)
    : grid_(std::move(grid)), bound_(std::move(bound)) {
  for (const double direction : grid_.directions)
    for (const MapController controller : grid_.controllers) {
      if (controller == MapController::none || grid_.step_times.empty()) {
        rays_.push_back({{controller, 0.0, direction, 0.0}});
        continue;
      }
      for (const double step_time : grid_.step_times)
        rays_.push_back({{controller, step_time, direction, 0.0}});
    }
  for (const Ray& ray : rays_)
    for (const double impulse : grid_.impulses) cells_of_grid_.insert(cell_of(ray, impulse));
  cells_ = static_cast<int>(cells_of_grid_.size());
}

MapCell MapPlan::cell_of(const Ray& ray, double impulse) {
  MapCell cell = ray.first;
  cell.impulse = impulse;
  return cell;
}

bool MapPlan::belongs(const MapCell& cell) const { return cells_of_grid_.contains(cell); }

bool MapPlan::is_under_way(const Ray& ray) const {
  return std::any_of(grid_.impulses.begin(), grid_.impulses.end(),
                     [&](double impulse) { return under_way_.contains(cell_of(ray, impulse)); });
}

void MapPlan::restore(const MapRow& row) {
  const bool is_result =
      row.outcome == MapOutcome::recovered || row.outcome == MapOutcome::not_recovered;
  if (is_result && belongs(row.cell)) known_[row.cell] = row;
}

std::vector<MapRow> MapPlan::resume() {
  std::vector<MapRow> kept;
  const std::map<MapCell, MapRow> restored = known_;
  for (const auto& [cell, row] : restored) spread(row, kept);
  give_up_where_hopeless(kept);
  return kept;
}

std::optional<MapCell> MapPlan::next() {
  for (const Ray& ray : rays_) {
    // One cell of a ray at a time, in ascending order: smaller pushes decide whether it is skipped.
    if (ray.given_up || (!grid_.all && is_under_way(ray))) continue;
    for (const double impulse : grid_.impulses) {
      const MapCell cell = cell_of(ray, impulse);
      if (known_.contains(cell) || under_way_.contains(cell)) continue;
      under_way_.insert(cell);
      return cell;
    }
  }
  return std::nullopt;
}

std::vector<MapRow> MapPlan::finish(const MapRow& row) {
  under_way_.erase(row.cell);
  std::vector<MapRow> kept;
  keep(row, kept);
  spread(row, kept);
  give_up_where_hopeless(kept);
  return kept;
}

void MapPlan::keep(const MapRow& row, std::vector<MapRow>& kept) {
  known_[row.cell] = row;
  kept.push_back(row);
}

void MapPlan::spread(const MapRow& row, std::vector<MapRow>& kept) {
  const bool is_result =
      row.outcome == MapOutcome::recovered || row.outcome == MapOutcome::not_recovered;
  if (row.stepped || row.cell.controller == MapController::none || !is_result) return;
  for (const double step_time : grid_.step_times) {
    MapRow copy = row;
    copy.cell.step_time = step_time;
    if (!belongs(copy.cell) || known_.contains(copy.cell) || under_way_.contains(copy.cell))
      continue;
    copy.bound = bound_(copy.cell);
    copy.seconds = 0.0;
    if (copy.known_from.empty()) copy.known_from = fmt::format("step {}", row.cell.step_time);
    keep(copy, kept);
  }
}

void MapPlan::give_up_where_hopeless(std::vector<MapRow>& kept) {
  if (grid_.all) return;
  for (Ray& ray : rays_) {
    int failures = 0;
    for (const double impulse : grid_.impulses) {
      const MapCell cell = cell_of(ray, impulse);
      const auto found = known_.find(cell);
      if (ray.given_up) {
        if (found != known_.end() || under_way_.contains(cell)) continue;
        MapRow row;
        row.cell = cell;
        row.outcome = MapOutcome::not_run;
        row.bound = bound_(cell);
        row.reason = fmt::format("{} smaller pushes in a row failed beyond the pendulum's bound",
                                 failures_that_give_up);
        keep(row, kept);
        continue;
      }
      if (found == known_.end()) break;
      const bool hopeless =
          found->second.outcome == MapOutcome::not_recovered && cell.impulse > bound_(cell);
      failures = hopeless ? failures + 1 : 0;
      if (failures == failures_that_give_up) ray.given_up = true;
    }
  }
}

std::optional<double> MapPlan::seconds_left(int jobs) const {
  struct Mean {
    double seconds = 0.0;
    int cells = 0;
  };
  std::map<std::pair<MapController, double>, Mean> similar;
  Mean any;
  for (const auto& [cell, row] : known_)
    for (Mean* mean : {&any, &similar[{cell.controller, cell.impulse}]}) {
      mean->seconds += row.seconds;
      ++mean->cells;
    }
  if (!(any.seconds > 0.0)) return std::nullopt;
  double left = 0.0;
  for (const MapCell& cell : cells_of_grid_) {
    if (known_.contains(cell)) continue;
    const auto found = similar.find({cell.controller, cell.impulse});
    const Mean& mean = found == similar.end() ? any : found->second;
    left += mean.seconds / mean.cells;
  }
  return left / jobs;
}

}  // namespace saltus::robots::walking
