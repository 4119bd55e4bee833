#include "saltus/robots/whole_body/estimated_plant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

// Before the first force is read the pin is known to stand, s: at least the time for the contact to
// build up.
constexpr double least_certain_stand = 0.05;

// A sole rests when its centre of pressure is so far from its edges, m: beyond what the biases of
// the force sensors make of it.
constexpr double off_the_edge = 0.005;

// What touches the ground, less that: between the lowest corners of the foot's boxes, however they
// are turned.
FootRectangle resting_area(const FloatingRobot& robot, const FloatingRobot::Frame& sole) {
  constexpr double as_low = 1e-4;  // m
  std::vector<Vec<double, 3>> corners;
  double lowest = infinity;
  for (const UrdfBox& box : robot.bodies[static_cast<std::size_t>(sole.body)].boxes)
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
                                       const EstimationOptions& options) {
  BaseEstimatorOptions o;
  o.gyroscope_noise = std::max(o.gyroscope_noise, sensors.gyroscope.noise);
  o.accelerometer_noise = std::max(o.accelerometer_noise, sensors.accelerometer.noise);
  o.gyroscope_bias = std::max(o.gyroscope_bias, sensors.gyroscope.bias);
  o.accelerometer_bias = std::max(o.accelerometer_bias, sensors.accelerometer.bias);
  o.turn = std::max(o.turn, options.initial_tilt);
  return o;
}

}  // namespace

EstimatedPlant::EstimatedPlant(std::unique_ptr<Plant> plant, const FloatingRobot& robot, Side pin,
                               const SensorOptions& sensors, const EstimationOptions& options,
                               double step)
    : PlantAround(std::move(plant)),
      step_(step),
      certain_stand_(std::max(least_certain_stand,
                              1.0 / sensors.force_torque.rate + sensors.force_torque.delay + step)),
      first_pin_(pin),
      pin_(pin),
      options_(options),
      sensors_(robot, sensors, step),
      leg_variance_(sensors.encoder.noise * sensors.encoder.noise +
                    sensors.encoder.resolution * sensors.encoder.resolution / 12.0),
      random_(0),
      seed_(static_cast<std::uint64_t>(sensors.seed)),
      soles_{{robot, Side::left}, {robot, Side::right}},
      resting_{resting_area(robot, robot.left_sole), resting_area(robot, robot.right_sole)},
      velocities_(robot.joints(), sensors_.encoder_period(), options.velocity_lag),
      base_(estimator_options(sensors, options)) {
  for (const auto& [name, value] : {std::pair{"lag of velocities", options.velocity_lag},
                                    std::pair{"force that tells standing", options.standing_force},
                                    std::pair{"first tilt", options.initial_tilt}})
    if (!(value >= 0.0) || !std::isfinite(value))
      throw DefinitionError(fmt::format(
          "the estimate's {} is {}, expected a finite number of at least 0", name, value));
  reset(plant_->state());
}

void EstimatedPlant::reset(const WholeBodyState& state) {
  plant_->reset(state);
  sensors_.reset(state);
  velocities_.reset(sensors_.readings().q);
  pin_ = first_pin_;
  const int pin = pin_ == Side::left ? 0 : 1;
  // The posture says where the pin stands; roll and pitch of the base are known badly.
  soles_[pin].update(state.q);
  const Eigen::Isometry3d stand = state.base * soles_[pin].pose();
  random_ = Random(seed_);
  const double widest = std::sqrt(3.0) * options_.initial_tilt;  // uniform
  Vec<double, 3> tilt(random_.uniform(-widest, widest), random_.uniform(-widest, widest), 0.0);
  Eigen::Isometry3d base = state.base;
  base.linear() = rotation_of_vector(tilt) * base.linear();
  read_soles();
  base.translation() = stand.translation() - base.linear() * readings_[pin].pose.translation();
  base_.reset(base, pin_, stand);
  readings_[pin].stands = true;
  readings_[1 - pin].stands = false;
  state_ = state;
  publish();
}

void EstimatedPlant::step() {
  plant_->step();
  sensors_.observe(plant_->state(), plant_->contact(Side::left), plant_->contact(Side::right));
  const SensorReadings& r = sensors_.readings();
  base_.predict(r.angular_velocity, r.specific_force, step_);
  if (r.has_new_positions) {
    velocities_.update(r.q);
    read_soles();
    for (const Side side : {Side::left, Side::right}) {
      SoleReading& sole = readings_[side == Side::left ? 0 : 1];
      const Vec<double, 6>& wrench = side == Side::left ? r.left : r.right;
      sole.stands = wrench[2] > (sole.stands ? 0.5 : 1.0) * options_.standing_force;
      sole.rests = sole.stands && presses_within(resting_[side == Side::left ? 0 : 1], wrench);
      if (side == pin_ && plant_->time() < certain_stand_) sole.stands = true;
      base_.correct(side, sole);
    }
  }
  publish();
}

void EstimatedPlant::pin(Side foot) {
  pin_ = foot;
  base_.pin(foot);
}

void EstimatedPlant::read_soles() {
  for (int i = 0; i < 2; ++i) {
    soles_[i].update(sensors_.readings().q);
    readings_[i].pose = soles_[i].pose();
    readings_[i].covariance.noalias() =
        leg_variance_ * soles_[i].jacobian() * soles_[i].jacobian().transpose();
  }
}

void EstimatedPlant::publish() {
  const SensorReadings& r = sensors_.readings();
  const ContactInertialState& s = base_.state();
  state_.base = s.base();
  state_.base_twist << s.R * (r.angular_velocity - s.b_gyroscope), s.v;
  state_.q = r.q;
  state_.dq = velocities_.velocity();
  for (int i = 0; i < 2; ++i) {
    const Vec<double, 6>& wrench = i == 0 ? r.left : r.right;
    const Mat<double, 3, 3> R = s.R * readings_[i].pose.linear();
    contacts_[i].touches = readings_[i].stands;
    contacts_[i].wrench << R * wrench.head<3>(), R * wrench.tail<3>();
  }
}

}  // namespace saltus
