#include "problems/quadruped/controller.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::quadruped {
namespace {

// A leg without ground contact at the planned height searches so far below, m.
constexpr double deepest = 0.1;
// Largest distance of the desired position ahead of the body, m.
constexpr double longest_lead = 0.1;
constexpr double servo_rate = 20.0;  // rate at which a swing foot returns to its path, 1/s

MultipleShooting plan(const ControllerSettings& settings, const Gait& gait) {
  return {problem(settings.model, settings.weights, gait.legs_apart()),
          {.intervals_per_phase = settings.model.intervals, .integrator = runge_kutta4()}};
}

ControllerOptions options(const ControllerSettings& settings) {
  ControllerOptions options{.period = settings.period};
  options.fallback_input = VectorXd::Zero(3 * legs);
  for (int leg = 0; leg < legs; ++leg)
    options.fallback_input[3 * leg + 2] = settings.model.body.mass * gravity / legs;
  return options;
}

}  // namespace

Controller::Controller(const ControllerSettings& settings)
    : settings_(settings),
      gait_(settings.gait, settings.model.horizon(), settings.period),
      planner_(plan(settings, gait_), options(settings)) {}

Vec<double, 3> Controller::velocity_wanted(double yaw) const {
  return {settings_.speed * std::cos(yaw) - settings_.sideways * std::sin(yaw),
          settings_.speed * std::sin(yaw) + settings_.sideways * std::cos(yaw), 0.0};
}

// Foothold of a leg that lands after the given time: below its hip, half a stance ahead, and
// farther if the body is too fast (Raibert).
Vec<double, 3> Controller::foothold(int leg, const State<double>& x, double seconds) const {
  const double yaw = x[8] + settings_.turn * seconds, c = std::cos(yaw), s = std::sin(yaw);
  const Vec<double, 3> hip = settings_.model.body.hip(leg);
  const Vec<double, 2> velocity = x.segment<2>(3), wanted = velocity_wanted(yaw).head<2>();
  Vec<double, 2> ahead =
      0.5 * gait_.stance() * wanted + settings_.foothold_gain * (velocity - wanted);
  if (ahead.norm() > settings_.longest_step) ahead *= settings_.longest_step / ahead.norm();
  Vec<double, 3> place;
  place << x.head<2>() + seconds * velocity + ahead +
               Vec<double, 2>(c * hip[0] - s * hip[1], s * hip[0] + c * hip[1]),
      std::accumulate(ground_.begin(), ground_.end(), 0.0) / legs;
  return place;
}

void Controller::observe(double now, const State<double>& x, const PerLeg<double>& feet,
                         const Touching& touching) {
  if (!has_begun_) {
    tick_.position = x.head<3>();
    tick_.yaw = x[8];
    stood_.fill(true);
    for (int leg = 0; leg < legs; ++leg) ground_[leg] = feet(2, leg);
    has_begun_ = true;
  } else {
    tick_.position += settings_.period * tick_.velocity;
    tick_.yaw += settings_.period * tick_.yaw_rate;
  }
  gait_.update(now, touching);

  for (int leg = 0; leg < legs; ++leg) {
    if (stood_[leg] && !gait_.stands(leg)) lifted_from_.col(leg) = feet.col(leg);
    stood_[leg] = gait_.stands(leg);
    if (gait_.stands(leg) && touching[leg]) ground_[leg] = feet(2, leg);
    const double landing = gait_.next_landing(leg);
    if (gait_.stands(leg)) {
      tick_.feet.col(leg) = feet.col(leg);
      tick_.next_feet.col(leg) =
          foothold(leg, x, std::min(landing - now, settings_.model.horizon()));
      tick_.next_from[leg] = 0.5 * (gait_.next_lift(leg) + landing);
      commands_[leg] = {false, {0.0, 0.0, -settings_.landing_speed}};
    } else {
      tick_.feet.col(leg) = foothold(leg, x, std::max(gait_.due_at(leg) - now, 0.0));
      tick_.next_feet.col(leg) = tick_.feet.col(leg);
      tick_.next_from[leg] = landing;
      commands_[leg] = swing(leg, now, feet.col(leg));
    }
  }

  tick_.begin = now;
  tick_.velocity = velocity_wanted(x[8]);
  tick_.yaw_rate = settings_.turn;
  Vec<double, 2> lead = tick_.position.head<2>() - x.head<2>();
  if (lead.norm() > longest_lead)
    tick_.position.head<2>() = x.head<2>() + longest_lead / lead.norm() * lead;
  tick_.position[2] =
      settings_.height + std::accumulate(ground_.begin(), ground_.end(), 0.0) / legs;

  planner_.set_data("tick", tick_);
  planner_.set_schedule(gait_.contacts());
}

// The foot rises to the clearance and descends to the landing speed, which it keeps until ground
// contact. Horizontally it moves from the lift-off to the foothold.
LegCommand Controller::swing(int leg, double now, const Vec<double, 3>& foot) const {
  const double begin = gait_.lifted_at(leg), length = gait_.due_at(leg) - begin;
  const double s = std::max((now - begin) / length, 0.0);
  const Vec<double, 3> from = lifted_from_.col(leg), to = tick_.feet.col(leg);
  const double top = std::max(from[2], to[2]) + settings_.clearance;
  Vec<double, 3> path = to, rate = Vec<double, 3>::Zero();
  if (s < 1.0) {
    const double part = s * s * (3.0 - 2.0 * s), slope = 6.0 * s * (1.0 - s) / length;
    path.head<2>() = from.head<2>() + part * (to - from).head<2>();
    rate.head<2>() = slope * (to - from).head<2>();
  }
  if (s < 1.0) {  // cubics: lift-off and landing at the landing speed, at rest at the top
    const bool rises = s < 0.5;
    const double q = rises ? 1.0 - 2.0 * s : 2.0 * s - 1.0, half = 0.5 * length;
    const double drop = top - (rises ? from[2] : to[2]), v = settings_.landing_speed * half;
    path[2] = top + q * q * (v - 3.0 * drop + q * (2.0 * drop - v));
    rate[2] =
        (rises ? -1.0 : 1.0) * q * (2.0 * (v - 3.0 * drop) + 3.0 * q * (2.0 * drop - v)) / half;
  } else {
    path[2] = to[2] - std::min(settings_.landing_speed * (now - begin - length), deepest);
    rate[2] = -settings_.landing_speed;
  }
  return {true, rate + servo_rate * (path - foot)};
}

}  // namespace saltus::quadruped
