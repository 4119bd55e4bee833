#include "saltus/transcription/grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"

namespace saltus {

double Mesh::fraction(int node) const {
  return nodes.empty() ? static_cast<double>(node) / intervals : nodes[node];
}

std::vector<Mesh::InputInterval> Mesh::input_intervals() const {
  std::vector<InputInterval> result;
  for (int k = 0; k < intervals; ++k)
    if (k > 0 && holds_input(k))
      ++result.back().count;
    else
      result.push_back({k, 1});
  return result;
}

Mesh Mesh::divided(const std::vector<Cut>& cuts) const {
  Mesh result{0, {}, {}};
  bool holds_any = false;
  const std::vector<InputInterval> parts = input_intervals();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double begin = fraction(parts[i].first);
    const double length = fraction(parts[i].first + parts[i].count) - begin;
    for (int k = 0; k < cuts[i].pieces; ++k) {
      result.nodes.push_back(begin + length * k / cuts[i].pieces);
      result.holds.push_back(k > 0 && cuts[i].holds ? 1 : 0);
      holds_any = holds_any || result.holds.back() != 0;
    }
  }
  result.nodes.push_back(1.0);
  result.holds.push_back(0);
  if (!holds_any) result.holds.clear();
  result.intervals = static_cast<int>(result.nodes.size()) - 1;
  return result;
}

namespace {

Mesh mesh_of(const std::vector<double>& lengths) {
  Mesh mesh{static_cast<int>(lengths.size()), {0.0}, {}};
  double sum = 0.0, so_far = 0.0;
  for (const double length : lengths) sum += length;
  for (const double length : lengths) mesh.nodes.push_back((so_far += length) / sum);
  mesh.nodes.back() = 1.0;
  return mesh;
}

void check_grading(int intervals, double ratio) {
  if (intervals < 1 || intervals > Mesh::most_intervals)
    throw DefinitionError(fmt::format("a graded mesh of {} intervals, expected 1 to {}", intervals,
                                      Mesh::most_intervals));
  if (!(ratio > 0.0) || !std::isfinite(ratio))
    throw DefinitionError(
        fmt::format("a graded mesh with the length ratio {}, expected a positive number", ratio));
}

}  // namespace

Mesh graded_mesh(int intervals, double ratio) {
  check_grading(intervals, ratio);
  std::vector<double> lengths;
  for (int k = 0; k < intervals; ++k)
    lengths.push_back(intervals == 1 ? 1.0 : std::pow(ratio, k / (intervals - 1.0)));
  return mesh_of(lengths);
}

Mesh mesh_graded_to_both_ends(int intervals, double ratio) {
  check_grading(intervals, ratio);
  std::vector<double> lengths;
  const int steps = (intervals - 1) / 2;  // number of steps from an end to the middle
  for (int k = 0; k < intervals; ++k)
    lengths.push_back(
        steps == 0 ? 1.0
                   : std::pow(ratio, std::min(k, intervals - 1 - k) / static_cast<double>(steps)));
  return mesh_of(lengths);
}

void Mesh::check(const std::string& phase) const {
  if (intervals < 1 || intervals > most_intervals)
    throw DefinitionError(fmt::format("phase '{}': it has {} intervals, expected 1 to {}", phase,
                                      intervals, most_intervals));
  const auto expected = static_cast<std::size_t>(intervals) + 1;
  if (!holds.empty() && holds.size() != expected)
    throw DefinitionError(fmt::format("phase '{}': its mesh has {} hold flags, but {} nodes", phase,
                                      holds.size(), expected));
  if (nodes.empty()) return;
  if (nodes.size() != expected)
    throw DefinitionError(
        fmt::format("phase '{}': its mesh has {} nodes for {} intervals, expected {}", phase,
                    nodes.size(), intervals, expected));
  if (nodes.front() != 0.0 || nodes.back() != 1.0)
    throw DefinitionError(
        fmt::format("phase '{}': the nodes of its mesh go from {} to {}, expected from 0 to 1",
                    phase, nodes.front(), nodes.back()));
  for (int k = 0; k < intervals; ++k)
    if (!(nodes[k + 1] > nodes[k]))
      throw DefinitionError(
          fmt::format("phase '{}': node {} of its mesh is at {} and node {} at {}, expected "
                      "increasing fractions",
                      phase, k, nodes[k], k + 1, nodes[k + 1]));
}

}  // namespace saltus
