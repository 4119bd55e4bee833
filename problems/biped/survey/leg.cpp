#include "problems/biped/survey/leg.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace saltus::survey {
namespace {

using Plane = Vec<double, 2>;  // (forward, up) in the frame of the sole, m

constexpr double lateral = 0.7;  // least component of an axis along y of the sole

// Places of hip, knee and ankle.
std::array<Plane, 3> places(const robots::UrdfModel& model, const Leg& leg,
                            const robots::Posture& posture) {
  const std::vector<Eigen::Isometry3d> poses = model.link_poses(posture);
  const Eigen::Isometry3d to_sole = poses[static_cast<std::size_t>(leg.sole)].inverse();
  std::array<Plane, 3> result;
  const std::array<int, 3> links{leg.hip, leg.knee, leg.ankle};
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Vec<double, 3> p = to_sole * poses[static_cast<std::size_t>(links[i])].translation();
    result[i] = {p.x(), p.z()};
  }
  return result;
}

}  // namespace

Bounds Leg::flexion(const Bounds& position) const {
  const double a = flexion(position.lower), b = flexion(position.upper);
  return between(std::min(a, b), std::max(a, b));
}

Leg find_leg(const robots::UrdfModel& model, const std::string& sole) {
  const auto link = [&](int i) -> const robots::UrdfModel::Link& {
    return model.links()[static_cast<std::size_t>(i)];
  };
  Leg leg;
  leg.sole = model.link_index(sole);
  for (int i = leg.sole; link(i).parent >= 0; i = link(i).parent)
    if (link(i).joint.motion == robots::UrdfModel::Joint::Motion::revolute) leg.joints.push_back(i);
  std::reverse(leg.joints.begin(), leg.joints.end());

  const std::vector<Eigen::Isometry3d> poses = model.link_poses({});
  const Eigen::Isometry3d to_sole = poses[static_cast<std::size_t>(leg.sole)].inverse();
  const auto axis_y = [&](int i) {
    return (to_sole.linear() * poses[static_cast<std::size_t>(i)].linear() * link(i).joint.axis)
        .y();
  };
  const auto height = [&](int i) {
    return (to_sole * poses[static_cast<std::size_t>(i)].translation()).z();
  };
  double top = 0.0;  // of the joints of the leg, m
  for (const int i : leg.joints) top = std::max(top, height(i));
  double nearest = 0.3;  // fraction of that height, around one half
  std::size_t at = 0;
  for (std::size_t k = 1; k + 1 < leg.joints.size(); ++k) {
    const int i = leg.joints[k];
    const double off = std::abs(height(i) / top - 0.5);
    if (std::abs(axis_y(i)) < lateral || !(off < nearest)) continue;
    nearest = off;
    at = k;
  }
  if (at == 0) return leg;
  // The lateral joints next to the knee; else the joints next to it.
  leg.knee = leg.joints[at];
  leg.hip = leg.joints[at - 1];
  for (std::size_t k = 0; k < at; ++k)
    if (std::abs(axis_y(leg.joints[k])) > lateral) leg.hip = leg.joints[k];
  leg.ankle = leg.joints[at + 1];
  for (std::size_t k = leg.joints.size() - 1; k > at; --k)
    if (std::abs(axis_y(leg.joints[k])) > lateral) leg.ankle = leg.joints[k];
  // A positive rotation about y moves the shin backwards.
  leg.sign = axis_y(leg.knee) > 0.0 ? 1.0 : -1.0;
  const auto [hip, knee, ankle] = places(model, leg, {});
  const Plane thigh = knee - hip, shin = ankle - knee;
  leg.straight =
      -leg.sign * std::atan2(thigh.y() * shin.x() - thigh.x() * shin.y(), thigh.dot(shin));
  return leg;
}

double knee_ahead(const robots::UrdfModel& model, const Leg& leg, const robots::Posture& posture) {
  const auto [hip, knee, ankle] = places(model, leg, posture);
  const double up = (knee.y() - ankle.y()) / (hip.y() - ankle.y());
  return knee.x() - (ankle.x() + up * (hip.x() - ankle.x()));
}

Vec<double, 2> leg_lengths(const robots::UrdfModel& model, const Leg& leg) {
  const auto [hip, knee, ankle] = places(model, leg, {});
  return {(knee - hip).norm(), (ankle - knee).norm()};
}

}  // namespace saltus::survey
