#include "saltus/robots/walking/body_forces.hpp"

#include "saltus/ocp/schedule.hpp"

namespace saltus::robots::walking {
namespace {

// Force and torque in the axes of a sole.
Vec<double, 6> in_sole(const Eigen::Isometry3d& sole, const Vec<double, 6>& world) {
  Vec<double, 6> w;
  w << sole.linear().transpose() * world.head<3>(), sole.linear().transpose() * world.tail<3>();
  return w;
}

// Mean over the samples of (t - wrench_filter, t]. Each sum is computed from scratch, so that no
// rounding error accumulates.
std::vector<Vec<double, 12>> filtered(const RunLog& log,
                                      const std::vector<Vec<double, 12>>& wrenches) {
  std::vector<Vec<double, 12>> means;
  means.reserve(wrenches.size());
  std::size_t first = 0;
  for (std::size_t i = 0; i < wrenches.size(); ++i) {
    while (log.samples[first].time <= log.samples[i].time - wrench_filter + same_instant) ++first;
    Vec<double, 12> sum = Vec<double, 12>::Zero();
    for (std::size_t k = first; k <= i; ++k) sum += wrenches[k];
    means.emplace_back(sum / static_cast<double>(i - first + 1));
  }
  return means;
}

// Largest horizontal motion of a corner of the sole, m.
double largest_motion(const FootRectangle& foot, const Eigen::Isometry3d& from,
                      const Eigen::Isometry3d& to) {
  const auto corners = [&foot](const Eigen::Isometry3d& sole) {
    return foot_corners({sole.translation(), sole.linear()}, foot);
  };
  return (corners(to) - corners(from)).rowwise().norm().maxCoeff();
}

}  // namespace

std::vector<Vec<double, 12>> measured_wrenches(const RunLog& log) {
  std::vector<Vec<double, 12>> wrenches;
  wrenches.reserve(log.body.size());
  for (const RunLog::BodySample& b : log.body) {
    Vec<double, 12> w;
    w << in_sole(b.left_sole, b.left), in_sole(b.right_sole, b.right);
    wrenches.push_back(w);
  }
  return wrenches;
}

std::vector<Vec<double, 12>> filtered_wrenches(const RunLog& log) {
  return filtered(log, measured_wrenches(log));
}

std::vector<Vec<double, 2>> sole_slip(const RunLog& log) {
  std::vector<Vec<double, 2>> slips;
  slips.reserve(log.body.size());
  const RunLog::BodySample *left = nullptr,
                           *right = nullptr;  // first sample in which that foot stands
  for (std::size_t i = 0; i < log.body.size(); ++i) {
    const RunLog::BodySample& b = log.body[i];
    const BipedSample& s = log.samples[i];
    left = !s.left_stands ? nullptr : left == nullptr ? &b : left;
    right = !s.right_stands ? nullptr : right == nullptr ? &b : right;
    const RobotDescription& robot = log.robot;
    slips.emplace_back(
        left == nullptr ? 0.0 : largest_motion(robot.left_foot, left->left_sole, b.left_sole),
        right == nullptr ? 0.0 : largest_motion(robot.right_foot, right->right_sole, b.right_sole));
  }
  return slips;
}

std::vector<Vec<double, 2>> friction_used(const RunLog& log) {
  std::vector<Vec<double, 2>> used;
  used.reserve(log.body.size());
  const auto ratio = [](const Vec<double, 6>& wrench) {
    return wrench[2] < friction_min_force ? 0.0 : wrench.head<2>().norm() / wrench[2];
  };
  for (const RunLog::BodySample& b : log.body) used.emplace_back(ratio(b.left), ratio(b.right));
  return used;
}

Vec<double, 2> peak_forces(const RunLog& log) {
  Vec<double, 2> peak = Vec<double, 2>::Zero();
  for (const Vec<double, 12>& w : filtered_wrenches(log))
    peak = peak.cwiseMax(Vec<double, 2>(w[2], w[8]));
  return peak;
}

}  // namespace saltus::robots::walking
