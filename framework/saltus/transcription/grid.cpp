#include "saltus/transcription/grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "saltus/core/error.hpp"
#include "saltus/ocp/windows_of.hpp"

namespace saltus {

Grid::Grid(const OptimalControlProblem& problem, const std::vector<Mesh>& meshes)
    : schedule_(problem.schedule()) {
  bool known_start = !problem.start_time_bounds();
  for (std::size_t j = 0; j < problem.phases().size(); ++j) {
    const PhaseDefinition& phase = problem.phases()[j];
    PhaseGrid& grid = phases_.emplace_back();
    grid.mesh = meshes[j];
    grid.mesh.check(phase.name);
    grid.is_free = phase.has_free_duration();
    grid.has_known_start = known_start;
    grid.duration = grid.is_free ? phase.duration_guess : phase.duration.lower;
    collect_instants(phase, grid);
    if (grid.is_free) place_free(grid, phase);
    known_start = known_start && !grid.is_free;
    if (!grid.is_free) {
      grid.intervals.resize(grid.mesh.intervals + grid.slots.size() + grid.cuts.size());
      grid.offsets.resize(grid.intervals.size() + 1);
      grid.event_node.resize(grid.intervals.size() + 1);
      grid.held_node.resize(grid.intervals.size() + 1);
    }
  }
  place_events(problem.schedule(), problem.start_time());
}

void Grid::collect_instants(const PhaseDefinition& phase, PhaseGrid& grid) const {
  const double T = grid.duration;
  const auto add = [&](const std::optional<Instant>& instant, Clock clock, const std::string& who) {
    if (!instant) return;
    const bool absolute = instant->is_event() || clock == Clock::absolute;
    const std::string where = fmt::format("phase '{}', {}", phase.name, who);
    if (absolute) {
      if (!grid.has_known_start || grid.is_free)
        throw DefinitionError(where +
                              ": its window refers to absolute time, but the start or the "
                              "duration of the phase is free; use phase time");
    } else {
      const double s = instant->seconds();
      if (grid.is_free && is_after_start(instant) && s >= phase.duration.lower)
        throw DefinitionError(
            fmt::format("{}: its window has a limit at {} s, but the phase may "
                        "last only {} s",
                        where, s, phase.duration.lower));
      if (!(s > same_instant) || s >= T - same_instant) return;  // the ends are nodes already
      const double nearest = nearest_base_offset(grid.mesh, T, s);
      if (!grid.is_free && std::abs(s - nearest) <= same_instant) {
        grid.marks.push_back(nearest);
        return;
      }
    }
    for (std::size_t i = 0; i < grid.slots.size(); ++i)
      if (grid.slots[i] == *instant && (instant->is_event() || grid.clocks[i] == clock)) return;
    grid.slots.push_back(*instant);
    grid.clocks.push_back(clock);
  };
  for_each_window(phase, [&](const Window& window, const auto& describe) {
    const std::string who = describe();
    if (!window.modes.empty()) {
      if (!grid.has_known_start || grid.is_free)
        throw DefinitionError(fmt::format(
            "phase '{}', {}: its window refers to the mode '{}', but the start or the duration of "
            "the phase is free; use phase time",
            phase.name, who, window.modes.front()));
      grid.has_modes = true;
    }
    add(window.from, window.clock, who);
    add(window.to, window.clock, who);
  });
  if (!grid.has_modes) return;
  grid.cuts.resize(schedule_.capacity());
  for (std::size_t i = grid.slots.size(); i-- > 0;)  // already among the cuts
    if (grid.slots[i].is_event()) {
      grid.slots.erase(grid.slots.begin() + static_cast<std::ptrdiff_t>(i));
      grid.clocks.erase(grid.clocks.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

void Grid::check_events(const OptimalControlProblem& problem, const Schedule& schedule) {
  for (const PhaseDefinition& phase : problem.phases()) {
    const auto check = [&](const Window& window, const auto& describe) {
      for (const std::optional<Instant>* instant : {&window.from, &window.to})
        if (*instant && (*instant)->is_event() && !schedule.contains((*instant)->event()))
          throw DefinitionError(
              fmt::format("phase '{}', {}: its window refers to event '{}', which is not in the "
                          "new schedule",
                          phase.name, describe(), (*instant)->event()));
    };
    for_each_window(phase, check);
  }
}

double Grid::nominal_length(int phase) const {
  return phases_[phase].duration / phases_[phase].mesh.intervals;
}

// Offset of a base node for a given duration, s.
double Grid::base_offset(const Mesh& mesh, double duration, int node) {
  return mesh.nodes.empty() ? duration * node / mesh.intervals : duration * mesh.nodes[node];
}

double Grid::nearest_base_offset(const Mesh& mesh, double duration, double offset) {
  if (mesh.nodes.empty())
    return std::round(offset * mesh.intervals / duration) * duration / mesh.intervals;
  const auto after = std::upper_bound(mesh.nodes.begin(), mesh.nodes.end(), offset / duration);
  if (after == mesh.nodes.begin()) return base_offset(mesh, duration, 0);
  const int before = static_cast<int>(after - mesh.nodes.begin()) - 1;
  const int next = std::min(before + 1, mesh.intervals);
  const double lower = base_offset(mesh, duration, before);
  const double upper = base_offset(mesh, duration, next);
  return offset - lower <= upper - offset ? lower : upper;
}

bool Grid::has_node_at(int phase, double limit, double duration) const {
  const PhaseGrid& grid = phases_[phase];
  if (limit <= same_instant || limit >= duration - same_instant) return true;
  for (std::size_t i = 0; i < grid.slots.size(); ++i)
    if (grid.slots[i] == Instant(limit) && grid.clocks[i] == Clock::phase) return true;
  return std::abs(limit - nearest_base_offset(grid.mesh, duration, limit)) <= same_instant;
}

double Grid::instant_offset(const PhaseGrid& grid, const Instant& instant, Clock clock) const {
  if (instant.is_event()) return schedule_.time_of(instant.event()) - grid.start;
  return clock == Clock::absolute ? instant.seconds() - grid.start : instant.seconds();
}

// Rounds an instant within same_instant of a base node or an end to that node.
double Grid::snap(const PhaseGrid& grid, double offset) {
  if (!std::isfinite(offset)) return offset;
  if (grid.duration > 0.0 && !grid.is_free) {
    const double node = nearest_base_offset(grid.mesh, grid.duration, offset);
    if (std::abs(offset - node) <= same_instant) return node;
  }
  return offset;
}

void Grid::place_events(const Schedule& schedule, double start_time) {
  schedule_.adopt(schedule);
  double start = start_time;
  for (PhaseGrid& grid : phases_) {
    grid.start = start;
    if (!grid.is_free) place_fixed(grid);
    start += grid.duration;
  }
}

// Inserts a node at an offset, which may lie outside the phase. Returns the actual offset.
double Grid::insert_node(PhaseGrid& grid, std::size_t& count, double at) {
  const bool inside = at >= 0.0 && at <= grid.duration;
  const double wanted = at;
  at = std::clamp(at, 0.0, grid.duration);
  // Two events closer than same_instant share a node.
  for (std::size_t i = 0; i < count; ++i)
    if (std::abs(grid.offsets[i] - at) <= same_instant) at = grid.offsets[i];
  std::size_t i = count++;
  for (; i > 0 && grid.offsets[i - 1] > at; --i) {
    grid.offsets[i] = grid.offsets[i - 1];
    grid.event_node[i] = grid.event_node[i - 1];
    grid.held_node[i] = grid.held_node[i - 1];
  }
  grid.offsets[i] = at;
  grid.event_node[i] = inside ? 1 : 0;
  grid.held_node[i] = 0;
  return inside ? at : wanted;
}

void Grid::place_fixed(PhaseGrid& grid) {
  const double T = grid.duration;
  const int n = grid.mesh.intervals;
  // Base nodes first, then events, by insertion sort: std::stable_sort would allocate.
  std::size_t count = 0;
  for (int i = 0; i <= n; ++i) {
    grid.offsets[count] = base_offset(grid.mesh, grid.duration, i);
    grid.held_node[count] = grid.mesh.holds_input(i) ? 1 : 0;
    grid.event_node[count++] = 0;
  }
  for (std::size_t s = 0; s < grid.slots.size(); ++s)
    insert_node(grid, count, snap(grid, instant_offset(grid, grid.slots[s], grid.clocks[s])));
  const std::span<const Event> events = schedule_.events();
  for (std::size_t i = 0; i < grid.cuts.size(); ++i)  // unused slots are empty intervals at the end
    grid.cuts[i] = insert_node(
        grid, count, i < events.size() ? snap(grid, events[i].time - grid.start) : infinity);
  for (const double mark : grid.marks)
    for (std::size_t i = 0; i < count; ++i)
      if (std::abs(grid.offsets[i] - mark) <= same_instant) grid.event_node[i] = 1;
  // If one node at an instant is a control break, all nodes at this instant are.
  for (std::size_t i = count - 1; i > 0; --i)
    if (grid.offsets[i] == grid.offsets[i - 1] && grid.event_node[i]) grid.event_node[i - 1] = 1;
  for (std::size_t i = 1; i < count; ++i)
    if (grid.offsets[i] == grid.offsets[i - 1] && grid.event_node[i - 1]) grid.event_node[i] = 1;
  // Gives all whole intervals of a uniform mesh exactly the same length, without the rounding of
  // their ends. Integrators that cache results per length would otherwise recompute them for each
  // interval.
  const double whole = T / n;
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * T;
  for (std::size_t k = 0; k + 1 < count; ++k) {
    const double length = grid.offsets[k + 1] - grid.offsets[k];
    grid.intervals[k] = {grid.offsets[k], 0.0,
                         std::abs(length - whole) <= rounding ? whole : length, 0.0};
  }
}

// For a free duration, segments between window limits have uniform intervals, and the last segment
// scales with T. A custom mesh scales as a whole and allows no window limit inside.
void Grid::place_free(PhaseGrid& grid, const PhaseDefinition& phase) {
  std::vector<double> limits{0.0};
  for (std::size_t s = 0; s < grid.slots.size(); ++s)
    if (std::isfinite(grid.slots[s].seconds())) limits.push_back(grid.slots[s].seconds());
  std::sort(limits.begin(), limits.end());
  if (!grid.mesh.nodes.empty()) {
    if (limits.size() > 1)
      throw DefinitionError(fmt::format(
          "phase '{}': its duration is free and a window ends inside it, at {} s: give its mesh as "
          "a number of intervals, not by nodes",
          phase.name, limits[1]));
    for (int i = 0; i < grid.mesh.intervals; ++i) {
      const double begin = grid.mesh.nodes[i];
      grid.intervals.push_back({0.0, begin, 0.0, grid.mesh.nodes[i + 1] - begin});
    }
    for (int i = 0; i <= grid.mesh.intervals; ++i) {
      grid.offsets.push_back(base_offset(grid.mesh, grid.duration, i));
      grid.event_node.push_back(0);
      grid.held_node.push_back(grid.mesh.holds_input(i) ? 1 : 0);
    }
    return;
  }
  const int base_intervals = grid.mesh.intervals;
  if (base_intervals < static_cast<int>(limits.size()))
    throw DefinitionError(
        fmt::format("phase '{}': {} window limits need at least {} intervals, "
                    "but it has {}",
                    phase.name, limits.size() - 1, limits.size(), base_intervals));
  int left = base_intervals;
  for (std::size_t s = 0; s < limits.size(); ++s) {
    const bool last = s + 1 == limits.size();
    const double begin = limits[s];
    const double part = ((last ? grid.duration : limits[s + 1]) - begin) / grid.duration;
    const int others = static_cast<int>(limits.size() - s) - 1;
    const int n =
        last ? left
             : std::clamp(static_cast<int>(std::lround(part * base_intervals)), 1, left - others);
    left -= n;
    for (int i = 0; i < n; ++i) {
      const double fraction = static_cast<double>(i) / n;
      if (last)  // from `begin` to T
        grid.intervals.push_back({begin * (1.0 - fraction), fraction, -begin / n, 1.0 / n});
      else
        grid.intervals.push_back(
            {begin + (limits[s + 1] - begin) * fraction, 0.0, (limits[s + 1] - begin) / n, 0.0});
      grid.offsets.push_back(grid.intervals.back().offset(grid.duration));
      grid.event_node.push_back(i == 0 && s > 0 ? 1 : 0);
    }
  }
  grid.offsets.push_back(grid.duration);
  grid.event_node.push_back(0);
  grid.held_node.clear();
  for (std::size_t i = 0; i < grid.offsets.size(); ++i)
    grid.held_node.push_back(grid.mesh.holds_input(static_cast<int>(i)) ? 1 : 0);
}

Grid::PhaseWindow Grid::resolve(int phase, const Window& window) const {
  const PhaseGrid& grid = phases_[phase];
  Grid::PhaseWindow result{0.0, infinity};
  // Not before the phase: a window that ends where the phase begins does not contain any of it.
  if (window.from)
    result.from = std::max(0.0, snap(grid, instant_offset(grid, *window.from, window.clock)));
  if (window.to) result.to = snap(grid, instant_offset(grid, *window.to, window.clock));
  result.modes = schedule_.mask_of(window.modes);
  return result;
}

double Grid::node_offset(int phase, int node) const { return phases_[phase].offsets[node]; }

// True if `visit` holds for one of the intervals [from, to) of the window.
template <class Visit>
bool Grid::any_span(const PhaseGrid& grid, const Grid::PhaseWindow& window, Visit&& visit) const {
  if (window.modes == 0) return visit(window.from, window.to);
  const int last = static_cast<int>(schedule_.events().size());
  for (int i = 0; i <= last; ++i) {
    if (!(window.modes >> schedule_.number_of_mode(i) & 1)) continue;
    const double from = std::max(window.from, i > 0 ? grid.cuts[i - 1] : -infinity);
    const double to = std::min(window.to, i < last ? grid.cuts[i] : infinity);
    // Limits of a mode and of the window at the same node may differ by less than same_instant.
    if (to - from > same_instant && visit(from, to)) return true;
  }
  return false;
}

bool Grid::interval_in(int phase, int k, const Grid::PhaseWindow& window) const {
  const PhaseGrid& grid = phases_[phase];
  if (grid.intervals[k].is_empty()) return false;
  constexpr double slack = 0.999 * same_instant;  // distinct nodes are farther apart
  return any_span(grid, window, [&](double from, double to) {
    return grid.offsets[k] >= from - slack && grid.offsets[k + 1] <= to + slack;
  });
}

bool Grid::node_in(int phase, int node, const Grid::PhaseWindow& window) const {
  const PhaseGrid& grid = phases_[phase];
  const bool superseded =
      node + 1 < static_cast<int>(grid.offsets.size()) && grid.intervals[node].is_empty();
  if (superseded) return false;
  constexpr double slack = 0.999 * same_instant;
  return any_span(grid, window, [&](double from, double to) {
    return from < to && grid.offsets[node] >= from - slack && grid.offsets[node] <= to + slack;
  });
}

}  // namespace saltus
