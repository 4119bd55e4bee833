#include "saltus/robots/model/mesh.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/app/support.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

// A tetrahedron with legs of one, two and three metres along x, y and z.
constexpr const char* tetrahedron = R"(solid t
facet normal 0 0 -1
outer loop
vertex 0 0 0
vertex 0 2 0
vertex 1 0 0
endloop
endfacet
facet normal 0 -1 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 3
endloop
endfacet
endsolid t
)";

robots::UrdfModel::LinkShape shape(robots::UrdfModel::LinkShape::Shape kind,
                                   const Vec<double, 3>& size, const std::string& mesh = "") {
  robots::UrdfModel::LinkShape result;
  result.shape = kind;
  result.size = size;
  result.mesh = mesh;
  return result;
}

Vec<double, 3> largest(const std::vector<Vec<double, 3>>& points) {
  Vec<double, 3> most = points.at(0);
  for (const Vec<double, 3>& p : points) most = most.cwiseMax(p);
  return most;
}

TEST(Mesh, CornersMatchTheFile) {
  const TemporaryFolder folder;
  const auto corners = robots::mesh_corners(folder.file("t.stl", tetrahedron));
  ASSERT_EQ(corners.size(), 4u);
  EXPECT_EQ(largest(corners), (Vec<double, 3>(1.0, 2.0, 3.0)));
}

TEST(Mesh, IsFoundInItsPackageOrNextToTheUrdf) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "share/biped/meshes");
  std::filesystem::create_directories(folder / "share/biped/urdf");
  const auto mesh = folder.file("share/biped/meshes/t.stl", tetrahedron);
  const auto urdf = folder / "share/biped/urdf/robot.urdf";
  for (const char* reference : {"package://biped/meshes/t.stl", "model://biped/meshes/t.stl",
                                "meshes/t.stl", "package:///biped/meshes/t.stl"})
    EXPECT_EQ(robots::find_mesh(reference, urdf), mesh) << reference;
  EXPECT_EQ(robots::find_mesh("file://" + mesh.string(), urdf), mesh);
  EXPECT_FALSE(robots::find_mesh("package://other/meshes/t.stl", urdf));
  EXPECT_FALSE(robots::find_mesh("package://biped", urdf));
}

TEST(Mesh, OpensFilesOutsideTheRobotFoldersOnRequestOnly) {
  const TemporaryFolder folder;
  for (const char* inner : {"share/biped/meshes", "share/biped/urdf", "elsewhere"})
    std::filesystem::create_directories(folder / inner);
  const auto own = folder.file("share/biped/meshes/t.stl", tetrahedron);
  const auto foreign = folder.file("elsewhere/t.stl", tetrahedron);
  const auto urdf = folder / "share/biped/urdf/robot.urdf";
  EXPECT_EQ(robots::find_mesh("../meshes/t.stl", urdf)->lexically_normal(), own);
  const std::vector<std::string> references{
      foreign.string(), "file://" + foreign.string(), "../../../elsewhere/t.stl",
      "package://biped/../../elsewhere/t.stl", "package://../elsewhere/t.stl"};
  for (const std::string& reference : references)
    EXPECT_FALSE(robots::find_mesh(reference, urdf)) << reference;
  const Variable asked("ROS_PACKAGE_PATH", (folder / "elsewhere").c_str());
  EXPECT_EQ(robots::find_mesh(foreign.string(), urdf), foreign);
}

// The root of the file system is not in any robot's folders, for any package name.
TEST(Mesh, RejectsAPackageAtTheRoot) {
  const TemporaryFolder folder;
  const auto file = folder.file("t.stl", tetrahedron);
  EXPECT_FALSE(robots::find_mesh("package://etc/hostname", folder / "robot.urdf"));
  EXPECT_FALSE(robots::find_mesh("package:/" + file.string(), folder / "robot.urdf"));
  EXPECT_TRUE(robots::find_mesh("t.stl", folder / "robot.urdf"));
}

TEST(Mesh, ReadsThreeFormats) {
  const TemporaryFolder folder;
  const auto outside = folder.file("outside.mtl", "newmtl x\n");
  const auto corners = robots::mesh_corners(
      folder.file("t.OBJ", "mtllib outside.mtl\nv 0 0 0\nv 1 0 0\nv 0 2 0\nusemtl x\nf 1 2 3\n"));
  ASSERT_EQ(corners.size(), 3u);
  EXPECT_EQ(largest(corners), (Vec<double, 3>(1.0, 2.0, 0.0)));
  const auto collada = robots::mesh_corners(folder.file(
      "t.dae",
      R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 2 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)"));
  EXPECT_EQ(largest(collada), (Vec<double, 3>(1.0, 2.0, 0.0)));
  for (const char* name : {"t.ply", "t.zae", "t"})
    EXPECT_TRUE(
        contains(complaint_of([&] { robots::mesh_corners(folder.file(name, tetrahedron)); }),
                 "stl, dae and obj"));
  std::string deep = "<COLLADA>";
  for (int i = 0; i < 200; ++i) deep += "<node>";
  EXPECT_TRUE(contains(complaint_of([&] { robots::mesh_corners(folder.file("deep.dae", deep)); }),
                       "nested more than 100 deep"));
}

// Found by fuzzing: Assimp's OBJ reader writes out of bounds.
TEST(Mesh, CrashedReaderGivesASentence) {
  const TemporaryFolder folder;
  const std::filesystem::path input =
      std::filesystem::path(SALTUS_FUZZ_CORPUS) / "mesh/leads_assimp_astray.obj";
  std::filesystem::copy_file(input, folder / "m.obj");
  EXPECT_TRUE(
      contains(complaint_of([&] { robots::mesh_corners(folder / "m.obj"); }), "m.obj: the mesh"));
}

TEST(Mesh, NamesUnreadableFiles) {
  const TemporaryFolder folder;
  const auto broken = folder.file("broken.stl", "solid nothing\nendsolid\n");
  for (const auto& file : {broken, folder / "absent.stl"})
    expect_error<InputError>([&] { robots::mesh_corners(file); }, {file.string()});
}

TEST(Mesh, HullsOfShapesHaveTheirExtent) {
  const TemporaryFolder folder;
  const auto urdf = folder / "robot.urdf";
  folder.file("t.stl", tetrahedron);
  const Vec<double, 3> size(0.4, 0.4, 1.0);
  EXPECT_EQ(
      largest(robots::hull_points(shape(robots::UrdfModel::LinkShape::Shape::box, size), urdf)),
      0.5 * size);
  EXPECT_EQ(
      largest(robots::hull_points(shape(robots::UrdfModel::LinkShape::Shape::sphere, size), urdf)),
      0.5 * size);
  const auto tube = largest(
      robots::hull_points(shape(robots::UrdfModel::LinkShape::Shape::cylinder, size), urdf));
  EXPECT_DOUBLE_EQ(tube.z(), 0.5);
  EXPECT_NEAR(tube.x(), 0.2, 0.01);
  EXPECT_GE(tube.x(), 0.2);  // around the shape
  robots::UrdfModel::LinkShape mesh =
      shape(robots::UrdfModel::LinkShape::Shape::mesh, {1.0, 0.5, 2.0}, "t.stl");
  mesh.pose.translation() = Vec<double, 3>(0.0, 0.0, 1.0);
  EXPECT_EQ(largest(robots::hull_points(mesh, urdf)), (Vec<double, 3>(1.0, 1.0, 7.0)));
  mesh.mesh = "package://nowhere/t.stl";
  EXPECT_THROW(robots::hull_points(mesh, urdf), InputError);
}

}  // namespace
}  // namespace saltus
