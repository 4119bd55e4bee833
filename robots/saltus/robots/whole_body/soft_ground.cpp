#include "saltus/robots/whole_body/soft_ground.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/ground.hpp"
#include "saltus/robots/whole_body/sole_kinematics.hpp"

namespace saltus::robots {
namespace {

using Vec3 = Vec<double, 3>;
using Mat3 = Mat<double, 3, 3>;

// A point of a sole, and its share of the sole's area.
struct SolePoint {
  Vec3 place;                   // in the contact frame, m
  double share;                 // those of the lowest points add up to 1
  Vec3 stretch = Vec3::Zero();  // of the spring along the surface, world axes, m
};

// A grid with the corners, on the face of each box that looks at the ground. Points at the border
// have a half or a quarter of the area of the others.
std::vector<SolePoint> sole_points(const FloatingRobot& robot, const FloatingRobot::Frame& sole) {
  constexpr double spacing = 0.02;  // m, at most
  std::vector<SolePoint> points;
  double total = 0.0, lowest = infinity;
  for (const UrdfModel::Box& box : robot.bodies[static_cast<std::size_t>(sole.body)].boxes) {
    const Eigen::Isometry3d pose = sole.pose.inverse() * box.pose;
    int down = 0;  // axis of the box
    pose.linear().row(2).cwiseAbs().maxCoeff(&down);
    const int first = (down + 1) % 3, second = (down + 2) % 3;
    const auto cells = [&box](int axis) {
      return std::max(1, static_cast<int>(std::ceil(box.size[axis] / spacing)));
    };
    const auto weight = [](int i, int count) { return i == 0 || i == count ? 0.5 : 1.0; };
    const int rows = cells(first), columns = cells(second);
    for (int i = 0; i <= rows; ++i)
      for (int j = 0; j <= columns; ++j) {
        Vec3 at;
        at[down] = pose(2, down) > 0.0 ? -0.5 : 0.5;
        at[first] = static_cast<double>(i) / rows - 0.5;
        at[second] = static_cast<double>(j) / columns - 0.5;
        const double area = box.size[first] * box.size[second] / (rows * columns) *
                            weight(i, rows) * weight(j, columns);
        points.push_back({pose * box.size.cwiseProduct(at), area});
        lowest = std::min(lowest, points.back().place[2]);
      }
  }
  for (const SolePoint& point : points)
    if (point.place[2] < lowest + 1e-3) total += point.share;
  for (SolePoint& point : points) point.share /= total;
  return points;
}

// Largest inverse mass (1/kg) with which the free foot yields to the springs of all its points. It
// bounds that of the foot on the robot.
double largest_mobility(const std::vector<SolePoint>& points, const FloatingRobot::Body& body,
                        const FloatingRobot::Frame& sole) {
  const Mat3 axes = sole.pose.linear();
  const auto jacobian = [](const Vec3& place) {  // of the velocity of a point, (angular | linear)
    Mat<double, 3, 6> J;
    J << skew<double>(-place), Mat3::Identity();
    return J;
  };
  const Mat<double, 3, 6> of_com = jacobian(sole.pose.inverse() * body.com);
  Mat<double, 6, 6> inertia = body.mass * of_com.transpose() * of_com;
  inertia.topLeftCorner<3, 3>() += axes.transpose() * body.inertia * axes;
  Mat<double, 6, 6> springs = Mat<double, 6, 6>::Zero();
  for (const SolePoint& point : points)
    springs += point.share * jacobian(point.place).transpose() * jacobian(point.place);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Mat<double, 6, 6>> solver(springs, inertia,
                                                                           Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[5];
}

class SoftGround final : public Plant {
 public:
  SoftGround(std::unique_ptr<Plant> engine, const FloatingRobot& robot,
             const Plant::Options& options)
      : engine_(std::move(engine)), step_(options.step) {
    for (const GroundBox& box : ground_boxes(options))
      if (box.is_soft) boxes_.push_back(box);
    near_.reserve(boxes_.size());
    const double weight = robot.total_mass * standard_gravity;
    stiffness_ = weight / options.ground.sink;
    // The symplectic Euler method is stable if stiffness step^2 + 2 damping step < 4 for mass 1.
    constexpr double stiffest = 1.0, most_damped = 1.0;
    const double critical = 2.0 * std::sqrt(stiffness_ * robot.total_mass);
    for (const Side side : {Side::left, Side::right}) {
      const FloatingRobot::Frame& sole = side == Side::left ? robot.left_sole : robot.right_sole;
      Foot foot{SoleKinematics(robot, side), sole, sole_points(robot, sole)};
      for (const SolePoint& point : foot.points)
        foot.radius = std::max(foot.radius, point.place.norm());
      const double mobility =
          largest_mobility(foot.points, robot.bodies[static_cast<std::size_t>(sole.body)], sole);
      if (stiffness_ * step_ * step_ * mobility > stiffest)
        throw InputError(fmt::format(
            "simulator.ground_sink_m = {} m is too stiff for steps of {} s; set it to 0 or at "
            "least {:.4f} m, or decrease simulator.step_s",
            options.ground.sink, step_, weight * step_ * step_ * mobility / stiffest));
      foot.damping = std::min(critical, most_damped / (step_ * mobility));
      feet_.push_back(std::move(foot));
    }
  }

  void reset(const WholeBodyState& state) override {
    engine_->reset(state);
    for (Foot& foot : feet_) {
      for (SolePoint& point : foot.points) point.stretch.setZero();
      foot.contact = {};
    }
  }
  void set_torques(const VectorXd& torques) override { engine_->set_torques(torques); }
  void set_rotor_inertias(const VectorXd& inertias) override {
    engine_->set_rotor_inertias(inertias);
  }
  void push(int body, const Vec3& force, const Vec3& point) override {
    engine_->push(body, force, point);
  }
  void step() override {
    for (Foot& foot : feet_) press(foot);
    engine_->step();
    for (const Side side : {Side::left, Side::right}) {
      WholeBodyEstimate::Contact& contact = feet_[index(side)].contact;
      contact.touches = contact.touches || engine_->contact(side).touches;
      contact.wrench += engine_->contact(side).wrench;
    }
  }

  double time() const override { return engine_->time(); }
  const WholeBodyState& state() const override { return engine_->state(); }
  const WholeBodyEstimate::Contact& contact(Side side) const override {
    return feet_[index(side)].contact;
  }
  std::string name() const override { return engine_->name() + ", soft ground"; }

 private:
  struct Foot {
    SoleKinematics kinematics;
    FloatingRobot::Frame sole;
    std::vector<SolePoint> points;
    double radius = 0.0;   // of the sole about its origin, m
    double damping = 0.0;  // of the whole sole, Ns/m
    WholeBodyEstimate::Contact contact = {};
  };
  static std::size_t index(Side side) { return side == Side::left ? 0 : 1; }

  // Height of a point above the upper face, and whether it is above or below that face.
  struct Above {
    double height;
    bool is_there;
  };
  static Above above(const GroundBox& box, const Vec3& point, double margin) {
    const Vec3 local = box.pose.linear().transpose() * (point - box.pose.translation());
    return {local[2] - 0.5 * box.size[2], std::abs(local[0]) <= 0.5 * box.size[0] + margin &&
                                              std::abs(local[1]) <= 0.5 * box.size[1] + margin};
  }

  // Applies the forces of the ground at the present state.
  void press(Foot& foot) {
    const WholeBodyState& now = engine_->state();
    foot.kinematics.update(now.q);
    const Mat3 base = now.base.linear();
    const Vec<double, 6> in_base = foot.kinematics.jacobian() * now.dq;
    const Eigen::Isometry3d pose = now.base * foot.kinematics.pose();
    const Vec3 origin = pose.translation();
    const Vec3 spin = now.base_twist.head<3>() + base * in_base.tail<3>();
    const Vec3 velocity = now.base_twist.tail<3>() + base * in_base.head<3>() +
                          now.base_twist.head<3>().cross(origin - now.base.translation());
    foot.contact = {};
    near_.clear();
    for (const GroundBox& box : boxes_) {
      const Above sole = above(box, origin, foot.radius);
      if (sole.is_there && sole.height < foot.radius) near_.push_back(&box);
    }
    for (SolePoint& point : foot.points) {
      const Vec3 arm = pose.linear() * point.place;
      const Vec3 force = force_at(point, origin + arm, velocity + spin.cross(arm), foot.damping);
      if (force.isZero(0.0)) continue;
      engine_->push(foot.sole.body, force, foot.sole.pose * point.place);
      foot.contact.touches = true;
      foot.contact.wrench.head<3>() += force;
      foot.contact.wrench.tail<3>() += arm.cross(force);
    }
  }

  Vec3 force_at(SolePoint& point, const Vec3& place, const Vec3& velocity, double sole_damping) {
    const double stiffness = point.share * stiffness_, damping = point.share * sole_damping;
    for (const GroundBox* box : near_) {
      const Above ground = above(*box, place, 0.0);
      if (!ground.is_there || ground.height >= 0.0) continue;
      const Vec3 normal = box->pose.linear().col(2);
      const double speed = normal.dot(velocity);
      const double pressure = std::max(0.0, -stiffness * ground.height - damping * speed);
      const Vec3 sliding = velocity - speed * normal;
      point.stretch += step_ * sliding;
      point.stretch -= normal.dot(point.stretch) * normal;
      Vec3 drag = -stiffness * point.stretch - damping * sliding;
      const double most = box->friction * pressure;
      if (drag.norm() > most) {
        drag *= most / drag.norm();
        point.stretch = -(drag + damping * sliding) / stiffness;
      }
      return pressure * normal + drag;
    }
    point.stretch.setZero();
    return Vec3::Zero();
  }

  std::unique_ptr<Plant> engine_;
  double step_, stiffness_ = 0.0;  // s; N/m of a whole sole
  std::vector<GroundBox> boxes_;
  std::vector<const GroundBox*> near_;  // those that the foot may touch
  std::vector<Foot> feet_;
};

}  // namespace

std::unique_ptr<Plant> make_soft_ground(std::unique_ptr<Plant> engine, const FloatingRobot& robot,
                                        const Plant::Options& options) {
  return std::make_unique<SoftGround>(std::move(engine), robot, options);
}

}  // namespace saltus::robots
