// A quadruped with a gait: a schedule defines the contacts, and the forces are planned.
//
//   x' = rate(body, x, feet(t), f),   f = (f_FL, f_FR, f_RL, f_RR), forces of the ground, N
//   min  sum h ( |x - x_wanted(t)|^2_Q + |f|^2_W )
//   while leg i stands:   |f_ix|, |f_iy| <= mu f_iz,   0 <= f_iz <= f_max
//   while it swings:      f_i = 0
//
// A stance foot does not move. In the middle of its swing, when its force is zero, its position
// changes to the next one.
#include "problems/quadruped/problem.hpp"

#include "saltus/autodiff/math.hpp"

namespace saltus::quadruped {

OptimalControlProblem problem(const Model& model, const Weights& weights,
                              const JointSchedule& contacts) {
  const auto dynamics = [body = model.body](const auto& t, const auto& x, const auto& f,
                                            const auto& p) {
    using S = std::decay_t<decltype(x[0])>;
    const auto tick = view_as<Tick>(p);
    PerLeg<S> feet, forces;
    for (int leg = 0; leg < legs; ++leg) {
      forces.col(leg) = f.template segment<3>(3 * leg);
      for (int i = 0; i < 3; ++i)
        feet(i, leg) =
            select(S(t - tick.next_from[leg]), tick.next_feet(i, leg), tick.feet(i, leg));
    }
    return rate<S>(body, x, feet, forces);
  };
  const auto off_the_wanted = [](const auto& t, const auto& x, const auto&, const auto& p) {
    using S = std::decay_t<decltype(x[0])>;
    const auto tick = view_as<Tick>(p);
    const S s = t - tick.begin;
    State<S> wanted;
    wanted << tick.position + s * tick.velocity, tick.velocity, S(0.0), S(0.0),
        tick.yaw + s * tick.yaw_rate, S(0.0), S(0.0), tick.yaw_rate;
    return (x - wanted).eval();
  };

  Phase<states, 3 * legs, size_of<Tick>> phase{"gait", dynamics, exactly(model.horizon())};
  phase.data("tick", Tick<double>{});
  for (int leg = 0; leg < legs; ++leg) {
    const Window stands = contacts.during(leg, on_ground(leg)),
                 swings = contacts.during(leg, in_air);
    const auto beyond_friction = [mu = model.friction, leg](const auto&, const auto&,
                                                            const auto& f) {
      using S = std::decay_t<decltype(f[0])>;
      const S fx = f[3 * leg], fy = f[3 * leg + 1], most = mu * f[3 * leg + 2];
      return Vec<S, 4>{fx - most, -fx - most, fy - most, -fy - most};
    };
    phase.keep(on_ground(leg) + " in cone", beyond_friction, at_most(0.0), stands)
        .bound_input(3 * leg + 2, between(0.0, model.strongest), stands);
    for (int i = 0; i < 3; ++i) phase.bound_input(3 * leg + i, exactly(0.0), swings);
  }
  phase.track("state", off_the_wanted, weights.state)
      .track(
          "forces", [](const auto&, const auto&, const auto& f) { return f; },
          VectorXd::Constant(3 * legs, weights.force))
      .nominal(State<double>::Constant(0.1), VectorXd::Constant(3 * legs, 10.0));

  OptimalControlProblem ocp("quadruped");
  ocp.schedule(contacts.joined()).start_at(State<double>::Zero()).then(phase);
  ocp.costs(CostRule::nodes);  // the sum h (...) above, as in discrete-time MPC of quadrupeds
  return ocp;
}

}  // namespace saltus::quadruped
