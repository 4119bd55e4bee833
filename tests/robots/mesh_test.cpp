#include "saltus/robots/model/mesh.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/app/support.hpp"

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

UrdfShape shape(UrdfShape::Shape kind, const Vec<double, 3>& size, const std::string& mesh = "") {
  UrdfShape result;
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

TEST(Mesh, CornersAreThoseOfTheFile) {
  const TemporaryFolder folder;
  const auto corners = mesh_corners(folder.file("t.stl", tetrahedron));
  ASSERT_EQ(corners.size(), 4u);
  EXPECT_EQ(largest(corners), (Vec<double, 3>(1.0, 2.0, 3.0)));
}

TEST(Mesh, IsFoundBelowItsPackageAndBesideTheUrdf) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "share/biped/meshes");
  std::filesystem::create_directories(folder / "share/biped/urdf");
  const auto mesh = folder.file("share/biped/meshes/t.stl", tetrahedron);
  const auto urdf = folder / "share/biped/urdf/robot.urdf";
  for (const char* reference : {"package://biped/meshes/t.stl", "model://biped/meshes/t.stl",
                                "meshes/t.stl", "package:///biped/meshes/t.stl"})
    EXPECT_EQ(find_mesh(reference, urdf), mesh) << reference;
  EXPECT_EQ(find_mesh("file://" + mesh.string(), urdf), mesh);
  EXPECT_FALSE(find_mesh("package://other/meshes/t.stl", urdf));
  EXPECT_FALSE(find_mesh("package://biped", urdf));
}

TEST(Mesh, OutsideOfTheRobotsFoldersIsOpenedOnlyWhenAsked) {
  const TemporaryFolder folder;
  for (const char* inner : {"share/biped/meshes", "share/biped/urdf", "elsewhere"})
    std::filesystem::create_directories(folder / inner);
  const auto own = folder.file("share/biped/meshes/t.stl", tetrahedron);
  const auto foreign = folder.file("elsewhere/t.stl", tetrahedron);
  const auto urdf = folder / "share/biped/urdf/robot.urdf";
  EXPECT_EQ(find_mesh("../meshes/t.stl", urdf)->lexically_normal(), own);
  const std::vector<std::string> references{
      foreign.string(), "file://" + foreign.string(), "../../../elsewhere/t.stl",
      "package://biped/../../elsewhere/t.stl", "package://../elsewhere/t.stl"};
  for (const std::string& reference : references)
    EXPECT_FALSE(find_mesh(reference, urdf)) << reference;
  const Variable asked("ROS_PACKAGE_PATH", (folder / "elsewhere").c_str());
  EXPECT_EQ(find_mesh(foreign.string(), urdf), foreign);
}

TEST(Mesh, WhatCannotBeReadIsNamed) {
  const TemporaryFolder folder;
  const auto broken = folder.file("broken.stl", "solid nothing\nendsolid\n");
  for (const auto& file : {broken, folder / "absent.stl"}) {
    try {
      mesh_corners(file);
      ADD_FAILURE() << file;
    } catch (const InputError& error) {
      EXPECT_TRUE(contains(error.what(), file.string()));
    }
  }
}

TEST(Mesh, HullsOfShapesReachAsFarAsTheyDo) {
  const TemporaryFolder folder;
  const auto urdf = folder / "robot.urdf";
  folder.file("t.stl", tetrahedron);
  const Vec<double, 3> size(0.4, 0.4, 1.0);
  EXPECT_EQ(largest(hull_points(shape(UrdfShape::Shape::box, size), urdf)), 0.5 * size);
  EXPECT_EQ(largest(hull_points(shape(UrdfShape::Shape::sphere, size), urdf)), 0.5 * size);
  const auto tube = largest(hull_points(shape(UrdfShape::Shape::cylinder, size), urdf));
  EXPECT_DOUBLE_EQ(tube.z(), 0.5);
  EXPECT_NEAR(tube.x(), 0.2, 0.01);
  EXPECT_GE(tube.x(), 0.2);  // around the shape
  UrdfShape mesh = shape(UrdfShape::Shape::mesh, {1.0, 0.5, 2.0}, "t.stl");
  mesh.pose.translation() = Vec<double, 3>(0.0, 0.0, 1.0);
  EXPECT_EQ(largest(hull_points(mesh, urdf)), (Vec<double, 3>(1.0, 1.0, 7.0)));
  mesh.mesh = "package://nowhere/t.stl";
  EXPECT_THROW(hull_points(mesh, urdf), InputError);
}

}  // namespace
}  // namespace saltus
