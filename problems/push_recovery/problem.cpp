// Push recovery by stepping: Dafarra, Romano, Nori, "A receding horizon push recovery strategy for
// balancing the iCub humanoid robot". The robot stands on one foot; the other one lands at the
// event "impact". Either may be the left one, and either may lift off again. All physics,
// constraints and costs of the controller are in this file.
//
// State gamma = (CoM position, CoM velocity, angular momentum about the CoM), in the world (m, m/s,
// Nms); inputs f = (f_left, f_right), contact wrenches in the axes of their soles (N, Nm).
#include "problems/push_recovery/problem.hpp"

#include "saltus/robots/centroidal/centroidal.hpp"
#include "saltus/robots/model/contact_cone.hpp"
#include "saltus/robots/walking/contacts.hpp"

namespace saltus::push_recovery {

using robots::walking::double_support, walking::left_support, walking::right_support;

namespace {

/// Level sole frame at `position` with its x axis along `heading`, a unit vector.
template <class S>
robots::SoleFrameOf<S> level_sole(const Vec<S, 3>& position, const Vec<S, 2>& heading) {
  robots::SoleFrameOf<S> sole;
  sole.position = position;
  sole.rotation(0, 0) = sole.rotation(1, 1) = heading[0];
  sole.rotation(0, 1) = -heading[1];
  sole.rotation(1, 0) = heading[1];
  return sole;
}

/// gamma' = (velocity, forces / m + gravity, torques about the CoM). The last row is linearised
/// about the last measurement: H' = sum_i tau_i + (x_i - x0) x f_i + (sum_i f_i0) x (x - x0).
struct Dynamics {
  Model model;

  template <class S>
  Vec<S, 9> operator()(const S&, const Vec<S, 9>& gamma, const Vec<S, 12>& f,
                       const Vec<S, size_of<Tick>>& p) const {
    const auto tick = view_as<Tick>(p);
    const Vec<S, 3> com = gamma.template head<3>(), velocity = gamma.template segment<3>(3);
    const robots::Contact<S> left = robots::contact<S>(
        level_sole<S>(tick.left_foot, tick.left_heading), Vec<S, 6>(f.template head<6>()));
    const robots::Contact<S> right = robots::contact<S>(
        level_sole<S>(tick.right_foot, tick.right_heading), Vec<S, 6>(f.template tail<6>()));
    Vec<S, 3> acceleration = (left.force + right.force) * S(1.0 / model.mass);
    acceleration[2] -= robots::standard_gravity;
    Vec<S, 9> rate;
    rate << velocity, acceleration,
        left.torque + right.torque + (left.position - tick.com).cross(left.force) +
            (right.position - tick.com).cross(right.force) + tick.force.cross(com - tick.com);
    return rate;
  }
};

/// Distances of the centre of pressure beyond the ends of the supported area, times the force.
template <class F, class Ends>
auto off_support(const F& wrench, const Ends& ends) {
  using S = typename F::Scalar;
  return Vec<S, 4>(ends[0] * wrench[2] + wrench[4], -ends[1] * wrench[2] - wrench[4],
                   ends[2] * wrench[2] - wrench[3], -ends[3] * wrench[2] + wrench[3]);
}

}  // namespace

OptimalControlProblem problem(const Model& model, const Weights& weights, const Tick<double>& data,
                              const Schedule& contacts) {
  const Window always{}, on_one_foot = during(left_support, right_support),
                         after_impact = during(double_support);
  const auto gamma_error = [](const auto&, const auto& gamma, const auto&, const auto& p) {
    return (gamma - view_as<Tick>(p).gamma_desired).eval();
  };
  const auto capture = [](const auto& gamma, const auto& tick) {
    return capture_point(gamma.template head<2>().eval(), gamma.template segment<2>(3).eval(),
                         tick.omega);
  };
  const auto capture_error = [capture](const auto&, const auto& gamma, const auto&, const auto& p) {
    const auto tick = view_as<Tick>(p);
    return (capture(gamma, tick) - tick.capture_point_desired).eval();
  };
  // Without a planned step, the stance sole alone must catch the capture point.
  const auto standing_error = [capture_error](const auto& t, const auto& gamma, const auto& f,
                                              const auto& p) {
    return (view_as<Tick>(p).standing * capture_error(t, gamma, f, p)).eval();
  };
  const auto outside_hull = [capture](const auto&, const auto& gamma, const auto&, const auto& p) {
    const auto tick = view_as<Tick>(p);
    return (tick.hull_normals * capture(gamma, tick) - tick.hull_offsets).eval();
  };
  const auto left_off_support = [](const auto&, const auto&, const auto& f, const auto& p) {
    return off_support(f.template head<6>().eval(), view_as<Tick>(p).left_support);
  };
  const auto right_off_support = [](const auto&, const auto&, const auto& f, const auto& p) {
    return off_support(f.template tail<6>().eval(), view_as<Tick>(p).right_support);
  };
  const auto wrenches = [](const auto&, const auto&, const auto& f) { return f; };
  // While walking, the motion follows the step plan; otherwise it comes to rest at the target.
  const auto off_motion = [](const auto& t, const auto& gamma, const auto&, const auto& p) {
    using S = std::decay_t<decltype(gamma[0])>;
    const auto tick = view_as<Tick>(p);
    const S s = t - tick.motion_begin;
    const auto& motion = tick.com_motion;
    Vec<S, 9> error = gamma - tick.gamma_desired;
    error.template head<2>() =
        gamma.template head<2>() - motion.col(0) - s * (motion.col(1) + s * motion.col(2));
    error.template segment<2>(3) =
        gamma.template segment<2>(3) - motion.col(1) - S(2.0) * s * motion.col(2);
    return error;
  };
  const auto capture_off_motion = [capture](const auto& t, const auto& gamma, const auto&,
                                            const auto& p) {
    using S = std::decay_t<decltype(gamma[0])>;
    const auto tick = view_as<Tick>(p);
    const S s = t - tick.motion_begin;
    const auto& motion = tick.capture_motion;
    return (capture(gamma, tick) - motion.col(0) - s * (motion.col(1) + s * motion.col(2))).eval();
  };
  const auto walking_error = [capture_off_motion](const auto& t, const auto& gamma, const auto& f,
                                                  const auto& p) {
    return (view_as<Tick>(p).following * capture_off_motion(t, gamma, f, p)).eval();
  };

  Phase<9, 12, size_of<Tick>> phase{"step", Dynamics{model}, exactly(model.step * model.intervals)};
  phase.common_resultant({0, 6}, 6);  // force and torque about the CoM
  phase.data("tick", data);

  // Contacts ("Constraints definition"). A foot in the air exerts no wrench.
  robots::keep_in_cone(phase, "left foot", model.left_contact, 0,
                       during(left_support, double_support));
  robots::keep_in_cone(phase, "right foot", model.right_contact, 6,
                       during(right_support, double_support));
  if (model.estimates_support) {
    phase.keep("left foot on its support", left_off_support, at_most(0.0),
               during(left_support, double_support));
    phase.keep("right foot on its support", right_off_support, at_most(0.0),
               during(right_support, double_support));
  }
  for (int i = 0; i < 6; ++i) {
    phase.bound_input(i, exactly(0.0), during(right_support));
    phase.bound_input(6 + i, exactly(0.0), during(left_support));
  }

  // After the impact the capture point lies in the convex hull of both feet.
  if (weights.capture_point_penalty > 0.0)
    phase.keep("capture point in hull", outside_hull, at_most(0.0), after_impact,
               soft("capture point", weights.capture_point_penalty));
  else
    phase.keep("capture point in hull", outside_hull, at_most(0.0), after_impact);

  // The five terms of Gamma ("Cost function definition"), and the term for standing.
  Vec<double, 12> wrench_weights;
  wrench_weights << weights.wrench, weights.wrench;
  if (model.follows_motion)
    phase.track("state", off_motion, weights.gamma, always)
        .track("state after impact", off_motion, weights.gamma_impact, after_impact)
        .track("wrenches", wrenches, wrench_weights, always)
        .track("capture point", capture_off_motion, weights.capture_point, after_impact)
        .track("capture point, walking", walking_error, weights.capture_point, on_one_foot)
        .track("capture point, standing", standing_error, weights.capture_point_standing,
               on_one_foot)
        .track_at_end("final state", off_motion, weights.gamma_impact);
  else
    phase.track("state", gamma_error, weights.gamma, always)
        .track("state after impact", gamma_error, weights.gamma_impact, after_impact)
        .track("wrenches", wrenches, wrench_weights, always)
        .track("capture point", capture_error, weights.capture_point, after_impact)
        .track("capture point, standing", standing_error, weights.capture_point_standing,
               on_one_foot)
        .track_at_end("final state", gamma_error, weights.gamma_impact);
  if (weights.wrench_change > 0.0)
    phase.penalise_change(Vec<double, 12>::Constant(weights.wrench_change));

  phase.nominal(Vector9::Constant(0.1), Vec<double, 12>::Constant(10.0));
  OptimalControlProblem ocp("push recovery");
  ocp.schedule(contacts).costs(model.cost_rule).start_at(data.gamma_desired).then(phase);
  return ocp;
}

}  // namespace saltus::push_recovery
