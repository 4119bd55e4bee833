#include "saltus/robots/whole_body/sensor_estimator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/robots/whole_body/rotation_vector.hpp"
#include "saltus/robots/whole_body/sample_period.hpp"

namespace saltus::robots {
namespace {

// Time after the start in which the pin is known to stand, s: at least the time in which the
// contact force builds up, before the first reading.
constexpr double least_certain_stand = 0.05;

// A sole rests if its centre of pressure is at least this far from its edges, m. The value exceeds
// the error due to biases of the force sensors.
constexpr double off_the_edge = 0.005;

// Contact area less that margin, bounded by the lowest corners of the foot's boxes in any
// orientation.
FootRectangle resting_area(const FloatingRobot& robot, const FloatingRobot::Frame& sole) {
  constexpr double as_low = 1e-4;  // m
  std::vector<Vec<double, 3>> corners;
  double lowest = infinity;
  for (const UrdfModel::Box& box : robot.bodies[static_cast<std::size_t>(sole.body)].boxes)
    for (int corner = 0; corner < 8; ++corner) {
      const Vec<double, 3> half(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5,
                                corner & 4 ? 0.5 : -0.5);
      corners.emplace_back(sole.pose.inverse() *
                           (box.pose * Vec<double, 3>(half.cwiseProduct(box.size))));
      lowest = std::min(lowest, corners.back().z());
    }
  FootRectangle area{{infinity, -infinity}, {infinity, -infinity}};
  for (const Vec<double, 3>& corner : corners) {
    if (corner.z() > lowest + as_low) continue;
    area.x = {std::min(area.x.lower, corner.x() + off_the_edge),
              std::max(area.x.upper, corner.x() - off_the_edge)};
    area.y = {std::min(area.y.lower, corner.y() + off_the_edge),
              std::max(area.y.upper, corner.y() - off_the_edge)};
  }
  return area;
}

bool presses_within(const FootRectangle& area, const Vec<double, 6>& wrench) {
  const double x = -wrench[4] / wrench[2], y = wrench[3] / wrench[2];
  return x > area.x.lower && x < area.x.upper && y > area.y.lower && y < area.y.upper;
}

BaseEstimatorOptions estimator_options(const SensorOptions& sensors,
                                       const Estimator::Options& options) {
  BaseEstimatorOptions o;
  o.gyroscope_noise = std::max(o.gyroscope_noise, sensors.gyroscope.noise);
  o.accelerometer_noise = std::max(o.accelerometer_noise, sensors.accelerometer.noise);
  o.gyroscope_bias = std::max(o.gyroscope_bias, sensors.gyroscope.bias);
  o.accelerometer_bias = std::max(o.accelerometer_bias, sensors.accelerometer.bias);
  o.turn = std::max(o.turn, options.initial_tilt);
  o.rocking_walk = options.rocking_walk;
  return o;
}

}  // namespace

void IdealEstimator::update(const Robot::Readings& readings) {
  if (!readings.ideal)
    throw DefinitionError(
        "the ideal estimator needs the readings of ideal sensors, but there are none");
  estimate_ = *readings.ideal;
}

SensorEstimator::SensorEstimator(const FloatingRobot& robot, Side pin, const SensorOptions& sensors,
                                 const Estimator::Options& options, double period)
    : period_(period),
      certain_stand_(std::max(least_certain_stand, 1.0 / sensors.force_torque.rate +
                                                       sensors.force_torque.delay + period)),
      first_pin_(pin),
      pin_(pin),
      options_(options),
      leg_variance_(sensors.encoder.noise * sensors.encoder.noise +
                    sensors.encoder.resolution * sensors.encoder.resolution / 12.0),
      seed_(static_cast<std::uint64_t>(sensors.seed)),
      soles_{{robot, Side::left}, {robot, Side::right}},
      resting_{resting_area(robot, robot.left_sole), resting_area(robot, robot.right_sole)},
      velocities_(robot.joints(), sample_period(sensors.encoder.rate, period),
                  options.velocity_lag),
      base_(estimator_options(sensors, options)) {
  for (const auto& [name, value] : {std::pair{"lag of the velocities", options.velocity_lag},
                                    std::pair{"standing force", options.standing_force},
                                    std::pair{"initial tilt", options.initial_tilt},
                                    std::pair{"walk of a rocking foot", options.rocking_walk}})
    if (!(value >= 0.0) || !std::isfinite(value))
      throw DefinitionError(fmt::format(
          "estimator: the {} is {}, expected a finite number of at least 0", name, value));
}

void SensorEstimator::start(const WholeBodyState& state, const Robot::Readings& readings) {
  start_time_ = time_ = readings.time;
  velocities_.reset(readings.q);
  pin_ = first_pin_;
  const int pin = pin_ == Side::left ? 0 : 1;
  // The posture defines the position of the pin. Roll and pitch of the base are uncertain.
  soles_[pin].update(state.q);
  const Eigen::Isometry3d stand = state.base * soles_[pin].pose();
  Random random(seed_);
  // half width of a uniform distribution
  const double widest = std::sqrt(3.0) * options_.initial_tilt;
  Vec<double, 3> tilt(random.uniform(-widest, widest), random.uniform(-widest, widest), 0.0);
  Eigen::Isometry3d base = state.base;
  base.linear() = exp_so3(tilt) * base.linear();
  read_soles(readings);
  base.translation() = stand.translation() - base.linear() * soles_read_[pin].pose.translation();
  base_.reset(base, pin_, stand);
  soles_read_[pin].stands = true;
  soles_read_[1 - pin].stands = false;
  estimate_.state = state;
  publish(readings);
}

void SensorEstimator::update(const Robot::Readings& r) {
  if (r.time <= time_) return;
  time_ = r.time;
  base_.predict(r.angular_velocity, r.specific_force, period_);
  if (r.has_new_positions) {
    velocities_.update(r.q);
    read_soles(r);
    for (const Side side : {Side::left, Side::right}) {
      SoleReading& sole = soles_read_[side == Side::left ? 0 : 1];
      const Vec<double, 6>& wrench = side == Side::left ? r.left : r.right;
      sole.stands = wrench[2] > (sole.stands ? 0.5 : 1.0) * options_.standing_force;
      sole.rests = sole.stands && presses_within(resting_[side == Side::left ? 0 : 1], wrench);
      if (side == pin_ && time_ - start_time_ < certain_stand_) sole.stands = true;
      base_.correct(side, sole);
    }
  }
  publish(r);
}

void SensorEstimator::pin(Side foot) {
  pin_ = foot;
  base_.pin(foot);
}

void SensorEstimator::read_soles(const Robot::Readings& readings) {
  for (int i = 0; i < 2; ++i) {
    soles_[i].update(readings.q);
    soles_read_[i].pose = soles_[i].pose();
    soles_read_[i].covariance.noalias() =
        leg_variance_ * soles_[i].jacobian() * soles_[i].jacobian().transpose();
  }
}

void SensorEstimator::publish(const Robot::Readings& r) {
  const ContactInertialState& s = base_.state();
  WholeBodyState& state = estimate_.state;
  state.base = s.base();
  state.base_twist << s.R * (r.angular_velocity - s.b_gyroscope), s.v;
  state.q = r.q;
  state.dq = velocities_.velocity();
  for (int i = 0; i < 2; ++i) {
    WholeBodyEstimate::Contact& contact = i == 0 ? estimate_.left : estimate_.right;
    const Vec<double, 6>& wrench = i == 0 ? r.left : r.right;
    const Mat<double, 3, 3> R = s.R * soles_read_[i].pose.linear();
    contact.touches = soles_read_[i].stands;
    contact.wrench << R * wrench.head<3>(), R * wrench.tail<3>();
  }
}

std::unique_ptr<Estimator> make_ideal_estimator() { return std::make_unique<IdealEstimator>(); }

std::unique_ptr<Estimator> make_sensor_estimator(const FloatingRobot& robot, Side pin,
                                                 const SensorOptions& sensors,
                                                 const Estimator::Options& options, double period) {
  return std::make_unique<SensorEstimator>(robot, pin, sensors, options, period);
}

}  // namespace saltus::robots
