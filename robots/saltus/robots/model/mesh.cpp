#include "saltus/robots/model/mesh.hpp"

#include <assimp/config.h>
#include <assimp/mesh.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <sstream>
#include <string_view>

#include "saltus/core/file_content.hpp"
#include "saltus/core/isolated_call.hpp"
#include "saltus/core/text.hpp"
#include "saltus/robots/model/xml_nesting.hpp"

namespace saltus::robots {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t largest_mesh = max_file_size;  // 1.3 million triangles

// Formats of robot meshes. Other formats of Assimp refer to further files, or are packed.
constexpr std::array formats{"stl", "dae", "obj"};

// A mesh is read from memory. Further files that it refers to, such as materials and pictures, are
// not opened.
class NoOtherFiles final : public Assimp::IOSystem {
 public:
  bool Exists(const char*) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
  void Close(Assimp::IOStream*) override {}
};

// Extension without the dot, in lower case.
std::string extension_of(const fs::path& file) {
  std::string extension = file.extension().string();
  if (!extension.empty()) extension.erase(0, 1);
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

bool is_file(const fs::path& path) {
  std::error_code absent;
  return fs::is_regular_file(path, absent);
}

// The folder of a URDF and those above it, except those at the top of the file system, which
// contain more than robots.
std::vector<fs::path> folders_around(const fs::path& urdf) {
  std::vector<fs::path> folders{fs::absolute(urdf).parent_path()};
  for (fs::path above = folders.front().parent_path(); above.parent_path() != above.root_path();
       above = above.parent_path())
    folders.push_back(above);
  return folders;
}

// Folders in which the user keeps packages.
std::vector<fs::path> named_folders() {
  std::vector<fs::path> folders;
  for (const char* variable : {"ROS_PACKAGE_PATH", "GAZEBO_MODEL_PATH", "AMENT_PREFIX_PATH"}) {
    const char* paths = std::getenv(variable);
    std::istringstream list(paths == nullptr ? "" : paths);
    for (std::string folder; std::getline(list, folder, ':');)
      if (!folder.empty()) folders.emplace_back(fs::absolute(folder));
  }
  return folders;
}

// Compares names only. Symbolic links are the responsibility of their creator.
bool lies_in(const fs::path& folder, const fs::path& file) {
  const fs::path inner = file.lexically_normal().lexically_relative(folder.lexically_normal());
  return !inner.empty() && *inner.begin() != "..";
}

// Folders of packages that keep robots/NAME/ next to meshes/.
std::vector<fs::path> folders_of_robot(const fs::path& urdf) {
  std::vector<fs::path> folders = folders_around(urdf);
  if (folders.size() > 3) folders.resize(3);
  return folders;
}

void add_corners(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent,
                 std::vector<Vec<double, 3>>& corners) {
  const aiMatrix4x4 pose = parent * node.mTransformation;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    if ((mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0u) continue;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D p = pose * mesh.mVertices[v];
      corners.emplace_back(p.x, p.y, p.z);
    }
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c)
    add_corners(scene, *node.mChildren[c], pose, corners);
}

// Error of Assimp, with the name of the file instead of the name that Assimp gives to memory.
std::string complaint(const Assimp::Importer& importer, const fs::path& file) {
  std::string text = importer.GetErrorString();
  const std::size_t begin = text.find("$$$___magic___$$$");
  if (begin != std::string::npos)
    text.replace(begin, text.find(' ', begin) - begin, file.filename().string());
  return shortened(text);
}

bool before(const Vec<double, 3>& a, const Vec<double, 3>& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

constexpr char corners_follow = 'c', complaint_follows = 'e';

// Corners of all triangles as bytes, or the reason why there are none.
std::string corners_or_complaint(const std::string& content, const std::string& extension,
                                 const fs::path& file) {
  Assimp::Importer importer;
  importer.SetIOHandler(new NoOtherFiles);  // the importer takes ownership
  // Read Collada like the simulators and viewers of ROS: keep its axes, apply its unit.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene =
      importer.ReadFileFromMemory(content.data(), content.size(),
                                  aiProcess_Triangulate | aiProcess_SortByPType, extension.c_str());
  if (scene == nullptr || scene->mRootNode == nullptr)
    return complaint_follows + fmt::format("the mesh cannot be read ({}); export it again as STL",
                                           complaint(importer, file));
  std::vector<Vec<double, 3>> corners;
  add_corners(*scene, *scene->mRootNode, aiMatrix4x4(), corners);
  if (corners.empty() || !std::all_of(corners.begin(), corners.end(),
                                      [](const Vec<double, 3>& p) { return p.allFinite(); }))
    return complaint_follows +
           std::string(
               "the mesh has no triangles, or corners that are not finite; export it again");
  std::sort(corners.begin(), corners.end(), before);
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  std::string bytes(1 + corners.size() * sizeof(Vec<double, 3>), corners_follow);
  std::memcpy(bytes.data() + 1, corners.data(), bytes.size() - 1);
  return bytes;
}

// Corners at both ends of a shape along z.
std::vector<Vec<double, 3>> prism(const Vec<double, 3>& size) {
  constexpr int sides = 16;
  const double around = 0.5 / std::cos(std::numbers::pi / sides);
  std::vector<Vec<double, 3>> points;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    for (const double end : {-0.5, 0.5})
      points.emplace_back(around * size.x() * std::cos(angle), around * size.y() * std::sin(angle),
                          end * size.z());
  }
  return points;
}

std::vector<Vec<double, 3>> box_corners(const Vec<double, 3>& size) {
  std::vector<Vec<double, 3>> points;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5})
        points.push_back(size.cwiseProduct(Vec<double, 3>(x, y, z)));
  return points;
}

std::vector<Vec<double, 3>> axis_ends(const Vec<double, 3>& size) {
  std::vector<Vec<double, 3>> points;
  for (int axis = 0; axis < 3; ++axis)
    for (const double end : {-0.5, 0.5})
      points.push_back(end * size[axis] * Vec<double, 3>::Unit(axis));
  return points;
}

}  // namespace

std::optional<fs::path> find_mesh(const std::string& reference, const fs::path& urdf) {
  constexpr std::string_view file_scheme = "file://";
  std::string rest = reference;
  if (rest.starts_with(file_scheme)) rest.erase(0, file_scheme.size());
  for (const std::string_view scheme : {"package://", "model://"}) {
    if (!rest.starts_with(scheme)) continue;
    rest.erase(0, scheme.size());
    rest.erase(0, rest.find_first_not_of('/'));
    const std::string name = rest.substr(0, rest.find('/'));
    rest.erase(0, std::min(rest.size(), name.size() + 1));
    if (name.empty() || name == "." || name == ".." || rest.empty()) return std::nullopt;
    std::vector<fs::path> folders = folders_around(urdf), named = named_folders();
    folders.insert(folders.end(), named.begin(), named.end());
    for (const fs::path& folder : folders) {
      std::vector<fs::path> packages{folder / name, folder / "share" / name};
      if (folder.filename() == name) packages.push_back(folder);
      for (const fs::path& package : packages)
        if (lies_in(package, package / rest) && is_file(package / rest)) return package / rest;
    }
    return std::nullopt;
  }
  std::vector<fs::path> allowed = folders_of_robot(urdf);
  const std::vector<fs::path> around = allowed, named = named_folders();
  allowed.insert(allowed.end(), named.begin(), named.end());
  for (const fs::path& folder : around) {
    const fs::path file = folder / rest;  // just `rest` if it is absolute
    const bool is_inside = std::any_of(allowed.begin(), allowed.end(),
                                       [&](const fs::path& a) { return lies_in(a, file); });
    if (is_inside && is_file(file)) return file;
  }
  return std::nullopt;
}

std::vector<Vec<double, 3>> mesh_corners(const fs::path& file) {
  const std::string extension = extension_of(file);
  if (std::find(formats.begin(), formats.end(), extension) == formats.end())
    throw InputError(fmt::format("{}: the supported mesh formats are {}; export it as STL",
                                 file.string(), join_names({formats.begin(), formats.end()})));
  std::error_code unknown;
  const std::uintmax_t size = fs::file_size(file, unknown);
  if (!unknown && size > largest_mesh)
    throw InputError(
        fmt::format("{}: the mesh has {} MB, more than {}; export it with fewer triangles",
                    file.string(), size >> 20U, largest_mesh >> 20U));
  const std::string content = file_content(file, largest_mesh);
  if (content.empty())
    throw InputError(fmt::format("{}: the mesh is an empty file; export it again", file.string()));
  const auto doubt = extension == "dae" ? xml_nesting_error(content) : std::nullopt;
  if (doubt) throw InputError(fmt::format("{}: {}; export it again as STL", file.string(), *doubt));
  // Malformed text can make readers of Assimp access memory beyond their arrays.
  constexpr int longest = 20;  // limit of the processor time, s
  const auto answer =
      isolated_call([&] { return corners_or_complaint(content, extension, file); }, longest);
  if (!answer || answer->empty())
    throw InputError(fmt::format(
        "{}: the mesh cannot be read, because its reader crashed; export it again as STL",
        file.string()));
  const std::string_view rest = std::string_view(*answer).substr(1);
  if (answer->front() == complaint_follows)
    throw InputError(fmt::format("{}: {}", file.string(), rest));
  std::vector<Vec<double, 3>> corners(rest.size() / sizeof(Vec<double, 3>));
  std::memcpy(static_cast<void*>(corners.data()), rest.data(),
              corners.size() * sizeof(Vec<double, 3>));
  return corners;
}

std::vector<Vec<double, 3>> hull_points(const UrdfModel::LinkShape& shape, const fs::path& urdf) {
  std::vector<Vec<double, 3>> points;
  switch (shape.shape) {
    case UrdfModel::LinkShape::Shape::mesh: {
      const auto file = find_mesh(shape.mesh, urdf);
      if (!file)
        throw InputError(
            fmt::format("{}: the mesh {} is not in the robot's folders; put its package next to "
                        "the URDF, or add the folder that contains it to ROS_PACKAGE_PATH",
                        urdf.string(), shortened(shape.mesh)));
      points = mesh_corners(*file);
      for (Vec<double, 3>& p : points) p = p.cwiseProduct(shape.size);
      break;
    }
    case UrdfModel::LinkShape::Shape::box:
      points = box_corners(shape.size);
      break;
    case UrdfModel::LinkShape::Shape::cylinder:
      points = prism(shape.size);
      break;
    case UrdfModel::LinkShape::Shape::sphere:
      points = axis_ends(shape.size);
      break;
  }
  for (Vec<double, 3>& p : points) p = shape.pose * p;
  return points;
}

std::vector<Vec<double, 3>> rigid_hull_points(const UrdfModel& model, int link) {
  const std::vector<Eigen::Isometry3d> poses = model.link_poses({});
  const Eigen::Isometry3d to_link = poses[static_cast<std::size_t>(link)].inverse();
  std::vector<Vec<double, 3>> points;
  for (const auto shapes : {&UrdfModel::Link::collisions, &UrdfModel::Link::visuals}) {
    for (const int i : model.rigid_group(link))
      for (const UrdfModel::LinkShape& shape : model.links()[static_cast<std::size_t>(i)].*shapes)
        for (const Vec<double, 3>& p : hull_points(shape, model.source()))
          points.push_back(to_link * (poses[static_cast<std::size_t>(i)] * p));
    if (!points.empty()) break;
  }
  return points;
}

std::optional<double> lowest_point(const UrdfModel& model, const std::string& sole) {
  std::optional<double> lowest;
  try {
    for (const Vec<double, 3>& p : rigid_hull_points(model, model.link_index(sole)))
      lowest = std::min(lowest.value_or(infinity), p.z());
  } catch (const InputError&) {
    return std::nullopt;
  }
  return lowest;
}

}  // namespace saltus::robots
