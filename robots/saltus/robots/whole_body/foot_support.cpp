#include "saltus/robots/whole_body/foot_support.hpp"

#include <algorithm>
#include <cmath>

namespace saltus::robots {
namespace {

// Smallest length of the area along an axis, m.
constexpr double smallest = 0.01;

// Largest tilt of a sole that seeks the ground, rad: the length of a sole on a step of 2 cm.
constexpr double most_seeking_tilt = 0.25;

// m s; a smaller integral is the end of an observation.
constexpr double forgotten = 1e-6;

// (forward, left), m.
Vec<double, 2> pressure_of(const FootSupport::Wrench& wrench) {
  return {-wrench[4] / wrench[2], wrench[3] / wrench[2]};
}

Vec<double, 2> middle_of(const FootRectangle& sole) {
  return 0.5 * Vec<double, 2>(sole.x.lower + sole.x.upper, sole.y.lower + sole.y.upper);
}

// Share of a first-order filter in a step of dt.
double share_of(double dt, double time) { return std::min(1.0, dt / time); }

}  // namespace

FootSupport::FootSupport(const FootRectangle& sole, double weight,
                         const FootSupportOptions& options)
    : sole_(sole), area_(sole), weight_(weight), options_(options) {}

void FootSupport::stand(double load, bool seeks) {
  area_ = sole_;
  seeks_ = seeks;
  down_.setZero();
  missed_.setZero();
  late_.setZero();
  turning_.setZero();
  measured_.setZero();
  measured_[2] = load;
  commanded_.setZero();
  has_carried_ = has_carried(load);
  sunk_ = 0.0;
  softness_ = 0.0;
}

double FootSupport::most_load() const {
  if (!options_.is_estimated || has_carried_) return infinity;
  return options_.more_load * std::max(0.0, measured_[2]) + options_.first_load * weight_;
}

void FootSupport::advance(double dt, const DynamicsModel::SoleMotion& sole, const Wrench& measured,
                          const Wrench& commanded) {
  if (!options_.is_estimated) return;
  const double share = share_of(dt, options_.lag);
  measured_ += share * (measured - measured_);
  commanded_ += share * (commanded - commanded_);
  turning_.setZero();
  const bool takes_load = !has_carried_;
  if (takes_load) find_softness(dt, sole);
  if (takes_load || is_soft())
    turning_[5] = options_.sink_relief * options_.damping * std::min(0.0, sole.twist[5]);
  const double least = options_.loaded * weight_;
  const bool is_commanded = commanded_[2] >= least;
  if (measured_[2] < (seeks_ ? options_.touched : 1.0) * least || !(seeks_ || is_commanded)) return;

  const Vec<double, 2> pressure = pressure_of(measured_),
                       wanted = is_commanded ? pressure_of(commanded_) : middle_of(sole_);
  const Vec<double, 3> turn = sole.pose.linear().transpose() * sole.twist.head<3>();
  const bool rests = (wanted - pressure).cwiseAbs().maxCoeff() < options_.apart;
  if (rests && has_carried(std::min(measured_[2], commanded_[2]))) seeks_ = false;
  down_ *= 1.0 - share_of(dt, rests ? options_.settle : options_.forget);
  down_ += dt * Vec<double, 2>(turn[1], -turn[0]);
  if (is_soft()) find_firmness(dt, pressure);
  if (!is_soft()) update_area(pressure, wanted, dt, rests);
  const Vec<double, 3> normal = sole.pose.linear().col(2);
  const double most = seeks_ ? most_seeking_tilt : options_.most_tilt;
  for (const int axis : {0, 1}) {
    const Bounds& whole = axis == 0 ? sole_.x : sole_.y;
    const double at = std::clamp(pressure[axis], whole.lower, whole.upper);
    const Vec<double, 3> about = sole.pose.linear().col(1 - axis);
    const Vec<double, 3> acceleration = flattening_about(axis, at, wanted[axis], dt) * about;
    // It must not increase a large tilt.
    if (normal[2] > std::cos(most) || acceleration.cross(normal)[2] > 0.0)
      turning_.head<3>() += acceleration;
  }
  const Vec<double, 3> touched = sole.pose.linear() * Vec<double, 3>(pressure[0], pressure[1], 0.0);
  turning_.tail<3>() += touched.cross(turning_.head<3>());
  if (is_soft()) turning_.head<3>() += soft_turning(sole);
}

// Angular acceleration of a sole on soft ground, without the damping by the whole-body controller.
// The moment of the ground changes as the sole turns, so the sole turns until its centre of
// pressure is the commanded one.
Vec<double, 3> FootSupport::soft_turning(const DynamicsModel::SoleMotion& sole) const {
  const Mat<double, 3, 3> axes = sole.pose.linear();
  const Vec<double, 3> turn = axes.transpose() * sole.twist.head<3>();
  Vec<double, 3> result = Vec<double, 3>::Zero();
  for (const int axis : {0, 1}) {
    const Bounds& across = axis == 0 ? sole_.y : sole_.x;
    const double width = across.upper - across.lower;
    const double stiffness = width * width / (12.0 * softness_);  // of a pad of springs, Nm/rad
    const double missing = measured_[3 + axis] - commanded_[3 + axis];
    const double rate = std::clamp(missing / (stiffness * options_.soft_time), -options_.soft_rate,
                                   options_.soft_rate);
    result[axis] = options_.soft_damping * (rate - turn[axis]) + options_.damping * turn[axis];
  }
  return axes * result;
}

// Finds out whether the ground is soft, until the foot has carried load. The point below the centre
// of pressure touches the ground, so on rigid ground it does not move, even if the sole turns.
void FootSupport::find_softness(double dt, const DynamicsModel::SoleMotion& sole) {
  const double load = std::max(measured_[2], options_.loaded * weight_);
  const Vec<double, 3> pressure(-measured_[4] / load, measured_[3] / load, 0.0);
  const Vec<double, 3> touched = sole.pose.linear() * pressure;
  const Vec<double, 3> velocity = sole.twist.tail<3>() + sole.twist.head<3>().cross(touched);
  sunk_ -= dt * velocity.dot(sole.pose.linear().col(2));
  has_carried_ = has_carried(measured_[2]);
  if (!has_carried_ || sunk_ * weight_ < options_.soft * measured_[2]) return;
  softness_ = sunk_ / measured_[2];
  beyond_ = 0.0;
  const auto middle = [this](const Bounds& whole) {
    const double centre = 0.5 * (whole.lower + whole.upper);
    const double half = 0.5 * options_.soft_part * (whole.upper - whole.lower);
    return between(centre - half, centre + half);
  };
  area_ = {middle(sole_.x), middle(sole_.y)};
}

// Finds out whether a ground that was taken for soft is rigid. On soft ground a sole would have to
// turn far to bring its centre of pressure out of the middle.
void FootSupport::find_firmness(double dt, const Vec<double, 2>& pressure) {
  const double beyond = std::max({area_.x.lower - pressure[0], pressure[0] - area_.x.upper,
                                  area_.y.lower - pressure[1], pressure[1] - area_.y.upper});
  if (!persists(beyond_, beyond - options_.apart, dt)) return;
  softness_ = 0.0;
  area_ = sole_;
}

// Area of support from the centres of pressure, measured and commanded.
void FootSupport::update_area(const Vec<double, 2>& pressure, const Vec<double, 2>& wanted,
                              double dt, bool rests) {
  const double more = rests ? options_.regain * dt : 0.0;
  for (const int axis : {0, 1}) {
    Bounds& area = axis == 0 ? area_.x : area_.y;
    const Bounds& whole = axis == 0 ? sole_.x : sole_.y;
    const double at = std::clamp(pressure[axis], whole.lower, whole.upper);
    area.lower = std::max(whole.lower, std::min(area.lower - more, at));
    area.upper = std::min(whole.upper, std::max(area.upper + more, at));
    end_area(axis, at, wanted[axis], dt);
  }
}

// Error of the measured centre of pressure, m. It is large if the load is small.
double FootSupport::inaccuracy() const { return options_.moment_error / measured_[2]; }

double FootSupport::rim_width() const { return options_.on_edge + inaccuracy(); }

// Integrates an excess over time, or forgets it when it is negative. True if the integral shows
// that the excess lasts.
bool FootSupport::persists(double& integral, double excess, double dt) const {
  if (excess > 0.0)
    integral += excess * dt;
  else
    integral *= 1.0 - share_of(dt, options_.lag);
  return integral >= options_.missed;
}

// Acceleration about the sole's other axis, once the centre of pressure has stayed on the rim, or
// anywhere else off the commanded one while the sole seeks the ground.
double FootSupport::flattening_about(int axis, double pressure, double wanted, double dt) {
  const Bounds& whole = axis == 0 ? sole_.x : sole_.y;
  double acceleration = 0.0;
  for (const int end : {0, 1}) {
    const double outwards = end == 0 ? -1.0 : 1.0;
    const double rim = end == 0 ? whole.lower : whole.upper;
    const bool is_on_rim = seeks_ || outwards * (rim - pressure) < rim_width();
    const double inside =
        outwards * (pressure - wanted) - options_.apart - (seeks_ ? inaccuracy() : 0.0);
    // A turn towards the inside: a lower toe is a positive one, a lower left edge a negative one.
    if (persists(late_(axis, end), is_on_rim ? inside : 0.0, dt))
      acceleration = (axis == 0 ? -outwards : outwards) * options_.flattening;
  }
  return acceleration;
}

// Ends the area at the centre of pressure if the sole has turned over an edge there. A sole that
// was just now on its rim has found no edge: it turns until it is flat.
void FootSupport::end_area(int axis, double pressure, double wanted, double dt) {
  Bounds& area = axis == 0 ? area_.x : area_.y;
  const Bounds& whole = axis == 0 ? sole_.x : sole_.y;
  const double width = rim_width();
  const bool is_inside = pressure > whole.lower + width && pressure < whole.upper - width &&
                         late_.row(axis).maxCoeff() < forgotten;
  for (const int end : {0, 1}) {
    const double outwards = end == 0 ? -1.0 : 1.0;
    const bool has_turned = outwards * down_[axis] > options_.tilted;
    const double beyond = outwards * (wanted - pressure) - options_.apart;
    double &missed = missed_(axis, end), &outermost = outermost_(axis, end);
    if (missed < forgotten || outwards * (pressure - outermost) > 0.0) outermost = pressure;
    if (!persists(missed, is_inside && has_turned ? beyond : 0.0, dt)) continue;
    if (end == 0)
      area.lower = std::min(std::max(area.lower, outermost), area.upper - smallest);
    else
      area.upper = std::max(std::min(area.upper, outermost), area.lower + smallest);
  }
}

}  // namespace saltus::robots
