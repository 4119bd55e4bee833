// The level ground of an engine, with at most one step in it.
#pragma once

#include <vector>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus::robots {

/// A slab of ground: a box whose upper face is the ground.
struct GroundBox {
  Vec<double, 3> centre, size;  ///< m
};
/// The ground as boxes: one, or two with a step. Throws DefinitionError if the parameters of the
/// step are not finite, or the edge is at the origin.
std::vector<GroundBox> ground_boxes(const Plant::Options& options);

}  // namespace saltus::robots
