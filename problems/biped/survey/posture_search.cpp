#include "problems/biped/survey/posture_search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "saltus/robots/whole_body/clearance.hpp"
#include "saltus/robots/whole_body/rotation_vector.hpp"

namespace saltus::survey {
namespace {

// Weights of residuals in m and rad, from hard requirements to weak preferences.
constexpr double place_weight = 1e3, apart_weight = 100.0, upright_weight = 3.0,
                 height_weight = 10.0;
constexpr int nearest_pairs = 8;  // number of limb pairs that are kept apart
constexpr int errors_count = 11;

struct Range {
  double lower, upper;
};

class Search {
 public:
  Search(const robots::UrdfModel& model, const robots::RobotDescription& robot,
         const robots::FloatingRobot& body, const PostureWish& wish)
      : model_(model),
        wish_(wish),
        body_(body),
        limbs_(body, nearest_pairs),
        sole_(model.link_index(robot.sole(wish.stance))),
        other_(model.link_index(robot.sole(saltus::other(wish.stance)))),
        to_contact_(0.0, 0.0, robot.contact_plane_offset) {
    constexpr double margin = 0.02;     // rad, distance to the joint limits
    constexpr double full_turn = 3.14;  // range of joints without limits, rad
    for (int i = 0; i < body.joints(); ++i) {
      const Bounds& limits = driven(i).position;
      Range range{std::max(limits.lower + margin, -full_turn),
                  std::min(limits.upper - margin, full_turn)};
      if (range.lower > range.upper) range.lower = range.upper = 0.5 * (range.lower + range.upper);
      ranges_.push_back(range);
    }
    state_.dq = VectorXd::Zero(body.joints());
  }

  VectorXd clamped(VectorXd q) const {
    for (int i = 0; i < q.size(); ++i)
      q[i] = std::clamp(q[i], ranges_[static_cast<std::size_t>(i)].lower,
                        ranges_[static_cast<std::size_t>(i)].upper);
    return q;
  }

  robots::Posture posture(const VectorXd& q) const {
    robots::Posture posture;
    for (int i = 0; i < body_.joints(); ++i) posture[driven(i).joint] = q[i];
    return posture;
  }

  // The nearest pairs of limbs, nearest first.
  const robots::Clearance& limbs(const VectorXd& q) const {
    state_.q = q;
    limbs_.update(state_, wish_.clearance);
    return limbs_;
  }

  // Errors of the foot's place (3) and tilt (3), of the CoM (2), lean (2), height (1); m and rad.
  Vec<double, errors_count> errors(const VectorXd& q) const {
    const std::vector<Eigen::Isometry3d> poses = model_.link_poses(posture(q));
    Eigen::Isometry3d contact = poses[static_cast<std::size_t>(sole_)];
    contact.translate(to_contact_);
    const Eigen::Isometry3d to_world = contact.inverse();
    Eigen::Isometry3d foot = to_world * poses[static_cast<std::size_t>(other_)];
    foot.translate(to_contact_);
    Vec<double, 3> moment = Vec<double, 3>::Zero();
    for (std::size_t i = 0; i < poses.size(); ++i)
      moment += model_.links()[i].mass * (poses[i] * model_.links()[i].com);
    const Vec<double, 3> com = to_world * Vec<double, 3>(moment / model_.total_mass());
    Vec<double, errors_count> e;
    e << foot.translation() - wish_.other_foot, robots::log_so3(foot.linear()),
        com.head<2>() - wish_.com, robots::log_so3(to_world.linear()).head<2>(),
        to_world.translation().z() - wish_.trunk_height;
    return e;
  }

  VectorXd residual(const VectorXd& q, const VectorXd& rest) const {
    Vec<double, errors_count> weights;
    weights << Vec<double, 8>::Constant(place_weight), upright_weight, upright_weight,
        height_weight;
    Vec<double, nearest_pairs> apart = Vec<double, nearest_pairs>::Zero();
    const robots::Clearance& near = limbs(q);
    for (int i = 0; i < near.count(); ++i) apart[i] = wish_.clearance - near.approach(i).distance;
    VectorXd r(errors_count + nearest_pairs + q.size());
    r << weights.cwiseProduct(errors(q)), apart_weight * apart, wish_.rest_weight * (q - rest);
    return r;
  }

 private:
  // Body that joint i moves.
  const robots::FloatingRobot::Body& driven(int i) const {
    return body_.bodies[static_cast<std::size_t>(i) + 1];
  }

  const robots::UrdfModel& model_;
  const PostureWish& wish_;
  const robots::FloatingRobot& body_;
  mutable robots::Clearance limbs_;
  mutable robots::WholeBodyState state_;
  int sole_, other_;
  Vec<double, 3> to_contact_;
  std::vector<Range> ranges_;
};

}  // namespace

FoundPosture find_posture(const robots::UrdfModel& model, const robots::RobotDescription& robot,
                          const robots::FloatingRobot& body, const PostureWish& wish,
                          const robots::Posture& start) {
  const Search search(model, robot, body, wish);
  const int n = body.joints();
  VectorXd rest = VectorXd::Zero(n);
  for (const auto& [joint, position] : start) rest[body.joint_index(joint)] = position;
  rest = search.clamped(rest);

  // Levenberg-Marquardt method. Steps are clipped at the limits; joints held there do not move.
  VectorXd q = rest;
  VectorXd r = search.residual(q, rest);
  double damping = 1.0;
  constexpr int most_iterations = 300;
  constexpr double difference = 1e-6;  // rad, step of central differences
  constexpr double converged = 1e-10;  // rad
  constexpr double hopeless = 1e12;
  for (int k = 0; k < most_iterations && damping < hopeless; ++k) {
    MatrixXd J(r.size(), n);
    for (int i = 0; i < n; ++i) {
      VectorXd near = q;
      near[i] = q[i] + difference;
      J.col(i) = search.residual(near, rest);
      near[i] = q[i] - difference;
      J.col(i) = (J.col(i) - search.residual(near, rest)) / (2.0 * difference);
    }
    const VectorXd gradient = J.transpose() * r;
    const VectorXd free_end = search.clamped(q - 1e-3 * gradient.cwiseSign());
    for (int i = 0; i < n; ++i)
      if (free_end[i] == q[i]) J.col(i).setZero();  // at a limit, with the step directed outwards
    MatrixXd H = J.transpose() * J;
    const VectorXd diagonal = H.diagonal();
    double moved = 0.0;
    while (damping < hopeless) {
      H.diagonal() = diagonal.array() + damping;
      const VectorXd trial = search.clamped(q - H.ldlt().solve(J.transpose() * r));
      const VectorXd at_trial = search.residual(trial, rest);
      if (at_trial.squaredNorm() < r.squaredNorm()) {
        moved = (trial - q).lpNorm<Eigen::Infinity>();
        q = trial;
        r = at_trial;
        damping = std::max(1e-9, damping / 5.0);
        break;
      }
      damping *= 5.0;
    }
    if (moved < converged) break;
  }

  const Vec<double, errors_count> e = search.errors(q);
  FoundPosture found;
  found.joints = search.posture(q);
  found.foot_error = e.head<3>().norm();
  found.tilt = e.segment<3>(3).norm();
  found.com_error = e.segment<2>(6).norm();
  if (const robots::Clearance& near = search.limbs(q); near.count() > 0)
    found.clearance = near.approach(0).distance;
  return found;
}

}  // namespace saltus::survey
