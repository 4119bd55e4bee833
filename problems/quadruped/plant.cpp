#include "problems/quadruped/plant.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::quadruped {
namespace {

// x = (body, positions of the feet); u = (forces of legs in contact, velocities of other feet,
// push)
constexpr int nx = states + 3 * legs;
constexpr int nu = 3 * legs + 3 * legs + 3;

std::string name_of(int mode) {
  std::string name;
  for (int leg = 0; leg < legs; ++leg) {
    if (leg > 0) name += ' ';
    name += (mode & 1 << leg) != 0 ? leg_names[leg] : "-";
  }
  return name;
}

struct Dynamics {
  Body body;
  int mode;  // bit i: leg i is in contact

  template <class S>
  Vec<S, nx> operator()(const S&, const Vec<S, nx>& x, const Vec<S, nu>& u) const {
    const State<S> b = x.template head<states>();
    Vec<S, 3> force = u.template tail<3>(), torque = Vec<S, 3>::Zero();
    Vec<S, nx> dx = Vec<S, nx>::Zero();
    for (int leg = 0; leg < legs; ++leg) {
      const int at = states + 3 * leg;
      if ((mode & 1 << leg) == 0) {
        dx.template segment<3>(at) = u.template segment<3>(3 * legs + 3 * leg);
        continue;
      }
      const Vec<S, 3> arm = x.template segment<3>(at) - b.template head<3>(),
                      push = u.template segment<3>(3 * leg);
      force += push;
      torque += arm.cross(push);
    }
    dx.template head<states>() = rate<S>(body, b, force, torque);
    return dx;
  }
};

Automaton<nx, nu> automaton(const Body& body, const Ground& ground) {
  Automaton<nx, nu> robot;
  for (int mode = 0; mode < 1 << legs; ++mode) robot.mode(name_of(mode), Dynamics{body, mode});
  for (int leg = 0; leg < legs; ++leg) {
    const auto clearance = [ground, leg](const auto&, const auto& x) {
      const int at = states + 3 * leg;
      return x[at + 2] - ground(x[at], x[at + 1]);
    };
    // Relative to the ground: a foot that is commanded to rise more slowly than the slope ahead of
    // it stays in contact.
    const auto commanded_lift = [ground, leg](const auto&, const auto& x, const auto& u) {
      const int at = states + 3 * leg, to = 3 * legs + 3 * leg;
      return u[to + 2] - ground.rise(x[at], x[at + 1], u[to], u[to + 1]);
    };
    for (int mode = 0; mode < 1 << legs; ++mode) {
      const std::string from = name_of(mode), to = name_of(mode ^ 1 << leg);
      if ((mode & 1 << leg) == 0)
        robot.event(std::string(leg_names[leg]) + " lands", from, to, clearance, Crossing::falling);
      else
        robot.event(std::string(leg_names[leg]) + " lifts", from, to, commanded_lift,
                    Crossing::rising);
    }
  }
  return robot;
}

VectorXd at_rest(const Body& body, const Ground& ground, double height) {
  VectorXd x = VectorXd::Zero(nx);
  for (int leg = 0; leg < legs; ++leg) {
    auto foot = x.segment<3>(states + 3 * leg);
    foot = body.hip(leg);
    foot[2] = ground(foot[0], foot[1]);
    x[2] += foot[2] / legs;
  }
  x[2] += height;
  return x;
}

}  // namespace

RobotOnGround::RobotOnGround(const PlantSettings& settings, const Ground& ground, double height)
    : settings_(settings),
      ground_(ground),
      inner_(std::make_unique<IntegratorPlant>(
          make_plant(automaton(settings.body, ground), runge_kutta4(),
                     at_rest(settings.body, ground, height)))) {
  for (LegCommand& command : commands_) command.velocity[2] = -0.1;
}

Touching RobotOnGround::touching() const {
  const std::string mode = inner_->mode();
  Touching touching{};
  for (int leg = 0; leg < legs; ++leg)
    touching[leg] = mode.find(leg_names[leg]) != std::string::npos;
  return touching;
}

Vec<double, 3> RobotOnGround::force_of_leg(int leg, const State<double>& x,
                                           const Vec<double, 3>& foot,
                                           const Vec<double, 3>& planned) const {
  const Vec<double, 3> hip = x.head<3>() + rotation(x) * settings_.body.hip(leg);
  if ((foot - hip).norm() > settings_.leg_length) return Vec<double, 3>::Zero();
  Vec<double, 3> force = planned;
  if (commands_[leg].swings) force = -settings_.servo_gain * commands_[leg].velocity;
  force[2] = std::max(force[2], 0.0);
  const double most = settings_.friction * force[2], along = force.head<2>().norm();
  if (along > most) force.head<2>() *= most / along;
  return force;
}

bool RobotOnGround::advance(const VectorRef& forces, double length) {
  const VectorXd now = inner_->state();
  const State<double> x = now.head<states>();
  VectorXd u(nu);
  for (int leg = 0; leg < legs; ++leg) {
    forces_.col(leg) =
        force_of_leg(leg, x, now.segment<3>(states + 3 * leg), forces.segment<3>(3 * leg));
    u.segment<3>(3 * leg) = forces_.col(leg);
    u.segment<3>(3 * legs + 3 * leg) = commands_[leg].velocity;
  }
  u.tail<3>().setZero();
  for (const Pulse& pulse : pulses_) u.tail<3>() += pulse.mean(time(), time() + length);
  return inner_->advance(u, length);
}

std::vector<HybridEvent> RobotOnGround::take_events() {
  std::vector<HybridEvent> events = inner_->take_events();
  for (HybridEvent& event : events) {
    event.before.conservativeResize(states);
    event.after.conservativeResize(states);
  }
  return events;
}

void RobotOnGround::disturb(const VectorRef& change) {
  VectorXd all = VectorXd::Zero(nx);
  all.head<states>() = change;
  inner_->disturb(all);
}

double RobotOnGround::tilt() const {
  return std::acos(std::clamp(rotation<double>(state())(2, 2), -1.0, 1.0));
}

double RobotOnGround::height() const {
  const VectorXd x = inner_->state();
  return x[2] - ground_(x[0], x[1]);
}

}  // namespace saltus::quadruped
