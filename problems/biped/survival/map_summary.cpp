// Summary of a survival map as text.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "problems/biped/survival/map.hpp"

namespace saltus::robots::walking {
namespace {

struct Column {
  MapController controller;
  double step_time;
  std::string title, bound_title;
};

// Results of a column in one direction.
struct Ray {
  double largest = 0.0;  // all pushes up to this one were recovered, N s
  double bound = 0.0;    // the pendulum's bound, N s; 0: unknown
  bool is_beyond = false, is_complete = true;
  bool is_open = false;  // the grid contains no larger impulse
};

Ray ray_of(const MapPlan& plan, const Column& column, double direction) {
  Ray ray;
  bool is_unbroken = true;
  for (const double impulse : plan.grid().impulses) {
    const auto found = plan.rows().find({column.controller, column.step_time, direction, impulse});
    if (found == plan.rows().end()) {
      ray.is_complete = !is_unbroken;
      break;
    }
    ray.bound = found->second.bound;
    const bool is_recovered = found->second.outcome == MapOutcome::recovered;
    is_unbroken = is_unbroken && is_recovered;
    if (is_unbroken) ray.largest = impulse;
    ray.is_beyond = ray.is_beyond || (is_recovered && !is_unbroken);
  }
  ray.is_open = ray.largest == plan.grid().impulses.back();
  return ray;
}

std::vector<Column> columns_of(const MapGrid& grid) {
  const auto has = [&](MapController c) {
    return std::find(grid.controllers.begin(), grid.controllers.end(), c) != grid.controllers.end();
  };
  const std::vector<double> times =
      grid.step_times.empty() ? std::vector<double>{0.0} : grid.step_times;
  std::vector<Column> columns;
  for (const double t : times) {
    const std::string when = t > 0.0 ? fmt::format(" {} s", t) : "";
    for (const MapController c : {MapController::mpc, MapController::capture_point})
      if (has(c)) columns.push_back({c, t, name_of(c) + when, ""});
    if (!columns.empty()) columns.back().bound_title = "bound" + when;
  }
  if (has(MapController::none)) columns.push_back({MapController::none, 0.0, "none", "bound none"});
  return columns;
}

// Area of the polygon whose corners have these radii at equally spaced angles.
double area(const std::vector<double>& radii) {
  double products = 0.0;
  for (std::size_t i = 0; i < radii.size(); ++i)
    products += radii[i] * radii[(i + 1) % radii.size()];
  return 0.5 * std::sin(2.0 * std::numbers::pi / static_cast<double>(radii.size())) * products;
}

std::string line(const std::vector<std::string>& cells) {
  return fmt::format("| {} |\n", fmt::join(cells, " | "));
}

std::string head(const std::vector<std::string>& titles) {
  return line(titles) + line(std::vector<std::string>(titles.size(), "---"));
}

std::string largest_text(const Ray& ray, double smallest) {
  const char* star = ray.is_beyond ? "*" : "";
  if (ray.largest > 0.0)
    return fmt::format("{}{}{}", ray.is_complete ? "" : ">= ", ray.largest, star);
  return ray.is_complete ? fmt::format("below {}{}", smallest, star) : "?";
}

// Shares of the sector per direction, and of the whole polygon.
std::string shares(const std::vector<Column>& columns, const std::vector<double>& directions,
                   const std::vector<std::vector<Ray>>& rays) {
  std::vector<std::string> titles{"direction"};
  for (const Column& column : columns) titles.push_back(column.title);
  std::string text = "\nFraction of the bound's area that was reached\n\n" + head(titles);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    std::vector<std::string> cells{fmt::format("{} deg", directions[i])};
    for (const Ray& ray : rays[i])
      cells.push_back(ray.is_complete && ray.bound > 0.0
                          ? fmt::format("{}{:.0f} %", ray.is_open ? ">= " : "",
                                        100.0 * std::pow(ray.largest / ray.bound, 2))
                          : "?");
    text += line(cells);
  }
  constexpr std::size_t fewest = 3;  // smallest number of directions with an area
  if (directions.size() < fewest) return text;
  std::vector<std::string> cells{"all, (N s)^2"};
  for (std::size_t j = 0; j < columns.size(); ++j) {
    std::vector<double> reached, possible;
    bool is_known = true, is_open = false;
    for (const std::vector<Ray>& of_direction : rays) {
      const Ray& ray = of_direction[j];
      is_known = is_known && ray.is_complete && ray.bound > 0.0;
      is_open = is_open || ray.is_open;
      reached.push_back(ray.largest);
      possible.push_back(ray.bound);
    }
    cells.push_back(is_known
                        ? fmt::format("{:.0f} of {:.0f}: {}{:.0f} %", area(reached), area(possible),
                                      is_open ? ">= " : "", 100.0 * area(reached) / area(possible))
                        : "?");
  }
  return text + line(cells);
}

}  // namespace

std::string map_summary(const MapPlan& plan) {
  const MapGrid& grid = plan.grid();
  std::vector<double> directions = grid.directions;
  std::sort(directions.begin(), directions.end());
  const std::vector<Column> columns = columns_of(grid);
  const double smallest = *std::min_element(grid.impulses.begin(), grid.impulses.end());
  std::vector<std::string> titles{"direction"};
  for (const Column& column : columns) {
    titles.push_back(column.title);
    if (!column.bound_title.empty()) titles.push_back(column.bound_title);
  }
  std::string text =
      "Largest push (N s) up to which all were recovered; * *: also some larger ones\n\n" +
      head(titles);
  std::vector<std::vector<Ray>> rays;
  for (const double direction : directions) {
    std::vector<std::string> cells{fmt::format("{} deg", direction)};
    std::vector<Ray>& of_direction = rays.emplace_back();
    for (const Column& column : columns) {
      const Ray ray = ray_of(plan, column, direction);
      of_direction.push_back(ray);
      cells.push_back(largest_text(ray, smallest));
      if (!column.bound_title.empty())
        cells.push_back(ray.bound > 0.0 ? fmt::format("{:.1f}", ray.bound) : "?");
    }
    text += line(cells);
  }
  return text + shares(columns, directions, rays);
}

}  // namespace saltus::robots::walking
