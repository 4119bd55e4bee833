#include "saltus/robots/whole_body/stance_foot.hpp"

#include <algorithm>

namespace saltus::robots {

void StanceFoot::stand(const Eigen::Isometry3d& pose) {
  place_ = pose;
  depth_ = 0.0;
}

// Rotation vector from the pose to the place, world axes, rad.
Vec<double, 3> StanceFoot::angle_to(const Eigen::Isometry3d& pose) const {
  const Eigen::AngleAxisd turn(place_.linear() * pose.linear().transpose());
  return turn.angle() * turn.axis();
}

void StanceFoot::advance(double dt, const DynamicsModel::SoleMotion& sole, double force) {
  Vec<double, 3> error = place_.translation() - sole.pose.translation();
  Vec<double, 3> angle = angle_to(sole.pose);
  double kept = 1.0;  // share of the error that remains
  if (force > options_.loaded) {
    depth_ = 0.0;
    kept = std::max(0.0, 1.0 - dt / options_.follow);
  } else {
    depth_ = std::min(options_.search_depth, depth_ + options_.search_speed * dt);
  }
  const auto limited = [&kept](const Vec<double, 3>& vector, double most) {
    const double norm = vector.norm();
    return (norm > most ? std::min(kept, most / norm) : kept) * vector;
  };
  error = limited(error, options_.most_distance);
  angle = limited(angle, options_.most_angle);
  place_.translation() = sole.pose.translation() + error;
  const double norm = angle.norm();
  place_.linear() =
      norm > 0.0 ? Mat<double, 3, 3>(Eigen::AngleAxisd(norm, angle / norm) * sole.pose.linear())
                 : sole.pose.linear();
}

Vec<double, 6> StanceFoot::acceleration(const DynamicsModel::SoleMotion& sole) const {
  Vec<double, 6> result;
  result.head<3>() = options_.stiffness * angle_to(sole.pose);
  result.tail<3>() = options_.stiffness * (place_.translation() - sole.pose.translation());
  result[5] -= options_.stiffness * depth_;
  return result;
}

}  // namespace saltus::robots
