// Corner points of the shapes that a URDF assigns to its links.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus::robots {

/// Finds the file for package://NAME/REST, model://NAME/REST, file://PATH or a path in a URDF.
/// Packages are searched in the folders around the URDF (not at the top of the file system), then
/// in those of ROS_PACKAGE_PATH, GAZEBO_MODEL_PATH and AMENT_PREFIX_PATH. Paths must lie in the
/// folder of the URDF, in one of the two folders above it, or in one that these variables name. No
/// name may lead out of its package, so a URDF from an unknown source cannot open other files.
/// Returns nothing if there is no such file.
std::optional<std::filesystem::path> find_mesh(const std::string& reference,
                                               const std::filesystem::path& urdf);

/// Corners of all triangles of a mesh (STL, Collada or OBJ, by its extension), without duplicates,
/// in the axes of the file. The unit is m if the file names none. Files that the mesh refers to are
/// not opened. Throws InputError, one sentence naming the file, if it cannot be read or has no
/// triangle.
std::vector<Vec<double, 3>> mesh_corners(const std::filesystem::path& file);

/// Points whose convex hull contains the shape (m, in its link). Meshes and boxes give their
/// corners, cylinders those of a circumscribed prism with sixteen sides, spheres the six ends of
/// their axes. Throws InputError if a mesh is missing or cannot be read.
std::vector<Vec<double, 3>> hull_points(const UrdfModel::LinkShape& shape,
                                        const std::filesystem::path& urdf);

/// Points whose convex hull contains `link` and all links fixed to it (m, in its frame). Uses the
/// collision shapes, or the visual shapes if there are none. Empty if there are no shapes. Throws
/// like hull_points().
std::vector<Vec<double, 3>> rigid_hull_points(const UrdfModel& model, int link);

/// Lowest of the rigid_hull_points() along z of `sole` (m): the height at which the foot touches
/// the ground. Empty if the foot has no shape, or a mesh that is missing or cannot be read.
std::optional<double> lowest_point(const UrdfModel& model, const std::string& sole);

}  // namespace saltus::robots
