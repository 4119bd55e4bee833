// Where are the corners of the shapes that a URDF gives its links?
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/robots/model/urdf_model.hpp"

namespace saltus {

/// The file that package://NAME/REST, model://NAME/REST, file://PATH or a path in a URDF stands
/// for. Packages are looked for around the URDF (not at the top of the file system), then where
/// ROS_PACKAGE_PATH, GAZEBO_MODEL_PATH and AMENT_PREFIX_PATH say; paths must lie in the URDF's
/// folder, in one of the two above it or in one that these variables name, and no name leads out of
/// its package: a URDF from elsewhere opens no other files of its reader. None if there is no such
/// file.
std::optional<std::filesystem::path> find_mesh(const std::string& reference,
                                               const std::filesystem::path& urdf);

/// Corners of all triangles of a mesh (STL, Collada or OBJ, by its ending), each place once, in the
/// file's axes, m for files that name no unit. Other files that it names are not opened. Throws
/// InputError, one sentence naming the file, when it cannot be read or has no triangle.
std::vector<Vec<double, 3>> mesh_corners(const std::filesystem::path& file);

/// Points whose convex hull is that of the shape (m, in its link): corners of meshes and boxes; of
/// cylinders those of a prism around them with sixteen sides, of spheres the six ends of their
/// axes. Throws InputError for a mesh that is not there or cannot be read.
std::vector<Vec<double, 3>> hull_points(const UrdfShape& shape, const std::filesystem::path& urdf);

/// Points whose convex hull is that of `link` with all that is fixed to it (m, in its frame): of
/// the shapes that collide, else of those that are seen. Empty if there are none. Throws like
/// hull_points().
std::vector<Vec<double, 3>> rigid_hull_points(const UrdfModel& model, int link);

/// The lowest of these along z of `sole` (m): where the foot touches the ground. None if the foot
/// has no shape, or a mesh that is not there or cannot be read.
std::optional<double> lowest_point(const UrdfModel& model, const std::string& sole);

}  // namespace saltus
