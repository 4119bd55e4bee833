// Places and times of steps as one hybrid optimal control problem; step_planning.md derives it.
//
// The pendulum of constant height with a flywheel, per horizontal axis:
//
//   c'   = omega (xi + eta - c)        centre of mass
//   xi'  = omega (xi + eta - p)        capture point after the angular momentum is back to zero
//   eta' = nu                          eta = (-H_y, H_x) / (m z omega), effect of that momentum
//
// with the centre of pressure p in the soles on the ground. Phases alternate: single support on
// foot k - 1 while foot k swings, then double support on feet k - 1 and k. Durations and places are
// unknown. After the last step the robot is captured: xi lies in the hull of both soles, and eta
// can return to zero from any value within its bounds.
#include "problems/push_recovery/step_problem.hpp"

#include <fmt/format.h>

#include <cmath>

#include "saltus/core/error.hpp"

namespace saltus::push_recovery {
namespace {

// p of a phase: measured data, the places of the feet, and the place where the capture point comes
// to rest. Rest: (side, forward, sideways), each in [-1, 1]; side -1 is the previous foot, 1 the
// last one.
constexpr int feet_at = size_of<StepNow>, rest_at = feet_at + 2 * most_planned_steps,
              parameters = rest_at + 3;

// Centre of the k-th foot: 0 is the stance foot, -1 the other one if it stands.
template <class P>
Vec<typename P::Scalar, 2> foot(int k, const Eigen::MatrixBase<P>& p) {
  using S = typename P::Scalar;
  if (k > 0) return {p[feet_at + 2 * k - 2], p[feet_at + 2 * k - 1]};
  if (k < 0) return view_as<StepNow>(p).other;
  return {S(0.0), S(0.0)};
}

// Supported part of the k-th foot. Feet that will land have support below the whole sole.
template <class P>
SupportedSole<typename P::Scalar> sole(int k, const Eigen::MatrixBase<P>& p,
                                       const Vec<double, 2>& half) {
  using S = typename P::Scalar;
  const auto now = view_as<StepNow>(p);
  Vec<S, 4> support = Vec<S, 4>::Zero();
  if (k <= 0) support = k < 0 ? now.other_support : now.stance_support;
  return supported<S>(foot(k, p), support, half);
}

// State (c, xi, eta, time since the last lift-off or, if that counts, landing); input (forward,
// sideways, nu, side), scaled to [-1, 1]. In single support (before == after) the side has no
// effect.
struct Pendulum {
  StepModel model;
  int before, after;  // feet on the ground

  template <class S>
  Vec<S, 7> operator()(const S&, const Vec<S, 7>& x, const Vec<S, 5>& u,
                       const Vec<S, parameters>& p) const {
    const S& omega = p[0];
    const Vec<S, 2> cop = in_hull<S>(sole(before, p, model.sole), sole(after, p, model.sole),
                                     before == after ? S(0.0) : u[4], u.template head<2>());
    Vec<S, 7> rate;
    for (int i = 0; i < 2; ++i) {
      const S captured = x[2 + i] + x[4 + i];
      rate[i] = omega * (captured - x[i]);
      rate[2 + i] = omega * (captured - cop[i]);
      rate[4 + i] = model.lent_rate * u[2 + i];
    }
    rate[6] = S(1.0);
    return rate;
  }
};

using StepPhase = Phase<7, 5, parameters>;

// Bounds, effort and parameters common to all phases.
StepPhase phase_of(const std::string& name, const StepModel& model, int before, int after,
                   Bounds duration, double usual, int steps) {
  StepPhase phase{name, Pendulum{model, before, after}, duration};
  for (int i = 0; i < 4; ++i) phase.bound_input(i, between(-1.0, 1.0));
  phase.bound_input(4, before == after ? exactly(0.0) : between(-1.0, 1.0));
  for (int i = 4; i < 6; ++i) phase.bound_state(i, between(-model.lent, model.lent));

  const StepWeights& w = model.weights;
  Vec<double, 7> effort;
  effort << w.pressure, w.pressure, w.torque, w.torque, 0.1 * w.pressure, w.momentum, w.momentum;
  const double lent = model.lent;
  phase.track(
      "effort",
      [lent](const auto&, const auto& x, const auto& u, const auto&) {
        using S = std::decay_t<decltype(x[0])>;
        Vec<S, 7> e;
        e << u, x[4] / lent, x[5] / lent;
        return e;
      },
      effort);
  phase.data("now", StepNow<double>{});
  for (int k = 1; k <= most_planned_steps; ++k) {
    const Vec<double, 2> guess(0.0, k % 2 == 1 ? 0.14 : 0.0);
    const std::string foot = fmt::format("foot {}", k);
    if (k <= steps)
      phase.unknown(foot, guess, between(-5.0, 5.0), 0.1);
    else
      phase.data(foot, guess);
  }
  phase.unknown("rest", Vec<double, 3>::Zero(), between(-1.0, 1.0));
  Vec<double, 7> magnitude = Vec<double, 7>::Constant(0.1);
  magnitude.segment<2>(4).setConstant(model.lent);
  phase.nominal(magnitude, Vec<double, 5>::Ones());
  phase.nominal_duration(0.1).guess_duration(usual);
  return phase;
}

// Terminal constraint: the capture point at rest lies in the hull of feet `before` and `after`.
void end_captured(StepPhase& phase, const StepModel& model, int before, int after) {
  const Vec<double, 2> half = model.sole;
  const StepWeights& w = model.weights;
  phase.reach(
      "captured",
      [=](const auto&, const auto& x, const auto&, const auto& p) {
        using S = std::decay_t<decltype(x[0])>;
        const Vec<S, 2> rest = in_hull<S>(sole(before, p, half), sole(after, p, half), p[rest_at],
                                          p.template segment<2>(rest_at + 1));
        return Vec<S, 2>(x[2] - rest[0], x[3] - rest[1]);
      },
      exactly(0.0), soft("captured", w.capture));
  phase.track_at_end(
      "rest",
      [](const auto&, const auto&, const auto&, const auto& p) {
        using S = std::decay_t<decltype(p[0])>;
        return Vec<S, 3>(p[rest_at], p[rest_at + 1], p[rest_at + 2]);
      },
      Vec<double, 3>(w.side, w.rest, w.rest));
}

// Excess of a distance over `most`, in eight horizontal directions.
template <class S>
Vec<S, 8> too_far(const Vec<S, 2>& way, const S& most) {
  const S dx = way[0], dy = way[1], r(std::sqrt(0.5));
  Vec<S, 8> beyond;
  beyond << dx, -dx, dy, -dy, r * (dx + dy), r * (dx - dy), r * (dy - dx), -r * (dx + dy);
  for (int i = 0; i < 8; ++i) beyond[i] -= most;
  return beyond;
}

// Foot k swings while foot k - 1 stands, and lands within the limits of legs and time.
void end_with_landing(StepPhase& phase, const StepModel& model, int k) {
  const StepWeights& w = model.weights;
  const double side = k % 2 == 1 ? 1.0 : -1.0;  // away from the stance foot
  const robots::SupportPolygon::HalfPlanes reach = model.reach;
  const robots::SupportPolygon::HalfPlanes leg = model.leg;
  phase.reach(
      "swing time", [](const auto&, const auto& x) { return x[6]; }, at_least(model.swing.lower));
  phase.reach(
      "reach of the foot",
      [=](const auto&, const auto& x, const auto&, const auto& p) {
        using S = std::decay_t<decltype(x[0])>;
        const Vec<S, 2> to = foot(k, p), from = foot(k - 1, p);
        const S forward = to[0] - from[0], away = side * (to[1] - from[1]);
        Vec<S, reach_rows> beyond;
        for (int i = 0; i < reach_rows; ++i)
          beyond[i] = reach.A(i, 0) * forward + reach.A(i, 1) * away - reach.b[i];
        return beyond;
      },
      at_most(0.0));
  phase.reach(
      "reach of the legs",
      [=](const auto&, const auto& x, const auto&, const auto& p) {
        using S = std::decay_t<decltype(x[0])>;
        const Vec<S, 2> to = foot(k, p), from = foot(k - 1, p);
        Vec<S, 2 * reach_rows> beyond;
        for (int i = 0; i < reach_rows; ++i) {
          const double ahead = leg.A(i, 0), out = side * leg.A(i, 1);
          beyond[i] = ahead * (to[0] - x[0]) + out * (to[1] - x[1]) - leg.b[i];
          beyond[reach_rows + i] = ahead * (from[0] - x[0]) - out * (from[1] - x[1]) - leg.b[i];
        }
        return beyond;
      },
      at_most(0.0), soft("reach", w.reach));
  // Minimum jerk: the peak speed is 15/8 of the mean speed. The motion is linear in its target: if
  // the target of a foot on its way to `aim` changes, a swing by the difference is added.
  const double mean_speed = model.swing_speed * 8.0 / 15.0;
  phase.reach(
      "swing speed",
      [=](const auto&, const auto& x, const auto&, const auto& p) {
        using S = std::decay_t<decltype(x[0])>;
        const Vec<S, 2> from = k > 1 ? foot(k - 2, p) : view_as<StepNow>(p).swing;
        return too_far<S>(foot(k, p) - from, mean_speed * x[6]);
      },
      at_most(0.0), soft("reach", w.reach));
  if (k == 1)
    phase.reach(
        "change of the swing",
        [=](const auto&, const auto& x, const auto&, const auto& p) {
          using S = std::decay_t<decltype(x[0])>;
          const auto now = view_as<StepNow>(p);
          return too_far<S>(foot(k, p) - now.aim, mean_speed * (x[6] - now.swung));
        },
        at_most(0.0), soft("reach", w.reach));
  const double usual = model.usual_swing;
  phase.track_at_end(
      "usual time", [usual](const auto&, const auto& x) { return (x[6] - usual) / 0.1; },
      Vec<double, 1>(w.duration));
  phase.track_at_end(
      "usual place",
      [=](const auto&, const auto&, const auto&, const auto& p) {
        using S = std::decay_t<decltype(p[0])>;
        const auto now = view_as<StepNow>(p);
        const Vec<S, 2> to = foot(k, p), from = foot(k - 1, p);
        const Vec<S, 2> drift = now.drift.template segment<2>(2 * k - 2);
        return Vec<S, 2>((to[0] - from[0] - drift[0] - now.stride[0]) / 0.1,
                         (side * (to[1] - from[1] - drift[1]) - now.stride[1]) / 0.1);
      },
      Vec<double, 2>::Constant(w.stride));
}

// Both feet stand, then one lifts off.
void end_with_lift_off(StepPhase& phase, const StepModel& model) {
  if (model.weights.support == 0.0) return;
  const double usual = model.usual_support;
  phase.track_at_end(
      "usual double support", [usual](const auto&, const auto& x) { return (x[6] - usual) / 0.1; },
      Vec<double, 1>(model.weights.support));
}

Jump clock_restarts(const char* event) {
  return jump<7>(event, [](const auto&, const auto& x) {
    auto after = x;
    after[6] = 0.0 * x[6];
    return after;
  });
}

}  // namespace

OptimalControlProblem step_problem(const StepModel& model, int steps, bool from_two_feet) {
  if (steps < 0 || steps > most_planned_steps)
    throw DefinitionError(
        fmt::format("step problem: {} steps, expected 0 to {}", steps, most_planned_steps));
  OptimalControlProblem ocp(fmt::format("{} steps", steps));
  // Costs are integrated (the default). A sum at the nodes times a free length has an indefinite
  // Gauss-Newton matrix, and making it convex took three quarters of a tick.
  ocp.start_at(VectorXd::Zero(step_states));
  if (steps == 0) {
    StepModel whole = model;
    whole.sole = model.standing_sole;
    StepPhase standing =
        phase_of("standing", whole, 0, -1, exactly(model.standing), model.standing, steps);
    end_captured(standing, whole, 0, -1);
    return ocp.then(standing);
  }
  if (from_two_feet) {
    StepPhase unloading =
        phase_of("unloading", model, 0, -1, model.unloading, model.unloading.lower, steps);
    end_with_lift_off(unloading, model);
    ocp.then(unloading);
  }
  for (int k = 1; k <= steps; ++k) {
    // Shortest remaining time of a swing, s: it may be nearly over.
    constexpr double shortest_rest = 0.01;
    StepPhase swing = phase_of(fmt::format("single support {}", k), model, k - 1, k - 1,
                               between(shortest_rest, model.swing.upper), model.usual_swing, steps);
    end_with_landing(swing, model, k);
    if (k == steps) end_captured(swing, model, k - 1, k);
    if (k == 1 && !from_two_feet)
      ocp.then(swing);
    else
      ocp.then(swing, clock_restarts("lift-off"));
    if (k == steps) continue;
    StepPhase support = phase_of(fmt::format("double support {}", k), model, k - 1, k,
                                 model.double_support, model.double_support.lower, steps);
    end_with_lift_off(support, model);
    if (model.weights.support == 0.0)
      ocp.then(support);
    else
      ocp.then(support, clock_restarts("landing"));
  }
  return ocp;
}

}  // namespace saltus::push_recovery
