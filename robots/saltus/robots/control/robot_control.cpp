#include "saltus/robots/control/robot_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus::robots::control {
namespace {

VectorXd efforts_of(const std::vector<LinkJoint>& joints) {
  VectorXd efforts(std::ssize(joints));
  for (std::size_t i = 0; i < joints.size(); ++i)
    efforts[static_cast<Eigen::Index>(i)] = joints[i].effort;
  return efforts;
}

// First-order filter, one period: replaces `value` by the filtered value, and stores it in `last`.
template <class Vector>
void low_pass(double bandwidth, double period, Vector& value, Vector& last) {
  if (bandwidth <= 0.0) return;
  const double weight = -std::expm1(-2.0 * 3.14159265358979323846 * bandwidth * period);
  last += weight * (value - last);
  value = last;
}

// Smooth motion from 0 to 1 with zero speed at both ends.
double smooth(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

void resize(SensorMessage& readings, Eigen::Index n) {
  readings.q = VectorXd::Zero(n);
  readings.dq = VectorXd::Zero(n);
}

}  // namespace

RobotControl::RobotControl(LinkController& controller, std::vector<LinkJoint> joints,
                           ControlOptions options)
    : controller_(controller),
      joints_(std::move(joints)),
      options_(options),
      effort_(efforts_of(joints_)),
      stuck_(effort_, options.stuck) {
  const std::ptrdiff_t n = std::ssize(joints_);
  start_.resize(n);
  springs_.resize(n);
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const LinkJoint& joint = joints_[static_cast<std::size_t>(i)];
    start_[i] = joint.start;
    springs_[i] = joint.gain * joint.effort;
  }
  resize(last_, n);
  resize(readings_, n);
  resize(filtered_, n);
  torques_ = VectorXd::Zero(n);
  from_ = held_torques_ = VectorXd::Zero(n);
  Robot::Commands& c = command_.commands;
  for (VectorXd* part : {&c.torques, &c.positions, &c.velocities, &c.stiffness, &c.damping})
    *part = VectorXd::Zero(n);
}

long RobotControl::lost() const {
  if (!has_readings_) return 0;
  const auto sent = static_cast<long>(last_.sequence - first_ + 1);
  return sent - (counts_.received - counts_.duplicate);
}

void RobotControl::note_refused(Refusal refusal) {
  ++counts_.refused;
  refusal_ = refusal;
}

// Counts the message. Returns false if it is old.
bool RobotControl::is_new(std::uint64_t sequence) {
  ++counts_.received;
  if (!has_readings_) {
    first_ = sequence;
    window_ = 1;
    return true;
  }
  if (sequence > last_.sequence) {
    const std::uint64_t ahead = sequence - last_.sequence;
    window_ = (ahead < 64 ? window_ << ahead : 0) | 1U;
    return true;
  }
  const std::uint64_t age = last_.sequence - sequence;
  const std::uint64_t bit = age < 64 ? std::uint64_t{1} << age : 0;
  // Of messages older than the window, only those before the first one are known to be new.
  if ((window_ & bit) != 0 || (bit == 0 && sequence >= first_)) {
    ++counts_.duplicate;
  } else {
    ++counts_.late;
    window_ |= bit;
    first_ = std::min(first_, sequence);
  }
  return false;
}

// One sentence on readings that cannot be true, or empty. `elapsed`: periods since the last ones,
// s.
std::string RobotControl::implausible(const SensorMessage& r, double elapsed) const {
  for (Eigen::Index i = 0; i < r.q.size(); ++i) {
    const LinkJoint& joint = joints_[static_cast<std::size_t>(i)];
    if (!std::isfinite(r.q[i]) || !std::isfinite(r.dq[i]))
      return fmt::format("the encoder of {} reads NaN; check this sensor", joint.name);
    if (r.q[i] < joint.position.lower - options_.beyond_limit ||
        r.q[i] > joint.position.upper + options_.beyond_limit)
      return fmt::format(
          "{} is at {:.3f} rad, beyond its limits {:.3f} to {:.3f}; check its encoder", joint.name,
          r.q[i], joint.position.lower, joint.position.upper);
    const double moved = std::abs(r.q[i] - last_.q[i]);
    if (has_readings_ && moved > options_.speed_factor * joint.speed * elapsed)
      return fmt::format("{} has jumped by {:.3f} rad in {:.0f} ms; check its encoder", joint.name,
                         moved, 1e3 * elapsed);
  }
  if (!r.is_finite()) return "the inertial or force sensors read NaN; check these sensors";
  if (has_readings_) {
    const double passed = r.time - last_.time;
    if (std::abs(passed - elapsed) > options_.clock_error * elapsed)
      return fmt::format(
          "the robot's clock has advanced by {:.1f} ms in {:.1f} ms of readings; check its clock",
          1e3 * passed, 1e3 * elapsed);
  }
  return {};
}

void RobotControl::stop(std::string fault) {
  if (is_stopping()) return;
  fault_ = std::move(fault);
  stopped_for_ = 0.0;
  from_ = last_.q;
  held_torques_ = command_.commands.torques;
  // A robot that was never driven needs no hold. Springs of a joint with a wrong sign are unstable.
  command_.state = command_.state == ControlState::start || command_.state == ControlState::check
                       ? ControlState::release
                       : ControlState::hold;
}

const CommandMessage* RobotControl::update(const SensorMessage& readings) {
  if (!is_new(readings.sequence)) return nullptr;
  ++counts_.used;
  const std::uint64_t periods = has_readings_ ? readings.sequence - last_.sequence : 1;
  const double elapsed = static_cast<double>(periods) * options_.period;
  std::string reason = implausible(readings, elapsed);
  if (reason.empty() && is_running() && !readings.requests_stop &&
      periods > static_cast<std::uint64_t>(options_.most_missing) + 1)
    reason = fmt::format("{} consecutive messages of the robot were lost; check the connection",
                         periods - 1);
  const bool began = is_stopping();
  if (!reason.empty()) {
    stop(std::move(reason));
    last_.sequence = readings.sequence;  // the other readings stay the last plausible ones
    has_readings_ = true;
    command_.answers = readings.sequence;
    return &continue_stop(began ? elapsed : 0.0);
  }
  if (readings.requests_stop) stop();
  switch (command_.state) {
    case ControlState::start:
      if (controller_.state() == ControlState::check) {  // no springs before the signs are known
        begin(readings);
        run(readings, 1);
        break;
      }
      stood_for_ = 0.0;
      from_ = readings.q;
      command_.state = ControlState::stand;
      [[fallthrough]];
    case ControlState::stand:
      if ((readings.q - start_).cwiseAbs().maxCoeff() < options_.near) {
        begin(readings);
        run(readings, 1);
      } else {
        stand(elapsed);
      }
      break;
    case ControlState::balance:
    case ControlState::check:
      run(readings, static_cast<long>(periods));
      break;
    case ControlState::hold:
    case ControlState::damp:
    case ControlState::release:
      continue_stop(began ? elapsed : 0.0);
      break;
  }
  last_ = readings;
  has_readings_ = true;
  command_.answers = readings.sequence;
  command_.time = readings.time;
  return &command_;
}

void RobotControl::stand(double elapsed) {
  stood_for_ += elapsed;
  if (stood_for_ > options_.stand + 2.0) {
    Eigen::Index worst = 0;
    const double left = (last_.q - start_).cwiseAbs().maxCoeff(&worst);
    stop(
        fmt::format("{} stays {:.3f} rad away from the posture of the start; check whether it is "
                    "blocked",
                    joints_[static_cast<std::size_t>(worst)].name, left));
    continue_stop(0.0);
    return;
  }
  const double s = smooth(stood_for_ / options_.stand);
  command_.commands.torques.setZero();
  readings_.q.noalias() = from_ + s * (start_ - from_);
  spring_to(readings_.q);
  answer();
}

void RobotControl::spring_to(const VectorXd& positions) {
  Robot::Commands& c = command_.commands;
  c.positions = positions;
  c.velocities.setZero();
  c.stiffness = options_.stiffness * springs_;
  c.damping = options_.damping * springs_;
}

void RobotControl::begin(const SensorMessage& r) {
  command_.state = controller_.state();
  balance_periods_ = 0;
  last_ = filtered_ = r;
  torques_.setZero();
  stuck_.start(r.q);
  controller_.start(r);
}

void RobotControl::filter(SensorMessage& r) {
  const double dt = options_.period;
  low_pass(options_.inertial_hz, dt, r.angular_velocity, filtered_.angular_velocity);
  low_pass(options_.inertial_hz, dt, r.specific_force, filtered_.specific_force);
  low_pass(options_.force_hz, dt, r.left, filtered_.left);
  low_pass(options_.force_hz, dt, r.right, filtered_.right);
  low_pass(options_.velocity_hz, dt, r.dq, filtered_.dq);
}

// The controller expects readings in every period. Missing ones are interpolated.
void RobotControl::run(const SensorMessage& r, long periods) {
  const Robot::Commands* computed = nullptr;
  for (long i = 1; i <= periods; ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(periods);
    const auto between = [s, &r, this](auto member) {
      (readings_.*member).noalias() = (1.0 - s) * (last_.*member) + s * (r.*member);
    };
    readings_.sequence = r.sequence - static_cast<std::uint64_t>(periods - i);
    readings_.time = (1.0 - s) * last_.time + s * r.time;
    readings_.pace = r.pace;
    readings_.orientation = r.orientation;
    between(&SensorMessage::q);
    between(&SensorMessage::dq);
    between(&SensorMessage::angular_velocity);
    between(&SensorMessage::specific_force);
    between(&SensorMessage::left);
    between(&SensorMessage::right);
    const double time = static_cast<double>(balance_periods_++) * options_.period;
    filter(readings_);
    computed = &controller_.update(time, readings_);
  }
  counts_.replaced += periods - 1;
  Robot::Commands& c = command_.commands;
  const double elapsed = static_cast<double>(periods) * options_.period;
  if (r.is_guarded) {  // the commands do not act
    ++counts_.guarded;
    stuck_.start(r.q);
  }
  c.torques = computed->torques;
  low_pass(options_.torque_hz, elapsed, c.torques, torques_);
  if (computed->positions.size() == c.positions.size()) {
    c.positions = computed->positions;
    c.velocities = computed->velocities;
    c.stiffness = computed->stiffness;
    c.damping = computed->damping;
  } else {
    c.positions = r.q;
    for (VectorXd* part : {&c.velocities, &c.stiffness, &c.damping}) part->setZero();
  }
  const bool is_finite = c.torques.allFinite() && c.positions.allFinite() &&
                         c.velocities.allFinite() && c.stiffness.allFinite() &&
                         c.damping.allFinite();
  if (is_finite) guard_torques();  // a soft stop holds these torques
  if (!is_finite) {
    c.torques.setZero();
    stop("the controller computed NaN; please report it with the folder of this run");
  } else if (std::string reason = controller_.fault(); !reason.empty()) {
    stop(std::move(reason));
  } else if (const Eigen::Index i = stuck_.update(elapsed, r.q, r.dq, c); i >= 0) {
    stop(
        fmt::format("{} has not moved for {:.2f} s although it is driven; check whether it is "
                    "blocked, and its motor",
                    joints_[static_cast<std::size_t>(i)].name, options_.stuck.time));
  } else if (controller_.is_done() || balanced() >= options_.balance) {
    stop();
  }
  if (is_running())
    answer();
  else
    continue_stop(0.0);
}

const CommandMessage& RobotControl::continue_stop(double seconds) {
  stopped_for_ += seconds;
  Robot::Commands& c = command_.commands;
  if (command_.state == ControlState::release) {
    for (VectorXd* part : {&c.torques, &c.velocities, &c.stiffness, &c.damping}) part->setZero();
    return answer();
  }
  const double faded = (stopped_for_ - options_.hold) / options_.damp;
  spring_to(from_);
  c.torques = held_torques_;
  if (faded >= 1.0) {
    command_.state = ControlState::release;
    for (VectorXd* part : {&c.torques, &c.stiffness, &c.damping}) part->setZero();
  } else if (faded > 0.0) {
    command_.state = ControlState::damp;
    c.torques *= 1.0 - faded;
    c.stiffness *= 1.0 - faded;
  }
  return answer();
}

// Torques within the limits, also those that only the springs could exceed later.
void RobotControl::guard_torques() {
  VectorXd& torques = command_.commands.torques;
  bool is_cut = false;
  for (Eigen::Index i = 0; i < torques.size(); ++i) {
    const double within = std::clamp(torques[i], -effort_[i], effort_[i]);
    is_cut = is_cut || within != torques[i];
    torques[i] = within;
  }
  if (is_cut) ++cut_;
}

const CommandMessage& RobotControl::answer() {
  guard_torques();
  ++command_.sequence;
  return command_;
}

}  // namespace saltus::robots::control
