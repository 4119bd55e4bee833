#include "saltus/robots/whole_body/clearance.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capsule.hpp"

namespace saltus::robots {
namespace {

using Point = Vec<double, 3>;

// Segments that cross have no normal. Any constant direction will do.
constexpr double crossing = 1e-9;  // m

}  // namespace

Clearance::Clearance(const FloatingRobot& robot, int most) : bodies_(robot.bodies.size()) {
  if (most < 1)
    throw DefinitionError(fmt::format("clearance: at least one pair must be kept, not {}", most));
  std::vector<std::vector<int>> of_body(robot.bodies.size());
  for (std::size_t b = 0; b < robot.bodies.size(); ++b) {
    const FloatingRobot::Body& body = robot.bodies[b];
    links_.push_back({body.parent, body.origin, body.axis});
    for (const RobotDescription::LinkCapsule& shape : body.capsules) {
      of_body[b].push_back(static_cast<int>(members_.size()));
      members_.push_back({static_cast<int>(b), shape});
      capsules_.push_back(shape.capsule);
      reaches_.push_back(0.5 * shape.capsule.length() + shape.capsule.radius);
    }
  }
  for (const auto& [first, second] : robot.apart)
    for (const int i : of_body[static_cast<std::size_t>(first)])
      for (const int k : of_body[static_cast<std::size_t>(second)]) pairs_.emplace_back(i, k);
  nearest_.resize(static_cast<std::size_t>(most));
  urgency_.resize(static_cast<std::size_t>(most));
}

void Clearance::move(const WholeBodyState& state) noexcept {
  for (std::size_t b = 0; b < links_.size(); ++b) {
    const Link& link = links_[b];
    Motion& m = bodies_[b];
    if (link.parent < 0) {
      m.pose = state.base;
      m.axis = m.turn = m.speed = m.turn_change = m.speed_change = Point::Zero();
      continue;
    }
    const Motion& parent = bodies_[static_cast<std::size_t>(link.parent)];
    const int joint = static_cast<int>(b) - 1;
    const double rate = state.dq[joint];
    m.pose = parent.pose * link.origin;
    m.axis = m.pose.linear() * link.axis;
    m.pose.rotate(Eigen::AngleAxisd(state.q[joint], link.axis));
    const Point arm = m.pose.translation() - parent.pose.translation();
    m.turn = parent.turn + rate * m.axis;
    m.speed = parent.speed + parent.turn.cross(arm);
    m.turn_change = parent.turn_change + rate * parent.turn.cross(m.axis);
    m.speed_change = parent.speed_change + parent.turn_change.cross(arm) +
                     parent.turn.cross(parent.turn.cross(arm));
  }
  for (std::size_t i = 0; i < members_.size(); ++i)
    capsules_[i] =
        bodies_[static_cast<std::size_t>(members_[i].body)].pose * members_[i].shape.capsule;
}

Approach Clearance::approach_of(int first, int second) const noexcept {
  const Capsule& a = capsules_[static_cast<std::size_t>(first)];
  const Capsule& b = capsules_[static_cast<std::size_t>(second)];
  const SegmentPoints points = closest_points(a, b);
  Approach result;
  result.first = first;
  result.second = second;
  result.on_first = points.first;
  result.on_second = points.second;
  const Point between = points.first - points.second;
  const double length = between.norm();
  result.distance = length - a.radius - b.radius;
  result.normal = length > crossing ? Point(between / length) : Point::UnitZ();
  const auto at = [this](int member) -> const Motion& {
    return bodies_[static_cast<std::size_t>(members_[static_cast<std::size_t>(member)].body)];
  };
  const Motion &moving_a = at(first), &moving_b = at(second);
  const auto velocity = [](const Motion& m, const Point& p) -> Point {
    return m.speed + m.turn.cross(p - m.pose.translation());
  };
  const auto acceleration = [](const Motion& m, const Point& p) -> Point {
    const Point arm = p - m.pose.translation();
    return m.speed_change + m.turn_change.cross(arm) + m.turn.cross(m.turn.cross(arm));
  };
  result.speed =
      result.normal.dot(velocity(moving_a, points.first) - velocity(moving_b, points.second));
  result.drift = result.normal.dot(acceleration(moving_a, points.first) -
                                   acceleration(moving_b, points.second));
  return result;
}

void Clearance::stand(const WholeBodyState& state, double margin) {
  move(state);
  keeps_.clear();
  for (const auto& [first, second] : pairs_) {
    const double distance = approach_of(first, second).distance;
    keeps_.push_back(distance < 2.0 * margin ? 0.5 * std::max(0.0, distance) : infinity);
  }
}

void Clearance::update(const WholeBodyState& state, double range, double ahead) noexcept {
  move(state);
  count_ = 0;
  const int most = static_cast<int>(nearest_.size());
  for (std::size_t pair = 0; pair < pairs_.size(); ++pair) {
    const auto [first, second] = pairs_[pair];
    const auto i = static_cast<std::size_t>(first), k = static_cast<std::size_t>(second);
    const double near = range + reaches_[i] + reaches_[k];
    if ((capsules_[i].middle() - capsules_[k].middle()).squaredNorm() > near * near) continue;
    Approach candidate = approach_of(first, second);
    if (candidate.distance >= range) continue;
    if (!keeps_.empty()) candidate.keep = keeps_[pair];
    const double urgency = candidate.distance + ahead * candidate.speed;
    if (count_ == most && urgency >= urgency_.back()) continue;
    int place = count_ < most ? count_++ : most - 1;
    for (; place > 0 && urgency_[static_cast<std::size_t>(place) - 1] > urgency; --place) {
      nearest_[static_cast<std::size_t>(place)] = nearest_[static_cast<std::size_t>(place) - 1];
      urgency_[static_cast<std::size_t>(place)] = urgency_[static_cast<std::size_t>(place) - 1];
    }
    nearest_[static_cast<std::size_t>(place)] = candidate;
    urgency_[static_cast<std::size_t>(place)] = urgency;
  }
}

void Clearance::jacobian(int i, Eigen::Ref<VectorXd> row) const noexcept {
  row.setZero();
  const Approach& a = nearest_[static_cast<std::size_t>(i)];
  const auto add = [&](int member, const Point& point, double sign) {
    for (int b = members_[static_cast<std::size_t>(member)].body; b > 0;
         b = links_[static_cast<std::size_t>(b)].parent) {
      const Motion& m = bodies_[static_cast<std::size_t>(b)];
      row[b - 1] += sign * a.normal.dot(m.axis.cross(point - m.pose.translation()));
    }
  };
  add(a.first, a.on_first, 1.0);
  add(a.second, a.on_second, -1.0);
}

std::string Clearance::names(const Approach& a) const {
  return fmt::format("{} and {}", members_[static_cast<std::size_t>(a.first)].shape.link,
                     members_[static_cast<std::size_t>(a.second)].shape.link);
}

}  // namespace saltus::robots
