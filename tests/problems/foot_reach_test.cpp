// The reach of a foot matches the robot's kinematics, and the cache keeps it.
#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "problems/biped/survey/foot_reach.hpp"
#include "tests/robots/icub_body.hpp"

namespace saltus::survey {
namespace {

namespace fs = std::filesystem;

robots::SupportPolygon hull_of(const std::vector<robots::Point2>& corners) {
  Eigen::Matrix<double, Eigen::Dynamic, 2> points(static_cast<int>(corners.size()), 2);
  for (std::size_t i = 0; i < corners.size(); ++i)
    points.row(static_cast<int>(i)) = corners[i].transpose();
  return robots::SupportPolygon::hull(points);
}

class IcubReach : public IcubBody {};

TEST_F(IcubReach, MatchesItsLegsAndRoundTrips) {
  const fs::path folder = fs::path(testing::TempDir()) / "reach_of_icub";
  fs::remove_all(folder);
  const auto found = cached_foot_reach(*urdf, description, folder);
  ASSERT_TRUE(found);
  const robots::SupportPolygon from_foot = hull_of(found->from_foot);
  for (const robots::Point2& corner : found->from_foot)
    fmt::print("foot {:.3f} {:.3f}\n", corner[0], corner[1]);
  for (const robots::Point2& corner : found->from_com)
    fmt::print("CoM {:.3f} {:.3f}\n", corner[0], corner[1]);
  // Steps that iCub takes in DART are inside; places with crossed or touching legs are outside.
  EXPECT_TRUE(from_foot.contains(robots::Point2(0.0, 0.14)));
  EXPECT_TRUE(from_foot.contains(robots::Point2(0.0, 0.25)));
  EXPECT_TRUE(from_foot.contains(robots::Point2(0.15, 0.14)));
  EXPECT_FALSE(from_foot.contains(robots::Point2(0.0, 0.05)));
  EXPECT_FALSE(from_foot.contains(robots::Point2(0.0, -0.05)));
  EXPECT_FALSE(from_foot.contains(robots::Point2(0.6, 0.14)));

  // Sign check of the forward axis: iCub's legs reach farther backward than forward.
  const robots::SupportPolygon from_com =
      hull_of(found ? found->from_com : std::vector<robots::Point2>{});
  const robots::Point2 back(-0.215, 0.285);
  EXPECT_TRUE(from_com.contains(back));
  EXPECT_FALSE(from_com.contains(robots::Point2(-back[0], back[1])));

  // The computed value and the value read from the file are bit-identical.
  const auto read = cached_foot_reach(*urdf, description, folder);
  ASSERT_TRUE(read);
  for (std::size_t i = 0; i < found->from_foot.size(); ++i) {
    EXPECT_EQ(read->from_foot[i], found->from_foot[i]);
    EXPECT_EQ(read->from_com[i], found->from_com[i]);
  }

  // Modify the file to verify that it is read.
  for (const fs::directory_entry& file : fs::directory_iterator(folder)) {
    std::ofstream marked(file.path());
    for (int i = 0; i < 2 * reach_directions; ++i) marked << i << " 7\n";
  }
  const auto again = cached_foot_reach(*urdf, description, folder);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->from_com[0], robots::Point2(reach_directions, 7.0));
  // The file is not read for another robot.
  robots::RobotDescription other = description;
  other.contact_plane_offset += 1e-3;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
  const auto others = cached_foot_reach(*urdf, other, folder);
  EXPECT_TRUE(!others || others->from_com[0] != robots::Point2(reach_directions, 7.0));
}

}  // namespace
}  // namespace saltus::survey
