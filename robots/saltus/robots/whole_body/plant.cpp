#include "saltus/robots/whole_body/ground.hpp"

#include <fmt/format.h>

#include <cmath>

#include "saltus/core/error.hpp"

namespace saltus::robots {
namespace {

constexpr double ground_size = 2000.0, ground_depth = 0.2;  // m: enough for an hour of walking

}  // namespace

std::vector<GroundBox> ground_boxes(const Plant::Options& options) {
  const double step = options.ground_step, edge = options.ground_edge;
  const double depth = ground_depth, half = 0.5 * ground_size;
  if (step == 0.0) return {{{0.0, 0.0, -0.5 * depth}, {ground_size, ground_size, depth}}};
  if (!std::isfinite(step) || !(std::abs(edge) > 0.0 && std::abs(edge) < half))
    throw DefinitionError(
        fmt::format("a ground step of {} m at y = {} m: expected finite numbers, and an edge that "
                    "is not at 0 m and lies within {} m",
                    step, edge, half));
  const double side = edge > 0.0 ? 1.0 : -1.0;
  const double near = half + std::abs(edge), far = half - std::abs(edge);  // extents along y
  return {{{0.0, edge - side * 0.5 * near, -0.5 * depth}, {ground_size, near, depth}},
          {{0.0, edge + side * 0.5 * far, step - 0.5 * depth}, {ground_size, far, depth}}};
}

}  // namespace saltus::robots
