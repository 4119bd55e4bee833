// Area and load with which the ground supports a standing foot.
#pragma once

#include "saltus/robots/whole_body/device_options.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Estimates from the measured wrench which part of a sole the ground supports, and how much load
/// the foot may be given. No plan knows whether a sole has landed on an edge or a slope.
///
/// If a sole turns over an edge, its centre of pressure stays at the edge while the commanded one
/// lies beyond. The area then ends there. It grows again as soon as the ground carries load
/// further out. A sole that touches only with its rim turns until it is flat. A foot that has just
/// landed may be given the load that it carries already, and a little more. If it sinks meanwhile,
/// the ground is soft, until its centre of pressure shows the contrary.
class FootSupport {
 public:
  /// Wrenches of the ground on the foot: (force N | torque Nm), axes of the sole.
  using Wrench = Vec<double, 6>;

  /// `sole`: the rectangle of the foot; `weight` of the robot, N.
  FootSupport(const FootRectangle& sole, double weight, const FootSupportOptions& options);

  /// Starts the estimate of a foot that stands on its whole sole and carries this load (N). The
  /// ground below a foot that `seeks` it is unknown: the sole turns until its centre of pressure is
  /// the commanded one, before any part of it counts as unsupported.
  void stand(double load, bool seeks = false);
  /// Advances by `dt` (s). `commanded` is the wrench that the controller expected.
  void advance(double dt, const DynamicsModel::SoleMotion& sole, const Wrench& measured,
               const Wrench& commanded);

  /// Part of the sole that is supported, in the sole frame.
  const FootRectangle& area() const { return area_; }
  /// Acceleration (angular | linear) of the contact frame, world axes, rad/s^2 and m/s^2. It turns
  /// a sole on its rim flat about the point where it touches the ground. On soft ground it turns
  /// the sole until the centre of pressure is the commanded one. A foot that takes load or stands
  /// on soft ground may sink: a part of the damping of its descent is compensated. Otherwise the
  /// acceleration is zero.
  const Vec<double, 6>& turning() const { return turning_; }
  /// Largest vertical force that the foot may be given, N; infinite once it has carried load.
  double most_load() const;

 private:
  void find_softness(double dt, const DynamicsModel::SoleMotion& sole);
  void find_firmness(double dt, const Vec<double, 2>& pressure);
  Vec<double, 3> soft_turning(const DynamicsModel::SoleMotion& sole) const;
  bool is_soft() const { return softness_ > 0.0; }
  void update_area(const Vec<double, 2>& pressure, const Vec<double, 2>& wanted, double dt,
                   bool rests);
  void end_area(int axis, double pressure, double wanted, double dt);
  double flattening_about(int axis, double pressure, double wanted, double dt);
  double inaccuracy() const;
  double rim_width() const;
  bool persists(double& integral, double excess, double dt) const;
  bool has_carried(double load) const { return load > options_.proven * weight_; }

  FootRectangle sole_, area_;
  double weight_;
  FootSupportOptions options_;
  bool has_carried_ = false;
  bool seeks_ = false;     // until the sole has found the ground
  double sunk_ = 0.0;      // of the centre of pressure since the landing, m
  double softness_ = 0.0;  // sinking of the whole sole per load, m/N; 0: the ground is rigid
  double beyond_ = 0.0;    // m s; the centre of pressure leaves the middle of soft ground
  Vec<double, 2> down_ = Vec<double, 2>::Zero();  // angles of front and left edge, rad
  Vec<double, 6> turning_ = Vec<double, 6>::Zero();
  // m s; axis by lower and upper end
  Mat<double, 2, 2> missed_ = Mat<double, 2, 2>::Zero(), late_ = Mat<double, 2, 2>::Zero();
  // Outermost centre of pressure while the commanded one is missed, m.
  Mat<double, 2, 2> outermost_ = Mat<double, 2, 2>::Zero();
  Wrench measured_ = Wrench::Zero(), commanded_ = Wrench::Zero();  // filtered
};

}  // namespace saltus::robots
