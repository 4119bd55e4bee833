// Kinematics and inverse dynamics of a robot with a floating base, as formulas over any scalar.
//
// A configuration is q = (position of the base, m | roll, pitch, yaw of the base, rad | joints,
// rad), in world axes with z up. Joints have the order of FloatingRobot::joint_index(). The
// rotation of the base is Rz(yaw) Ry(pitch) Rx(roll). These angles are singular at a pitch of 90
// degrees, which plans of walking robots do not reach. In return dq is the derivative of q, a
// solver's step is added to q, and no constraint keeps a quaternion at unit length.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>

#include "saltus/autodiff/math.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/types.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// The data of a FloatingRobot with `joints` moving joints, as formulas need them.
template <int joints>
struct KinematicTree {
  /// A rigid body. Its rotation in its parent's frame is constant + sine sin(q) + cosine cos(q).
  struct Body {
    int parent = -1;                              ///< index of the parent; -1 for the base
    Mat<double, 3, 3> constant, sine, cosine;     ///< parts of the rotation
    Vec<double, 3> origin;                        ///< origin in the parent's frame, m
    Vec<double, 3> axis;                          ///< axis of the joint, in the body's frame
    Vec<double, 3> com = Vec<double, 3>::Zero();  ///< centre of mass in the body's frame, m
    Mat<double, 3, 3> inertia;                    ///< about the CoM, in body axes, kg m^2
    double mass = 0.0;                            ///< kg
    double rotor_inertia = 0.0;                   ///< inertia of the joint's rotor, kg m^2
  };

  static constexpr int coordinates = 6 + joints;  ///< number of entries of q
  std::array<Body, joints + 1> bodies;            ///< the base first, parents before children
  double mass = 0.0;                              ///< mass of the whole robot, kg

  /// Throws DefinitionError unless the robot has this number of joints.
  explicit KinematicTree(const FloatingRobot& robot);
};

/// Position and orientation of a frame in the world.
template <class S>
struct PoseOf {
  Mat<S, 3, 3> rotation;  ///< axes of the frame -> world axes
  Vec<S, 3> position;     ///< origin, m
};

namespace detail {

// Written entry by entry without the zeros that the data of robots are full of, and compiled once
// for each scalar.

/// rotation * constant
template <class S>
[[gnu::noinline]] Vec<S, 3> turned_constant(const Mat<S, 3, 3>& rotation,
                                            const Vec<double, 3>& constant) {
  Vec<S, 3> y;
  for (int i = 0; i < 3; ++i) {
    S sum(0.0);
    for (int j = 0; j < 3; ++j)
      if (constant[j] != 0.0) sum += rotation(i, j) * constant[j];
    y[i] = sum;
  }
  return y;
}
/// rotation * v
template <class S>
[[gnu::noinline]] Vec<S, 3> turned(const Mat<S, 3, 3>& rotation, const Vec<S, 3>& v) {
  Vec<S, 3> y;
  for (int i = 0; i < 3; ++i)
    y[i] = rotation(i, 0) * v[0] + rotation(i, 1) * v[1] + rotation(i, 2) * v[2];
  return y;
}
/// rotation * inertia * rotation' * w
template <class S>
[[gnu::noinline]] Vec<S, 3> times_inertia(const Mat<S, 3, 3>& rotation,
                                          const Mat<double, 3, 3>& inertia, const Vec<S, 3>& w) {
  Vec<S, 3> in_body, product;
  for (int i = 0; i < 3; ++i)
    in_body[i] = rotation(0, i) * w[0] + rotation(1, i) * w[1] + rotation(2, i) * w[2];
  for (int i = 0; i < 3; ++i) {
    S sum(0.0);
    for (int j = 0; j < 3; ++j)
      if (inertia(i, j) != 0.0) sum += inertia(i, j) * in_body[j];
    product[i] = sum;
  }
  return turned<S>(rotation, product);
}

/// Rz(yaw) Ry(pitch) Rx(roll), and the rates of the angles to the angular velocity.
template <class S>
struct BaseRotation {
  Mat<S, 3, 3> rotation;            ///< axes of the base -> world axes
  Vec<S, 3> roll_axis, pitch_axis;  ///< world axes; the yaw axis is z

  template <class Q>
  explicit BaseRotation(const Q& q) {
    const S cr = cos(S(q[3])), sr = sin(S(q[3])), cp = cos(S(q[4])), sp = sin(S(q[4])),
            cy = cos(S(q[5])), sy = sin(S(q[5]));
    rotation(0, 0) = cy * cp, rotation(0, 1) = sp * (cy * sr) - sy * cr,
                rotation(0, 2) = sp * (cy * cr) + sy * sr;
    rotation(1, 0) = sy * cp, rotation(1, 1) = sp * (sy * sr) + cy * cr,
                rotation(1, 2) = sp * (sy * cr) - cy * sr;
    rotation(2, 0) = -sp, rotation(2, 1) = cp * sr, rotation(2, 2) = cp * cr;
    roll_axis = {rotation(0, 0), rotation(1, 0), rotation(2, 0)};
    pitch_axis = {-sy, cy, S(0.0)};
  }
  /// Angular velocity of the base for the rates dq.
  template <class V>
  Vec<S, 3> omega(const V& dq) const {
    return {roll_axis[0] * dq[3] + pitch_axis[0] * dq[4],
            roll_axis[1] * dq[3] + pitch_axis[1] * dq[4], roll_axis[2] * dq[3] + dq[5]};
  }
};

/// Matrix of a map that is linear in dq.
template <int joints, class Map>
Eigen::Matrix<double, 6, 6 + joints> columns(const Map& map) {
  Eigen::Matrix<double, 6, 6 + joints> matrix;
  for (int i = 0; i < 6 + joints; ++i) matrix.col(i) = map(Vec<double, 6 + joints>::Unit(i).eval());
  return matrix;
}

}  // namespace detail

/// Poses of all bodies at q and, if dq is given, their velocities, computed by the constructor.
/// Vectors have world axes.
template <int joints, class S>
class Kinematics {
 public:
  using Tree = KinematicTree<joints>;  ///< data of the robot

  /// Poses. `q` has `coordinates` entries, read by q[i].
  template <class Q>
  Kinematics(const Tree& tree, const Q& q) : tree_(tree), base_(q) {
    find_poses(q);
  }
  /// Poses and velocities, which velocity() and the functions below it need.
  template <class Q, class V>
  Kinematics(const Tree& tree, const Q& q, const V& dq) : Kinematics(tree, q) {
    find_velocities(dq);
  }

  /// Pose of a body.
  const PoseOf<S>& body(int i) const { return poses_[static_cast<std::size_t>(i)]; }
  /// Point of a body, given in the body's frame; m.
  Vec<S, 3> position(int i, const Vec<double, 3>& point) const {
    return body(i).position + arm(i, point);
  }
  /// Origin of a frame, m.
  Vec<S, 3> position(const FloatingRobot::Frame& frame) const {
    return position(frame.body, frame.pose.translation());
  }
  /// Axes of a frame.
  Mat<S, 3, 3> rotation(const FloatingRobot::Frame& frame) const {
    Mat<S, 3, 3> axes;
    for (int j = 0; j < 3; ++j)
      axes.col(j) = detail::turned_constant<S>(body(frame.body).rotation,
                                               Vec<double, 3>(frame.pose.linear().col(j)));
    return axes;
  }
  /// Centre of mass of the robot, m.
  Vec<S, 3> com() const {
    return mean([this](int i, const Vec<double, 3>& c) { return position(i, c); });
  }

  /// Velocity of a point of a body, given in the body's frame; m/s.
  Vec<S, 3> velocity(int i, const Vec<double, 3>& point) const {
    const auto k = static_cast<std::size_t>(i);
    return velocities_[k] + omegas_[k].cross(arm(i, point));
  }
  /// Velocity of the origin of a frame, m/s.
  Vec<S, 3> velocity(const FloatingRobot::Frame& frame) const {
    return velocity(frame.body, frame.pose.translation());
  }
  /// Angular velocity of a body, rad/s.
  const Vec<S, 3>& angular_velocity(int i) const { return omegas_[static_cast<std::size_t>(i)]; }
  /// Velocity of the centre of mass, m/s.
  Vec<S, 3> com_velocity() const {
    return mean([this](int i, const Vec<double, 3>& c) { return velocity(i, c); });
  }
  /// Angular momentum about the centre of mass, Nms.
  Vec<S, 3> angular_momentum() const;

  /// Point of a body minus the origin of the body, m.
  Vec<S, 3> arm(int i, const Vec<double, 3>& point) const {
    return detail::turned_constant<S>(body(i).rotation, point);
  }
  /// The rotation of the base.
  const detail::BaseRotation<S>& base() const { return base_; }

 private:
  /// Mean over the mass of a quantity of the bodies' centres of mass.
  template <class Quantity>
  Vec<S, 3> mean(const Quantity& quantity) const;
  template <class Q>
  void find_poses(const Q& q);
  template <class V>
  void find_velocities(const V& dq);

  const Tree& tree_;
  detail::BaseRotation<S> base_;
  std::array<PoseOf<S>, joints + 1> poses_;
  std::array<Vec<S, 3>, joints + 1> velocities_, omegas_;  // of the origins; of the bodies
};

/// A force and a torque on a frame.
template <class S>
struct WrenchAt {
  FloatingRobot::Frame frame;  ///< frame of the robot
  Vec<S, 3> force, torque;     ///< N; Nm about the origin of the frame; world axes
};

/// Inverse dynamics: force (N) and torque about its origin (Nm) that the base lacks, world axes,
/// then the joint torques, including those that turn the rotors (Nm). A motion is possible if the
/// first six entries are zero. `gravity` is 9.81 m/s^2 or so, `wrenches` act on the robot.
template <class S, int joints, class Q, class V, class A>
Vec<S, 6 + joints> inverse_dynamics(const KinematicTree<joints>& tree, const Q& q, const V& dq,
                                    const A& ddq, double gravity,
                                    std::span<const WrenchAt<S>> wrenches);

/// Jacobian of a frame's origin: (velocity, m/s | angular velocity, rad/s) = jacobian dq.
template <int joints>
Eigen::Matrix<double, 6, 6 + joints> frame_jacobian(const KinematicTree<joints>& tree,
                                                    const VectorXd& q,
                                                    const FloatingRobot::Frame& frame) {
  return detail::columns<joints>([&](const auto& dq) {
    const Kinematics<joints, double> at(tree, q, dq);
    Vec<double, 6> column;
    column << at.velocity(frame), at.angular_velocity(frame.body);
    return column;
  });
}

/// Centroidal momentum: (momentum, Ns | angular momentum about the CoM, Nms) = matrix dq.
template <int joints>
Eigen::Matrix<double, 6, 6 + joints> momentum_matrix(const KinematicTree<joints>& tree,
                                                     const VectorXd& q) {
  return detail::columns<joints>([&](const auto& dq) {
    const Kinematics<joints, double> at(tree, q, dq);
    Vec<double, 6> column;
    column << tree.mass * at.com_velocity(), at.angular_momentum();
    return column;
  });
}

// --- implementation ---------------------------------------------------------------------------

template <int joints>
KinematicTree<joints>::KinematicTree(const FloatingRobot& robot) : mass(robot.total_mass) {
  if (robot.joints() != joints)
    throw DefinitionError("the formulas are for a robot with " + std::to_string(joints) +
                          " joints, but " + robot.name + " has " + std::to_string(robot.joints()) +
                          ": list " + std::to_string(joints) + " joints in its robot file");
  const auto without_noise = [](Mat<double, 3, 3> m) {
    for (double& entry : m.reshaped())
      if (std::abs(entry) < 1e-15) entry = 0.0;
    return m;
  };
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const FloatingRobot::Body& from = robot.bodies[i];
    Body& to = bodies[i];
    const Mat<double, 3, 3> rotation = from.origin.linear();
    const Mat<double, 3, 3> K = skew<double>(from.axis);
    to.parent = from.parent;
    to.constant = without_noise(rotation * (Mat<double, 3, 3>::Identity() + K * K));
    to.sine = without_noise(rotation * K);
    to.cosine = without_noise(-(rotation * K * K));
    to.origin = from.origin.translation();
    to.axis = from.axis;
    to.com = from.com;
    to.inertia = from.inertia;
    to.mass = from.mass;
    to.rotor_inertia = i > 0 ? from.drive.rotor_inertia : 0.0;
  }
}

template <int joints, class S>
template <class Q>
void Kinematics<joints, S>::find_poses(const Q& q) {
  poses_[0].rotation = base_.rotation;
  for (int i = 0; i < 3; ++i) poses_[0].position[i] = S(q[i]);
  for (int k = 1; k <= joints; ++k) {
    const auto& body = tree_.bodies[static_cast<std::size_t>(k)];
    const PoseOf<S>& parent = poses_[static_cast<std::size_t>(body.parent)];
    PoseOf<S>& pose = poses_[static_cast<std::size_t>(k)];
    const S& angle = q[5 + k];
    const S s = sin(angle), c = cos(angle);
    for (int j = 0; j < 3; ++j) {
      // Column j of the rotation in the parent's frame.
      Vec<S, 3> column;
      bool is_zero[3];
      for (int l = 0; l < 3; ++l) {
        S entry(body.constant(l, j));
        if (body.sine(l, j) != 0.0) entry += body.sine(l, j) * s;
        if (body.cosine(l, j) != 0.0) entry += body.cosine(l, j) * c;
        column[l] = entry;
        is_zero[l] =
            body.constant(l, j) == 0.0 && body.sine(l, j) == 0.0 && body.cosine(l, j) == 0.0;
      }
      for (int i = 0; i < 3; ++i) {
        S sum(0.0);
        for (int l = 0; l < 3; ++l)
          if (!is_zero[l]) sum += parent.rotation(i, l) * column[l];
        pose.rotation(i, j) = sum;
      }
    }
    pose.position = position(body.parent, body.origin);
  }
}

template <int joints, class S>
template <class V>
void Kinematics<joints, S>::find_velocities(const V& dq) {
  for (int i = 0; i < 3; ++i) velocities_[0][i] = S(dq[i]);
  omegas_[0] = base_.omega(dq);
  for (int k = 1; k <= joints; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const auto& body = tree_.bodies[i];
    velocities_[i] = velocity(body.parent, body.origin);
    omegas_[i] = omegas_[static_cast<std::size_t>(body.parent)];
    const Vec<S, 3> axis = arm(k, body.axis);
    for (int j = 0; j < 3; ++j) omegas_[i][j] += axis[j] * dq[5 + k];
  }
}

template <int joints, class S>
template <class Quantity>
Vec<S, 3> Kinematics<joints, S>::mean(const Quantity& quantity) const {
  Vec<S, 3> sum(S(0.0), S(0.0), S(0.0));
  for (int i = 0; i <= joints; ++i) {
    const auto& of = tree_.bodies[static_cast<std::size_t>(i)];
    const Vec<S, 3> value = quantity(i, of.com);
    for (int j = 0; j < 3; ++j) sum[j] += of.mass / tree_.mass * value[j];
  }
  return sum;
}

template <int joints, class S>
Vec<S, 3> Kinematics<joints, S>::angular_momentum() const {
  const Vec<S, 3> c = com();
  Vec<S, 3> sum(S(0.0), S(0.0), S(0.0));
  for (int k = 0; k <= joints; ++k) {
    const auto& of = tree_.bodies[static_cast<std::size_t>(k)];
    const Vec<S, 3> r = position(k, of.com) - c;
    Vec<S, 3> p = velocity(k, of.com);
    for (int j = 0; j < 3; ++j) p[j] *= of.mass;
    sum += r.cross(p);
    sum += detail::times_inertia<S>(body(k).rotation, of.inertia, angular_velocity(k));
  }
  return sum;
}

template <class S, int joints, class Q, class V, class A>
Vec<S, 6 + joints> inverse_dynamics(const KinematicTree<joints>& tree, const Q& q, const V& dq,
                                    const A& ddq, double gravity,
                                    std::span<const WrenchAt<S>> wrenches) {
  const Kinematics<joints, S> at(tree, q, dq);
  // Accelerations of the origins, with gravity as an upward acceleration of the world.
  std::array<Vec<S, 3>, joints + 1> acceleration, alpha, force, torque;
  {
    const detail::BaseRotation<S>& base = at.base();
    for (int i = 0; i < 3; ++i) acceleration[0][i] = S(ddq[i]);
    acceleration[0][2] += gravity;
    // The roll axis turns with pitch and yaw, the pitch axis with yaw.
    const Vec<S, 3> pitch_yaw(base.pitch_axis[0] * dq[4], base.pitch_axis[1] * dq[4], S(dq[5]));
    const Vec<S, 3> roll_moves = pitch_yaw.cross(base.roll_axis);
    alpha[0] = base.omega(ddq);
    for (int i = 0; i < 3; ++i) alpha[0][i] += roll_moves[i] * dq[3];
    alpha[0][0] -= base.pitch_axis[1] * dq[5] * dq[4];
    alpha[0][1] += base.pitch_axis[0] * dq[5] * dq[4];
  }
  const auto acceleration_of = [&](int k, const Vec<double, 3>& point) {
    const auto i = static_cast<std::size_t>(k);
    const Vec<S, 3> r = at.arm(k, point);
    const Vec<S, 3>& w = at.angular_velocity(k);
    return Vec<S, 3>(acceleration[i] + alpha[i].cross(r) + w.cross(w.cross(r)));
  };
  for (int k = 1; k <= joints; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const auto& body = tree.bodies[i];
    const auto parent = static_cast<std::size_t>(body.parent);
    acceleration[i] = acceleration_of(body.parent, body.origin);
    const Vec<S, 3> axis = at.arm(k, body.axis);
    const Vec<S, 3> turning = at.angular_velocity(body.parent).cross(axis);
    alpha[i] = alpha[parent];
    for (int j = 0; j < 3; ++j) alpha[i][j] += axis[j] * ddq[5 + k] + turning[j] * dq[5 + k];
  }
  // Force and torque about the origin that each body needs, then those of its subtree.
  for (int k = 0; k <= joints; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const auto& body = tree.bodies[i];
    force[i] = acceleration_of(k, body.com);
    for (int j = 0; j < 3; ++j) force[i][j] *= body.mass;
    const Mat<S, 3, 3>& rotation = at.body(k).rotation;
    const Vec<S, 3>& w = at.angular_velocity(k);
    torque[i] = detail::times_inertia<S>(rotation, body.inertia, alpha[i]);
    torque[i] += w.cross(detail::times_inertia<S>(rotation, body.inertia, w));
    torque[i] += at.arm(k, body.com).cross(force[i]);
  }
  for (const WrenchAt<S>& wrench : wrenches) {
    const auto i = static_cast<std::size_t>(wrench.frame.body);
    const Vec<S, 3> moment =
        at.arm(wrench.frame.body, wrench.frame.pose.translation()).cross(wrench.force);
    force[i] -= wrench.force;
    torque[i] -= wrench.torque + moment;
  }
  Vec<S, 6 + joints> y;
  for (int k = joints; k > 0; --k) {
    const auto i = static_cast<std::size_t>(k);
    const auto& body = tree.bodies[i];
    const auto parent = static_cast<std::size_t>(body.parent);
    const Vec<S, 3> axis = at.arm(k, body.axis);
    y[5 + k] = axis[0] * torque[i][0] + axis[1] * torque[i][1] + axis[2] * torque[i][2];
    if (body.rotor_inertia != 0.0) y[5 + k] += body.rotor_inertia * ddq[5 + k];
    force[parent] += force[i];
    torque[parent] += torque[i];
    torque[parent] += at.arm(body.parent, body.origin).cross(force[i]);
  }
  for (int j = 0; j < 3; ++j) {
    y[j] = force[0][j];
    y[3 + j] = torque[0][j];
  }
  return y;
}

}  // namespace saltus::robots
