#include "saltus/robots/walking/biped_problem.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "saltus/robots/walking/body_verdict.hpp"

namespace saltus::robots::walking {
namespace {

constexpr double fallen_height = 0.30, fallen_distance = 1.0;  // m, of iCub

bool is_before_all(std::span<const Push> pushes, double t) {
  return !pushes.empty() && std::all_of(pushes.begin(), pushes.end(),
                                        [t](const Push& push) { return t < push.start; });
}

}  // namespace

Verdict figures_of(const RunLog& log, double settled_from, std::span<const Push> pushes) {
  Verdict v;
  for (const BipedSample& s : log.samples) {
    v.com_height_min = std::min(v.com_height_min, s.gamma[2]);
    v.com_height_max = std::max(v.com_height_max, s.gamma[2]);
    v.angular_momentum_max = std::max(v.angular_momentum_max, s.gamma.tail<3>().norm());
  }
  const BipedSample& last = log.samples.back();
  v.final_com_error = (last.gamma.head<2>() - log.final_scene.target_point()).norm();
  v.settled_from = settled_from;
  v.icp_settling = 0.0;
  for (const BipedSample& s : log.samples)
    if (s.time >= settled_from &&
        (s.capture_point - last.capture_point).norm() > icp_settled_within)
      v.icp_settling = s.time - settled_from;
  if (log.stopped_early) {
    v.icp_settling = infinity;
    v.fail(log.stop_reason);
  }
  if (!log.body.empty()) v.body = judge_body(log);
  v.fell_before_push = log.stopped_early && !log.numerical_failure && !log.interrupted &&
                       is_before_all(pushes, last.time);
  return v;
}

bool has_fallen(const Vec<double, 9>& gamma, const Vec<double, 3>& foot, double com_height) {
  const double size = com_height / reference_height;
  return !(gamma[2] >= fallen_height * size &&
           (gamma.head<2>() - foot.head<2>()).norm() <= fallen_distance * size);
}

std::string fall_sentence(std::span<const Push> pushes, double t) {
  return fmt::format("fell at {:.2f} s{}", t, is_before_all(pushes, t) ? ", before the push" : "");
}

}  // namespace saltus::robots::walking
