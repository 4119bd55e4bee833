#include "saltus/robots/simulation/simulated_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus::robots::walking {
namespace {

// Delay of the torques in steps of the engine.
std::size_t delay_steps(const PlantSettings& settings, double control_period) {
  if (settings.delay_ticks < 0)
    throw DefinitionError(fmt::format(
        "the delay of the torques is {} control ticks, expected at least 0", settings.delay_ticks));
  return static_cast<std::size_t>(settings.delay_ticks *
                                  std::lround(control_period / settings.engine.step));
}

}  // namespace

SimulatedRobot::SimulatedRobot(std::unique_ptr<Plant> engine, const FloatingRobot& body,
                               const PlantSettings& settings, double control_period)
    : engine_(std::move(engine)),
      step_(settings.engine.step),
      has_motors_(!settings.motors.is_ideal()),
      motors_(settings.motors, static_cast<int>(engine_->state().q.size()), step_),
      friction_(body, step_),
      elastic_(body, step_),
      effort_(body.joints()),
      exerted_(VectorXd::Zero(body.joints())),
      joint_torques_(exerted_),
      noise_(settings.noise),
      commanded_{{exerted_}, 0},
      waiting_(delay_steps(settings, control_period), commanded_) {
  for (int i = 0; i < body.joints(); ++i) {
    effort_[i] = body.bodies[i + 1].effort;
    drives_.push_back(body.bodies[i + 1].drive);
  }
  if (settings.sensors == PlantSettings::Sensors::measured)
    sensors_.emplace(body, settings.sensor, step_);
  begin(engine_->state());
}

void SimulatedRobot::reset(const WholeBodyState& state) {
  engine_->reset(state);
  begin(state);
}

void SimulatedRobot::push_by(std::span<const Pulse> pulses, const FloatingRobot::Frame& at) {
  pulses_.assign(pulses.begin(), pulses.end());
  pushed_ = at;
}

void SimulatedRobot::begin(const WholeBodyState& state) {
  steps_ = 0;
  motors_.reset();
  friction_.reset();
  elastic_.reset();
  noise_.reset();
  commanded_ = {{VectorXd::Zero(effort_.size())}, 0};
  exerted_.setZero();
  next_ = 0;
  is_first_ = true;
  if (sensors_) sensors_->reset(state);
  measure();
}

void SimulatedRobot::write(const Robot::Commands& commands) {
  commanded_.commands = commands;
  commanded_.age = 0;
  if (is_first_) std::fill(waiting_.begin(), waiting_.end(), commanded_);
  is_first_ = false;
}

std::string SimulatedRobot::wait() {
  const double from = static_cast<double>(steps_) * step_;
  const double to = static_cast<double>(steps_ + 1) * step_;
  for (const Pulse& pulse : pulses_) {
    const Vec<double, 3> force = pulse.mean(from, to);
    if (!force.isZero(0.0)) engine_->push(pushed_.body, force, pushed_.pose.translation());
  }
  drive(waiting_.empty() ? commanded_ : waiting_[next_]);
  if (!waiting_.empty()) {
    waiting_[next_] = commanded_;
    next_ = (next_ + 1) % waiting_.size();
  }
  ++commanded_.age;
  engine_->step();
  if (!elastic_.is_rigid()) elastic_.end_step(engine_->state().dq);
  ++steps_;
  if (sensors_)
    sensors_->observe(engine_->state(), engine_->contact(Side::left),
                      engine_->contact(Side::right));
  measure();
  if (engine_->state().is_finite()) return {};
  return fmt::format("the plant could not be integrated at {:.3f} s", from);
}

// Sets the torques of the joints: those of the motors within their limits, less the friction. If
// the drives are elastic, these torques act on the rotors, and the springs on the joints. Commanded
// springs and dampers use the motion of the joints, which the encoders measure.
void SimulatedRobot::drive(const Waiting& acting) {
  const VectorXd &q = engine_->state().q, &dq = engine_->state().dq;
  const Robot::Commands& c = acting.commands;
  exerted_ = c.torques;
  const double since = static_cast<double>(acting.age) * step_;
  for (Eigen::Index i = 0; i < c.positions.size(); ++i)
    exerted_[i] += c.stiffness[i] * (c.positions[i] + since * c.velocities[i] - q[i]) +
                   c.damping[i] * (c.velocities[i] - dq[i]);
  if (has_motors_) {
    motors_.command(exerted_);
    exerted_ = motors_.step();
  }
  const VectorXd& speeds = elastic_.is_rigid() ? dq : elastic_.rotor_speeds(dq);
  for (Eigen::Index i = 0; i < exerted_.size(); ++i) {
    const Bounds range = drives_[static_cast<std::size_t>(i)].torque_range(effort_[i], speeds[i]);
    exerted_[i] = std::clamp(exerted_[i], range.lower, range.upper);
  }
  joint_torques_ = exerted_;
  if (!friction_.is_zero()) joint_torques_ -= friction_.step(speeds);
  if (!elastic_.is_rigid()) {
    joint_torques_ = elastic_.begin_step(q, dq, joint_torques_);
    engine_->set_rotor_inertias(elastic_.inertias());
  }
  engine_->set_torques(joint_torques_);
}

void SimulatedRobot::measure() {
  if (sensors_) {
    readings_ = sensors_->readings();
  } else {
    measured_.state = engine_->state();
    measured_.left = engine_->contact(Side::left);
    measured_.right = engine_->contact(Side::right);
    noise_.disturb(measured_);
    readings_.ideal = measured_;
  }
  readings_.time = static_cast<double>(steps_) * step_;
}

}  // namespace saltus::robots::walking
