#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/robots/whole_body/ground.hpp"

namespace saltus::robots {
namespace {

constexpr double ground_size = 2000.0, ground_depth = 0.2;  // m: enough for an hour of walking
constexpr double half = 0.5 * ground_size;
constexpr double landing = 0.06;  // m from the edge, where the height is Ground::height
constexpr double drop = 0.05;     // m, beyond an end and below soft ground
constexpr double tile = 0.1;      // m
constexpr int tiles = 20;         // from the origin along x, and from the edge

// A part of the ground beyond the edge, seen from above.
struct Rectangle {
  Bounds x, distance;   // distance from the edge, m
  double height = 0.0;  // above the plane of the slopes, m
  bool is_soft = false;
};

std::vector<Rectangle> rectangles(const Plant::Ground& ground) {
  const double far = half - std::abs(ground.edge);
  const Rectangle all{{-half, half}, {0.0, far}};
  std::vector<Rectangle> parts{all};
  if (ground.roughness > 0.0) {
    constexpr double reach = tiles * tile;
    parts = {{{-half, -reach}, all.distance},
             {{reach, half}, all.distance},
             {{-reach, reach}, {reach, far}}};
    Random random(static_cast<std::uint64_t>(ground.seed));
    for (int i = -tiles; i < tiles; ++i)
      for (int j = 0; j < tiles; ++j)
        parts.push_back({{i * tile, (i + 1) * tile},
                         {j * tile, (j + 1) * tile},
                         random.uniform(-ground.roughness, ground.roughness)});
  }
  for (Rectangle& part : parts) {
    part.is_soft = ground.sink > 0.0;
    part.x.upper = std::min(part.x.upper, ground.end_forward.value_or(half));
    part.distance.upper = std::min(part.distance.upper, ground.end_side.value_or(far));
  }
  std::erase_if(parts, [](const Rectangle& part) {
    return part.x.lower >= part.x.upper || part.distance.lower >= part.distance.upper;
  });
  if (ground.end_forward || ground.end_side || ground.sink > 0.0)
    parts.push_back({all.x, all.distance, -drop});
  return parts;
}

// The plane z = height + slope_forward x + slope_side (distance - landing). The axes of the boxes
// are the direction of the edge within it, u, and its normal.
class Plane {
 public:
  explicit Plane(const Plant::Ground& ground)
      : side_(ground.edge > 0.0 ? 1.0 : -1.0),
        origin_(0.0, ground.edge, ground.height - landing * ground.slope_side) {
    const double forward = ground.slope_forward, left = side_ * ground.slope_side;
    const Vec<double, 3> u = Vec<double, 3>(1.0, 0.0, forward).normalized();
    const Vec<double, 3> normal = Vec<double, 3>(-forward, -left, 1.0).normalized();
    axes_ << u, normal.cross(u), normal;
    const double squared = 1.0 + forward * forward;
    stretch_ << std::sqrt(squared), std::sqrt((squared + left * left) / squared), 1.0;
  }
  GroundBox box(const Rectangle& part, double friction) const {
    const auto middle = [](const Bounds& b) { return 0.5 * (b.lower + b.upper); };
    GroundBox box;
    box.size = stretch_.cwiseProduct(Vec<double, 3>(
        part.x.upper - part.x.lower, part.distance.upper - part.distance.lower, ground_depth));
    const Vec<double, 3> centre(middle(part.x), side_ * middle(part.distance), -0.5 * ground_depth);
    box.pose.setIdentity();
    box.pose.linear() = axes_;
    box.pose.translation() =
        origin_ + Vec<double, 3>(0.0, 0.0, part.height) + axes_ * stretch_.cwiseProduct(centre);
    box.friction = friction;
    box.is_soft = part.is_soft;
    return box;
  }

 private:
  double side_;
  Vec<double, 3> origin_, stretch_;
  Mat<double, 3, 3> axes_;
};

void expect(bool is_valid, const char* name, double value, const char* range) {
  if (!is_valid)
    throw DefinitionError(fmt::format("Plant::Ground::{} is {}; set it to {}", name, value, range));
}

// Comparisons with NaN are false.
void expect_valid(const Plant::Ground& g) {
  const auto is_within = [](double value, double least, double most) {
    return value >= least && value <= most;
  };
  expect(g.edge != 0.0 && std::abs(g.edge) < half, "edge", g.edge,
         "a number between -1000 m and 1000 m that is not 0");
  expect(is_within(g.height, -half, half), "height", g.height, "between -1000 m and 1000 m");
  for (const auto& [name, slope] :
       {std::pair("slope_forward", g.slope_forward), std::pair("slope_side", g.slope_side)})
    expect(is_within(slope, -1.0, 1.0), name, slope, "between -1 and 1");
  expect(is_within(g.end_forward.value_or(0.0), -half, half), "end_forward",
         g.end_forward.value_or(0.0), "between -1000 m and 1000 m");
  const double end_side = g.end_side.value_or(half);
  expect(end_side > 0.0 && end_side <= half, "end_side", end_side, "above 0 m, up to 1000 m");
  expect(is_within(g.roughness, 0.0, drop), "roughness", g.roughness, "between 0 m and 0.05 m");
  expect(is_within(g.sink, 0.0, drop), "sink", g.sink, "between 0 m and 0.05 m");
  expect(is_within(g.friction, 0.0, 1e3), "friction", g.friction, "between 0 and 1000");
}

// The same ground beside the robot, to the left: turned by a quarter about the vertical.
Plant::Ground beside(const Plant::Ground& ahead) {
  Plant::Ground ground = ahead;
  ground.ahead = false;
  ground.edge = std::abs(ahead.edge);
  ground.height = ahead.height + landing * ahead.slope_forward;
  ground.slope_side = ahead.slope_forward;
  ground.slope_forward = -ahead.slope_side;
  ground.end_forward = ground.end_side = std::nullopt;
  return ground;
}

}  // namespace

std::vector<GroundBox> ground_boxes(const Plant::Options& options) {
  const Plant::Ground& ground = options.ground;
  const auto level = [&options](double y, double width) {
    GroundBox box{
        Eigen::Isometry3d::Identity(), {ground_size, width, ground_depth}, options.friction};
    box.pose.translation() << 0.0, y, -0.5 * ground_depth;
    return box;
  };
  if (ground.is_level()) return {level(0.0, ground_size)};
  expect_valid(ground);
  if (ground.ahead) {
    Plant::Options turned = options;
    turned.ground = beside(ground);
    std::vector<GroundBox> boxes = ground_boxes(turned);
    Mat<double, 3, 3> quarter;
    quarter << 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
    for (GroundBox& box : boxes) box.pose = Eigen::Isometry3d(quarter) * box.pose;
    return boxes;
  }
  const double side = ground.edge > 0.0 ? 1.0 : -1.0, near = half + std::abs(ground.edge);
  std::vector<GroundBox> boxes{level(ground.edge - side * 0.5 * near, near)};
  const Plane plane(ground);
  for (const Rectangle& part : rectangles(ground))
    boxes.push_back(plane.box(part, ground.friction > 0.0 ? ground.friction : options.friction));
  return boxes;
}

double height_at(const std::vector<GroundBox>& boxes, double x, double y) {
  double highest = -infinity;
  for (const GroundBox& box : boxes) {
    const Vec<double, 3> top = box.pose * Vec<double, 3>(0.0, 0.0, 0.5 * box.size[2]);
    const Vec<double, 3> normal = box.pose.linear().col(2);
    Vec<double, 3> away(x - top[0], y - top[1], 0.0);
    away[2] = -(normal[0] * away[0] + normal[1] * away[1]) / normal[2];
    const Vec<double, 3> local = box.pose.linear().transpose() * away;
    if (std::abs(local[0]) <= 0.5 * box.size[0] && std::abs(local[1]) <= 0.5 * box.size[1])
      highest = std::max(highest, top[2] + away[2]);
  }
  return highest;
}

}  // namespace saltus::robots
