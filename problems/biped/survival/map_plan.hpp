// Order of the runs of a survival map, and the cells that need no run.
//
// A ray is a controller, a step time and a direction. Its cells are the impulses, ascending.
// Rays far apart come first, so that a map that is stopped early is a coarse map. Survival is not
// monotone in the impulse, so every cell is run, with two exceptions:
//  - if no step was triggered, the result holds for all other step times;
//  - after three consecutive failures above the pendulum's bound, the rest of the ray is skipped.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "problems/biped/survival/map_cells.hpp"

namespace saltus::robots::walking {

/// After this number of consecutive failures above the pendulum's bound, larger pushes are
/// skipped.
inline constexpr int failures_that_give_up = 3;

/// Pushes, directions, step times and controllers of a map.
struct MapGrid {
  std::vector<double> directions;          ///< deg
  std::vector<double> impulses;            ///< N s, ascending
  std::vector<double> step_times;          ///< s; empty: the step planner decides
  std::vector<MapController> controllers;  ///< in the order of the table
  bool all = false;                        ///< skip nothing
};

/// n equally spaced directions (deg) that start with forward, in the order of the runs: opposite
/// directions first, then those half-way between.
std::vector<double> directions_far_apart(int n);

/// Order of the runs. It is deterministic: skipped cells do not depend on the number of parallel
/// runs.
class MapPlan {
 public:
  /// `bound` returns the pendulum's bound for a cell, N s.
  MapPlan(MapGrid grid, std::function<double(const MapCell&)> bound);

  /// Adds a cell of an earlier map in the same folder. Failed and skipped cells do not count as
  /// known.
  void restore(const MapRow& row);
  /// Call after all restore() calls. Returns the cells that follow from the restored ones (see
  /// finish).
  std::vector<MapRow> resume();

  /// The next cell to run, now marked as running. None if all remaining cells must wait.
  std::optional<MapCell> next();

  /// Records the result of a cell; returns the rows to keep: this one and those that follow from
  /// it.
  std::vector<MapRow> finish(const MapRow& row);

  /// Number of cells.
  int cells() const { return cells_; }
  /// Number of cells with an outcome.
  int known() const { return static_cast<int>(known_.size()); }
  /// True if no cell is left to run.
  bool is_complete() const { return known() == cells_; }

  /// Estimated wall-clock time left, s: from the mean over finished cells of the same impulse and
  /// controller, where cells without a run count as zero. None before the first cell has ended.
  std::optional<double> seconds_left(int jobs) const;

  /// Known rows of the grid, by cell.
  const std::map<MapCell, MapRow>& rows() const { return known_; }
  /// Grid of the map.
  const MapGrid& grid() const { return grid_; }

 private:
  struct Ray {
    MapCell first;  // cell with impulse zero
    bool given_up = false;
  };
  static MapCell cell_of(const Ray& ray, double impulse);
  bool belongs(const MapCell& cell) const;
  bool is_under_way(const Ray& ray) const;
  void keep(const MapRow& row, std::vector<MapRow>& kept);
  void spread(const MapRow& row, std::vector<MapRow>& kept);
  void give_up_where_hopeless(std::vector<MapRow>& kept);

  MapGrid grid_;
  std::function<double(const MapCell&)> bound_;
  std::vector<Ray> rays_;
  std::map<MapCell, MapRow> known_;
  std::set<MapCell> cells_of_grid_, under_way_;
  int cells_ = 0;
};

}  // namespace saltus::robots::walking
