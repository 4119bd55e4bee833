#include <algorithm>
#include <cmath>

#include "problems/whole_body/tasks.hpp"
#include "saltus/robots/whole_body/rotation_vector.hpp"

namespace saltus::whole_body {
namespace {

constexpr double margin = 0.02;  // kept from the limits of joints, rad

const robots::Capsule& longest(const robots::FloatingRobot::Body& body,
                               const robots::FloatingRobot& robot) {
  if (body.capsules.empty())
    throw InputError("the link " + body.name + " of " + robot.name +
                     " has no capsules: list them in the robot file");
  return std::ranges::max_element(
             body.capsules, {},
             [](const auto& c) { return c.capsule.length() + 2.0 * c.capsule.radius; })
      ->capsule;
}

// Spheres inside the capsules of foot and shank.
std::vector<Body::Sphere> spheres(const robots::FloatingRobot& robot, const Frame& sole) {
  const auto body = [&](int i) -> const robots::FloatingRobot::Body& {
    return robot.bodies[static_cast<std::size_t>(i)];
  };
  const int foot = sole.body, shank = body(body(foot).parent).parent;
  std::vector<Body::Sphere> all;
  const auto add = [&](int i, std::initializer_list<double> fractions) {
    const robots::Capsule& capsule = longest(body(i), robot);
    for (const double f : fractions)
      all.push_back({i, (1.0 - f) * capsule.from + f * capsule.to, capsule.radius});
  };
  all.reserve(5);
  add(foot, {0.0, 1.0});
  add(shank, {0.0, 0.5, 1.0});
  return all;
}

// The first posture on both feet.
const robots::StandingPosture& standing(const robots::RobotDescription& description) {
  for (const robots::StandingPosture& posture : description.postures)
    if (posture.stance == robots::Stance::both) return posture;
  throw InputError(description.file + " has no posture on both feet: add one to `postures`");
}

}  // namespace

Body::Body(const robots::FloatingRobot& robot, const robots::RobotDescription& description)
    : tree(robot),
      soles{robot.left_sole, robot.right_sole},
      feet{description.left_foot, description.right_foot},
      lowest(joints),
      highest(joints),
      fastest(joints),
      strongest(joints),
      nominal(robot.joint_positions(standing(description).joints)),
      legs{spheres(robot, robot.left_sole), spheres(robot, robot.right_sole)} {
  for (int i = 0; i < joints; ++i) {
    const robots::FloatingRobot::Body& body = robot.bodies[static_cast<std::size_t>(i) + 1];
    lowest[i] = body.position.lower + margin;
    highest[i] = body.position.upper - margin;
    fastest[i] = body.velocity;
    strongest[i] = body.effort;
  }
}

VectorXd posture_on(const Body& body, const robots::SoleFrame places[2], const Vec<double, 2>& com,
                    const VectorXd& near) {
  // Least squares of the places (m, rad), the centre of mass and the distance from the nominal
  // posture, whose weight vanishes, by damped steps of Gauss and Newton.
  constexpr int rows = 12 + 2 + 2 + joints;
  constexpr double step_limit = 0.2, upright_weight = 5.0;
  double posture_weight = 0.02;
  VectorXd q = near;
  for (int iteration = 0; iteration < 60; ++iteration) {
    const robots::Kinematics<joints, double> robot(body.tree, q);
    Eigen::Matrix<double, rows, coordinates> J;
    Vec<double, rows> r;
    J.setZero();
    for (int side = 0; side < 2; ++side) {
      const Frame& sole = body.soles[side];
      const Mat<double, 3, 3> axes = robot.rotation(sole);
      r.segment<3>(6 * side) = robot.position(sole) - places[side].position;
      r.segment<3>(6 * side + 3) = robots::log_so3(axes * places[side].rotation.transpose());
      J.middleRows<6>(6 * side) = robots::frame_jacobian(body.tree, q, sole);
    }
    r.segment<2>(12) = robot.com().head<2>() - com;
    J.middleRows<2>(12) = robots::momentum_matrix(body.tree, q).topRows<2>() / body.tree.mass;
    r.segment<2>(14) = upright_weight * posture_weight * q.segment<2>(3);
    J.block<2, 2>(14, 3).diagonal().setConstant(upright_weight * posture_weight);
    r.tail<joints>() = posture_weight * (q.tail<joints>() - body.nominal);
    J.bottomRightCorner<joints, joints>().diagonal().setConstant(posture_weight);
    MatrixXd H = J.transpose() * J;
    H.diagonal().array() += 1e-6;
    VectorXd step = -H.ldlt().solve(J.transpose() * r);
    step *= std::min(1.0, step_limit / (1e-12 + step.lpNorm<Eigen::Infinity>()));
    q += step;
    if (iteration >= 20) posture_weight *= 0.7;
    for (int i = 0; i < joints; ++i)
      q[6 + i] = std::clamp(q[6 + i], body.lowest[i], body.highest[i]);
  }
  return q;
}

}  // namespace saltus::whole_body
