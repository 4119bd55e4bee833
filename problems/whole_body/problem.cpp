// Plans of the whole body with centroidal dynamics and full kinematics.
//
// State (c, v, k, q): centre of mass, its velocity, angular momentum about it divided by the mass,
// and the configuration q of robots::Kinematics. Input (dq, wrenches): rates of q, then force and
// torque of the world on each sole about its place, divided by the weight m g, in world axes. If
// the plan chooses the place of a landing, x and y of this place are a state s, and s' is an input
// until the foot lands. With the places p_i of the contacts,
//
//   c' = v,   v' = g (sum_i f_i - e_z),   k' = g sum_i ((p_i - c) x f_i + t_i),   q' = dq
//
// and at every node
//
//   c = com(q),   m k = angular momentum(q, dq),   frame_i(q) = place_i,
//
// wrenches in the cones of friction and pressure, torques of the joints at rest within their
// limits, feet in the air above the ground, legs apart. Durations are free.
#include "problems/whole_body/problem.hpp"

#include <algorithm>
#include <array>
#include <type_traits>

#include "saltus/robots/model/capture_point.hpp"

namespace saltus::whole_body {
namespace {

using robots::standard_gravity;
template <class S>
using Robot = robots::Kinematics<joints, S>;

template <int soles>
inline constexpr int inputs = coordinates + 6 * soles;  // without s'

template <class S, int nx>
auto q_of(const Vec<S, nx>& x) {
  return x.template tail<coordinates>();
}

// Coordinate `axis` of the place of a contact, m.
template <class S, int nx>
S place_of(const Contact& contact, int axis, const Vec<S, nx>& x) {
  return contact.chosen && axis < 2 ? x[place_at + axis] : S(contact.place.position[axis]);
}

// Contacts of a phase. The force of contact i begins at the input wrench_at(i), its torque 3 later.
template <int soles>
struct Contacts {
  const Body* body;
  std::array<Contact, static_cast<std::size_t>(soles)> contacts;

  static constexpr int wrench_at(int i) { return coordinates + 6 * i; }
  const Contact& operator[](int i) const { return contacts[static_cast<std::size_t>(i)]; }
};

// Component of a vector (world axes) along an axis of the contact.
template <class S, class V>
S along(const Contact& contact, int axis, const V& v) {
  S sum(0.0);
  for (int j = 0; j < 3; ++j)
    if (contact.place.rotation(j, axis) != 0.0) sum += contact.place.rotation(j, axis) * v[j];
  return sum;
}

template <int soles>
struct Dynamics : Contacts<soles> {
  template <class S, int nx, int nu>
  Vec<S, nx> operator()(const S&, const Vec<S, nx>& x, const Vec<S, nu>& u) const {
    Vec<S, 3> force(S(0.0), S(0.0), S(-1.0)), torque(S(0.0), S(0.0), S(0.0));
    for (int i = 0; i < soles; ++i) {
      const int at = this->wrench_at(i);
      const Vec<S, 3> f = u.template segment<3>(at);
      Vec<S, 3> arm;
      for (int j = 0; j < 3; ++j) arm[j] = place_of<S>((*this)[i], j, x) - x[j];
      force += f;
      torque += arm.cross(f) + u.template segment<3>(at + 3);
    }
    Vec<S, nx> rate;
    for (int j = 0; j < 3; ++j) {
      rate[j] = x[3 + j];
      rate[3 + j] = standard_gravity * force[j];
      rate[6 + j] = standard_gravity * torque[j];
    }
    for (int j = place_at; j < nx - coordinates; ++j) rate[j] = u[inputs<soles> + j - place_at];
    for (int j = 0; j < coordinates; ++j) rate[nx - coordinates + j] = u[j];
    return rate;
  }
};

// com(q) - c, then for each contact its distance from its place and its rotation.
template <int soles>
struct Pose : Contacts<soles> {
  template <class S, int nx>
  Vec<S, 3 + 6 * soles> operator()(const S&, const Vec<S, nx>& x) const {
    const Robot<S> robot(this->body->tree, q_of(x));
    Vec<S, 3 + 6 * soles> y;
    y.template head<3>() = robot.com() - x.template head<3>();
    for (int i = 0; i < soles; ++i) {
      const Contact& contact = (*this)[i];
      const int row = 3 + 6 * i;
      const Vec<S, 3> p = robot.position(contact.frame);
      for (int j = 0; j < 3; ++j) y[row + j] = p[j] - place_of<S>(contact, j, x);
      const Mat<S, 3, 3> axes = robot.rotation(contact.frame);
      y[row + 3] = along<S>(contact, 2, axes.col(0));
      y[row + 4] = along<S>(contact, 2, axes.col(1));
      y[row + 5] = along<S>(contact, 1, axes.col(0));
    }
    return y;
  }
};

struct Momentum {
  const Body* body;
  template <class S, int nx, int nu>
  Vec<S, 3> operator()(const S&, const Vec<S, nx>& x, const Vec<S, nu>& u) const {
    const Vec<S, 3> momentum = Robot<S>(body->tree, q_of(x), u).angular_momentum();
    Vec<S, 3> y;
    for (int j = 0; j < 3; ++j) y[j] = (1.0 / body->tree.mass) * momentum[j] - x[6 + j];
    return y;
  }
};

// Friction pyramid, centre of pressure and yaw torque of each sole. All rows >= 0.
template <int soles>
struct Cones : Contacts<soles> {
  Options options;
  template <class S, int nx, int nu>
  Vec<S, 10 * soles> operator()(const S&, const Vec<S, nx>&, const Vec<S, nu>& u) const {
    Vec<S, 10 * soles> y;
    int row = 0;
    const auto pair = [&](const S& limit, const S& value) {
      y[row++] = limit - value;
      y[row++] = limit + value;
    };
    for (int i = 0; i < soles; ++i) {
      const Contact& contact = (*this)[i];
      const int at = this->wrench_at(i);
      const auto force = [&](int axis) {
        return along<S>(contact, axis, u.template segment<3>(at));
      };
      const auto torque = [&](int axis) {
        return along<S>(contact, axis, u.template segment<3>(at + 3));
      };
      const robots::FootRectangle& sole = contact.rectangle;
      const S load = force(2), roll = torque(0), pitch = torque(1);
      pair(options.friction * load, force(0));
      pair(options.friction * load, force(1));
      y[row++] = (sole.y.upper - options.margin) * load - roll;
      y[row++] = roll - (sole.y.lower + options.margin) * load;
      y[row++] = (sole.x.upper - options.margin) * load + pitch;
      y[row++] = -pitch - (sole.x.lower + options.margin) * load;
      pair(options.torsion * load, torque(2));
    }
    return y;
  }
};

// Normal forces, in weights.
template <int soles>
struct Loads : Contacts<soles> {
  template <class S, int nx, int nu>
  Vec<S, soles> operator()(const S&, const Vec<S, nx>&, const Vec<S, nu>& u) const {
    Vec<S, soles> y;
    for (int i = 0; i < soles; ++i)
      y[i] = along<S>((*this)[i], 2, u.template segment<3>(this->wrench_at(i)));
    return y;
  }
};

// Torques of the joints that balance weight and wrenches at rest, over their limits.
template <int soles>
struct Torques : Contacts<soles> {
  template <class S, int nx, int nu>
  Vec<S, joints> operator()(const S&, const Vec<S, nx>& x, const Vec<S, nu>& u) const {
    const Tree& tree = this->body->tree;
    const double weight = tree.mass * standard_gravity;
    std::array<robots::WrenchAt<S>, static_cast<std::size_t>(soles)> wrenches;
    for (int i = 0; i < soles; ++i) {
      robots::WrenchAt<S>& wrench = wrenches[static_cast<std::size_t>(i)];
      wrench.frame = (*this)[i].frame;
      for (int j = 0; j < 3; ++j) {
        wrench.force[j] = weight * u[this->wrench_at(i) + j];
        wrench.torque[j] = weight * u[this->wrench_at(i) + 3 + j];
      }
    }
    const Vec<double, coordinates> rest = Vec<double, coordinates>::Zero();
    const Vec<S, coordinates> all =
        robots::inverse_dynamics<S>(tree, q_of(x), rest, rest, standard_gravity,
                                    std::span<const robots::WrenchAt<S>>(wrenches));
    Vec<S, joints> y;
    for (int i = 0; i < joints; ++i) y[i] = (1.0 / this->body->strongest[i]) * all[6 + i];
    return y;
  }
};

// Heights of toe and heel of a foot, and the x of its toe, m.
struct ToeAndHeel {
  const Body* body;
  int foot;
  template <class S, int nx>
  Vec<S, 3> operator()(const S&, const Vec<S, nx>& x) const {
    const Robot<S> robot(body->tree, q_of(x));
    const Vec<S, 3> p = robot.position(body->soles[foot]);
    const Mat<S, 3, 3> axes = robot.rotation(body->soles[foot]);
    const Bounds along = body->feet[foot].x;
    return {p[2] + along.upper * axes(2, 0), p[2] + along.lower * axes(2, 0),
            p[0] + along.upper * axes(0, 0)};
  }
};

// Squared distances of all pairs of spheres of the two legs minus those at touch, m^2.
constexpr int leg_spheres = 5;
struct LegsApart {
  const Body* body;
  template <class S, int nx>
  Vec<S, leg_spheres * leg_spheres> operator()(const S&, const Vec<S, nx>& x) const {
    const Robot<S> robot(body->tree, q_of(x));
    std::array<Vec<S, 3>, leg_spheres> centres[2];
    for (int side = 0; side < 2; ++side)
      for (std::size_t i = 0; i < leg_spheres; ++i) {
        const Body::Sphere& sphere = body->legs[side][i];
        centres[side][i] = robot.position(sphere.body, sphere.centre);
      }
    Vec<S, leg_spheres * leg_spheres> y;
    int row = 0;
    for (std::size_t i = 0; i < leg_spheres; ++i)
      for (std::size_t k = 0; k < leg_spheres; ++k) {
        const double touch = body->legs[0][i].radius + body->legs[1][k].radius;
        S sum(-touch * touch);
        for (int j = 0; j < 3; ++j) {
          const S d = centres[0][i][j] - centres[1][k][j];
          sum += d * d;
        }
        y[row++] = sum;
      }
    return y;
  }
};

// State of the task with the centre of mass of q, at rest.
VectorXd state_at_rest(const Body& body, const Task& task, const VectorXd& q) {
  VectorXd x = VectorXd::Zero(task.size());
  x.head<3>() = Robot<double>(body.tree, q).com();
  if (task.choice) x.segment<2>(place_at) = task.choice->expected;
  x.tail<coordinates>() = q;
  return x;
}

// `places`: 2 if a place is chosen, else 0.
template <int soles, int places>
auto phase_of(const Body& body, const Task& task, const Mode& mode, const VectorXd& begin,
              const Options& options) {
  constexpr int nx = states + places, nu = inputs<soles> + places;
  Contacts<soles> contacts{&body, {}};
  std::copy_n(mode.contacts.begin(), soles, contacts.contacts.begin());

  Phase<nx, nu> phase{mode.name, Dynamics<soles>{contacts}, mode.duration};
  phase.keep("pose", Pose<soles>{contacts}, exactly(0.0))
      .keep("momentum", Momentum{&body}, exactly(0.0))
      .keep("torques", Torques<soles>{contacts}, between(-options.torque, options.torque));
  if constexpr (soles > 0)
    phase.keep("cones", Cones<soles>{{contacts}, options}, at_least(0.0))
        .keep("loads", Loads<soles>{contacts}, between(0.0, options.largest_force));
  for (const int foot : mode.swings) {
    const ToeAndHeel heights{&body, foot};
    const std::string name = foot == 0 ? "left foot" : "right foot";
    const Bounds low = at_least(mode.lowest), x = mode.behind ? at_most(*mode.behind) : Bounds{};
    phase.keep(name + " above the ground", heights, {low, low, x})
        .allow(name + " above the ground", options.height_between);
    if (mode.above)
      phase.reach(name + " raised", heights, {at_least(*mode.above), at_least(*mode.above), x});
  }
  if (!mode.swings.empty())
    phase.keep("legs apart", LegsApart{&body}, at_least(0.0)).allow("legs apart", 1e-3);
  // Rows hold at the nodes. Between them rates and wrenches are constant, so the soles move a
  // little.
  phase.allow("pose", options.pose_between)
      .allow("momentum", options.spin_between)
      .allow("torques", options.torque_between);
  for (int i = 0; i < joints; ++i) {
    phase.bound_state(nx - joints + i, between(body.lowest[i], body.highest[i]));
    phase.bound_input(6 + i,
                      between(-options.speed * body.fastest[i], options.speed * body.fastest[i]));
  }
  for (int i = 0; i < 3; ++i) {
    phase.bound_input(i, between(-2.0, 2.0));      // m/s
    phase.bound_input(3 + i, between(-5.0, 5.0));  // rad/s
  }

  if constexpr (places > 0) {
    const Bounds rate = mode.chooses ? between(-2.0, 2.0) : exactly(0.0);  // m/s
    for (int i = 0; i < 2; ++i) phase.bound_input(inputs<soles> + i, rate);
    const Task::Choice choice = task.choice.value_or(Task::Choice{});
    phase.bound_state(place_at, choice.x).bound_state(place_at + 1, choice.y);
    phase.track(
        "chosen place",
        [](const auto&, const auto& x) { return x.template segment<2>(place_at).eval(); },
        Vec<double, 2>::Constant(options.place), {}, VectorXd(choice.expected));
  }

  Vec<double, 3 + joints> weights, posture;
  weights << Vec<double, 3>::Constant(options.upright),
      Vec<double, joints>::Constant(options.posture);
  posture << 0.0, 0.0, mode.end[5], body.nominal;
  Vec<double, nu> effort = Vec<double, nu>::Constant(options.rates), even = Vec<double, nu>::Zero();
  for (int i = 0; i < soles; ++i) {
    const int at = contacts.wrench_at(i);
    effort.template segment<3>(at).setConstant(options.force);
    effort.template segment<3>(at + 3).setConstant(options.moment);
    even[at + 2] = 1.0 / soles;
  }
  effort.template tail<places>().setConstant(options.place_rate);
  Vec<double, nx> state_sizes = Vec<double, nx>::Ones();
  state_sizes.template segment<3>(3).setConstant(0.5);  // m/s
  state_sizes.template segment<3>(6).setConstant(0.1);  // m^2/s
  Vec<double, nu> input_sizes = Vec<double, nu>::Ones();
  for (int i = 0; i < soles; ++i)
    input_sizes.template segment<3>(contacts.wrench_at(i) + 3).setConstant(0.05);  // m
  phase.nominal(state_sizes, input_sizes).nominal_duration(0.3);
  phase
      .track(
          "posture",
          [](const auto&, const auto& x) { return x.template tail<3 + joints>().eval(); }, weights,
          {}, VectorXd(posture))
      .track(
          "effort", [](const auto&, const auto&, const auto& u) { return u; }, effort, {},
          VectorXd(even))
      .track(
          "spin", [](const auto&, const auto& x) { return x.template segment<3>(6).eval(); },
          Vec<double, 3>::Constant(options.spin))
      .guess_state(
          Guess::interpolate(state_at_rest(body, task, begin), state_at_rest(body, task, mode.end)))
      .guess_input(Guess::constant(even))
      .guess_duration(mode.usual);
  if (task.periodic || &mode != &task.modes.back()) return phase;
  // A chosen place moves the goal by half of its distance from the expected one.
  Vec<double, 2> goal = task.goal;
  if constexpr (places > 0) goal -= 0.5 * task.choice.value_or(Task::Choice{}).expected;
  phase
      .reach(
          "at rest", [](const auto&, const auto& x) { return x.template segment<6>(3).eval(); },
          exactly(0.0))
      .reach(
          "place",
          [goal](const auto&, const auto& x) {
            using S = std::decay_t<decltype(x[0])>;
            Vec<S, 2> off(x[0] - goal[0], x[1] - goal[1]);
            if constexpr (places > 0)
              for (int j = 0; j < 2; ++j) off[j] -= 0.5 * x[place_at + j];
            return off;
          },
          between(-0.02, 0.02));
  return phase;
}

template <int soles>
void append(OptimalControlProblem& ocp, const Body& body, const Task& task, const Mode& mode,
            const VectorXd& begin, const Options& options) {
  if (task.choice)
    ocp.then(phase_of<soles, 2>(body, task, mode, begin, options));
  else
    ocp.then(phase_of<soles, 0>(body, task, mode, begin, options));
}

}  // namespace

OptimalControlProblem problem(const Body& body, const Task& task, const Options& options) {
  OptimalControlProblem ocp(task.name);
  const VectorXd start = state_at_rest(body, task, task.start);
  if (task.periodic)
    ocp.start_within(std::vector<Bounds>(static_cast<std::size_t>(task.size())), start);
  else
    ocp.start_at(start);

  const VectorXd* begin = &task.start;
  for (const Mode& mode : task.modes) {
    switch (mode.contacts.size()) {
      case 0:
        append<0>(ocp, body, task, mode, *begin, options);
        break;
      case 1:
        append<1>(ocp, body, task, mode, *begin, options);
        break;
      default:
        append<2>(ocp, body, task, mode, *begin, options);
    }
    begin = &mode.end;
  }
  if (task.periodic) {
    const double stride = task.stride;
    ocp.close(jump<states>("stride", [stride](const auto&, const auto& x) {
      auto next = x;
      next[0] -= stride;
      next[place_at] -= stride;  // x of the base
      return next;
    }));
  }
  return ocp;
}

}  // namespace saltus::whole_body
