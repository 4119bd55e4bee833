// The ground of an engine as boxes.
#pragma once

#include <vector>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus::robots {

/// A slab of ground: a box whose upper face is the ground.
struct GroundBox {
  Eigen::Isometry3d pose;  ///< pose of the centre in the world
  Vec<double, 3> size;     ///< edge lengths, m
  double friction;         ///< Coulomb friction
  bool is_soft = false;    ///< true if engines must leave it out
};
/// The ground as boxes; one if it is level. Throws DefinitionError, naming the member of
/// Plant::Ground that is not finite or out of range.
std::vector<GroundBox> ground_boxes(const Plant::Options& options);

/// Height of the highest upper face at a point of the plane z = 0, m; -infinity if there is none.
double height_at(const std::vector<GroundBox>& boxes, double x, double y);

}  // namespace saltus::robots
