#include "saltus/robots/whole_body/sensors.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/rotation_vector.hpp"
#include "saltus/robots/whole_body/sample_period.hpp"

namespace saltus::robots {
namespace {

// Standard normal variate by Box and Muller. It always uses two uniform draws, so that their count
// is constant.
double normal(Random& random) {
  const double u = 1.0 - random.uniform(0.0, 1.0);  // in (0, 1]
  const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(angle);
}

void require(bool holds, const char* device, const char* what, double value) {
  if (holds) return;
  throw DefinitionError(
      fmt::format("the {} of the {} is {}, expected a finite number {}", what, device, value,
                  std::string_view(what) == "rate" ? "above 0" : "of at least 0"));
}

void check(const char* device, double rate,
           std::initializer_list<std::pair<const char*, double>> rest) {
  require(rate > 0.0 && std::isfinite(rate), device, "rate", rate);
  for (const auto& [what, value] : rest)
    require(value >= 0.0 && std::isfinite(value), device, what, value);
}

SensorDevice encoder(const SensorOptions::Encoder& o, int joints, double step, std::uint64_t seed) {
  check("encoders", o.rate,
        {{"resolution", o.resolution}, {"noise", o.noise}, {"bias", o.bias}, {"delay", o.delay}});
  return {{o.rate, o.delay, o.resolution, VectorXd::Constant(joints, o.noise),
           VectorXd::Constant(joints, o.bias)},
          step,
          seed};
}

SensorDevice inertial(const SensorOptions::Inertial& o, const char* name, double step,
                      std::uint64_t seed) {
  check(name, o.rate, {{"noise", o.noise}, {"bias", o.bias}, {"delay", o.delay}});
  const double rate = 1.0 / sample_period(o.rate, step);
  return {{o.rate, o.delay, 0.0, VectorXd::Constant(3, o.noise * std::sqrt(rate)),
           VectorXd::Constant(3, o.bias), true},
          step,
          seed};
}

SensorDevice force_torque(const SensorOptions::ForceTorque& o, double step, std::uint64_t seed) {
  check("force and torque sensors", o.rate,
        {{"noise of forces", o.force_noise},
         {"noise of torques", o.torque_noise},
         {"bias of forces", o.force_bias},
         {"bias of torques", o.torque_bias},
         {"delay", o.delay}});
  VectorXd noise(6), bias(6);
  noise << Vec<double, 3>::Constant(o.force_noise), Vec<double, 3>::Constant(o.torque_noise);
  bias << Vec<double, 3>::Constant(o.force_bias), Vec<double, 3>::Constant(o.torque_bias);
  return {{o.rate, o.delay, 0.0, noise, bias, true}, step, seed};
}

// Each device has its own random numbers, which do not depend on the rates of the others, nor on
// how many devices there are: devices 5 to 9 take seeds from 2^40 on, and so on.
std::uint64_t seed_of(const SensorOptions& options, std::uint64_t device) {
  constexpr std::uint64_t block = 5;
  return (device / block << 40) + block * static_cast<std::uint64_t>(options.seed) + device % block;
}

}  // namespace

SensorDevice::SensorDevice(Options options, double step, std::uint64_t seed)
    : options_(std::move(options)),
      period_(steps_between(options_.rate, step)),
      delay_(std::lround(options_.delay / step)),
      seed_(seed),
      random_(seed),
      bias_(VectorXd::Zero(options_.noise.size())),
      sum_(bias_),
      reading_(bias_),
      waiting_(static_cast<std::size_t>(delay_ / period_ + 1)) {
  for (Sample& sample : waiting_) sample.value = bias_;
}

void SensorDevice::reset(const VectorXd& value) {
  random_ = Random(seed_);
  for (Eigen::Index i = 0; i < bias_.size(); ++i) bias_[i] = options_.bias[i] * normal(random_);
  steps_ = 0;
  first_ = count_ = 0;
  sum_.setZero();
  sample(value);
  reading_ = waiting_[first_].value;
  count_ = 0;
  is_new_ = true;
}

void SensorDevice::observe(const VectorXd& value) {
  ++steps_;
  sum_ += value;
  if (steps_ % period_ == 0) {
    if (options_.averages) {
      sum_ /= static_cast<double>(period_);
      sample(sum_);
    } else {
      sample(value);
    }
    sum_.setZero();
  }
  is_new_ = count_ > 0 && waiting_[first_].due <= steps_;
  if (!is_new_) return;
  reading_ = waiting_[first_].value;
  first_ = (first_ + 1) % waiting_.size();
  --count_;
}

void SensorDevice::sample(const VectorXd& value) {
  Sample& sample = waiting_[(first_ + count_) % waiting_.size()];
  ++count_;
  sample.due = steps_ + delay_;
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    double& x = sample.value[i];
    x = value[i] + bias_[i] + options_.noise[i] * normal(random_);
    if (options_.resolution > 0.0) x = options_.resolution * std::round(x / options_.resolution);
  }
}

Sensors::Sensors(const FloatingRobot& robot, const SensorOptions& options, double step)
    : step_(step),
      soles_{{robot, Side::left}, {robot, Side::right}},
      encoder_(encoder(options.encoder, robot.joints(), step, seed_of(options, 0))),
      gyroscope_(inertial(options.gyroscope, "gyroscope", step, seed_of(options, 1))),
      accelerometer_(inertial(options.accelerometer, "accelerometer", step, seed_of(options, 2))),
      feet_{force_torque(options.force_torque, step, seed_of(options, 3)),
            force_torque(options.force_torque, step, seed_of(options, 4))},
      base_(Eigen::Isometry3d::Identity()),
      velocity_(Vec<double, 3>::Zero()),
      inertial_(VectorXd::Zero(3)),
      wrench_(VectorXd::Zero(6)) {
  readings_.q = VectorXd::Zero(robot.joints());
}

void Sensors::reset(const WholeBodyState& state) {
  base_ = state.base;
  velocity_ = state.base_twist.tail<3>();
  encoder_.reset(state.q);
  inertial_.setZero();
  gyroscope_.reset(inertial_);
  inertial_ = base_.linear().transpose() * Vec<double, 3>(0.0, 0.0, standard_gravity);
  accelerometer_.reset(inertial_);
  wrench_.setZero();
  for (SensorDevice& foot : feet_) foot.reset(wrench_);
  read();
}

void Sensors::observe(const WholeBodyState& state, const WholeBodyEstimate::Contact& left,
                      const WholeBodyEstimate::Contact& right) {
  encoder_.observe(state.q);
  const Vec<double, 3> turned = log_so3(base_.linear().transpose() * state.base.linear());
  inertial_ = turned / step_;
  gyroscope_.observe(inertial_);
  const Mat<double, 3, 3> halfway = base_.linear() * exp_so3(0.5 * turned);
  const Vec<double, 3> velocity = state.base_twist.tail<3>();
  inertial_ = halfway.transpose() *
              ((velocity - velocity_) / step_ + Vec<double, 3>(0.0, 0.0, standard_gravity));
  accelerometer_.observe(inertial_);
  base_ = state.base;
  velocity_ = velocity;
  for (int i = 0; i < 2; ++i) {
    soles_[i].update(state.q);
    const Vec<double, 6>& wrench = (i == 0 ? left : right).wrench;
    const Mat<double, 3, 3> R = base_.linear() * soles_[i].pose().linear();
    wrench_.head<3>() = R.transpose() * wrench.head<3>();
    wrench_.tail<3>() = R.transpose() * wrench.tail<3>();
    feet_[i].observe(wrench_);
  }
  read();
}

void Sensors::read() {
  readings_.q = encoder_.reading();
  readings_.has_new_positions = encoder_.is_new();
  readings_.angular_velocity = gyroscope_.reading();
  readings_.specific_force = accelerometer_.reading();
  readings_.left = feet_[0].reading();
  readings_.right = feet_[1].reading();
}

}  // namespace saltus::robots
