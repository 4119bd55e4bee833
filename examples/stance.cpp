// Two straight legs and a pelvis stand on both feet and form a closed chain of four bars with the
// ground. The torques at left ankle and hip sway the pelvis to the right in 0.8 s. At least 70 % of
// the weight is on the right foot from 0.6 s on, and never more than 90 %.
//
// The chain is cut at the right foot. Its position c(q) = 0 is a constraint of index 3. The second
// derivative, with terms that damp drift, has index 1:
//   M(q) a + C(q, q') + G(q) = B u + J(q)' F,   J a + J' q' + 2 w J q' + w^2 c = 0,
// with the accelerations a and the force F on the right foot as algebraic states z.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <saltus/saltus.hpp>

using namespace saltus;

constexpr int bars = 3;                                          // left leg, pelvis, right leg
constexpr double length[bars] = {0.8, 0.3, 0.8};                 // m
constexpr double mass[bars] = {8.0, 30.0, 8.0};                  // kg
constexpr double gravity = 9.81, stance = 0.36, damping = 10.0;  // m/s^2, m, 1/s
// Centre k lies at sum_i centre[k][i] length[i] (cos q_i, sin q_i) from the left foot, the right
// foot at the sum with `foot`; q_i are angles against the ground.
constexpr double centre[bars][bars] = {{0.5, 0.0, 0.0}, {1.0, 0.5, 0.0}, {1.0, 1.0, -0.5}};
constexpr double foot[bars] = {1.0, 1.0, -1.0};

struct Motion {  // x = (q | q'), z = (a | F)
  template <class S>
  Vec<S, 6> operator()(const S&, const Vec<S, 6>& x, const Vec<S, 5>& z) const {
    return {x[3], x[4], x[5], z[0], z[1], z[2]};
  }
};

// Position error of the right foot, m.
const auto gap = [](const auto&, const auto& x) {
  using S = std::decay_t<decltype(x[0])>;
  Vec<S, 2> c{-stance, 0.0};
  for (int i = 0; i < bars; ++i) {
    c[0] += foot[i] * length[i] * cos(x[i]);
    c[1] += foot[i] * length[i] * sin(x[i]);
  }
  return c;
};

struct Chain {
  template <class S>
  Vec<S, 5> operator()(const S& t, const Vec<S, 6>& x, const Vec<S, 5>& z,
                       const Vec<S, 2>& u) const {
    Vec<S, 5> off;
    for (int i = 0; i < bars; ++i) {
      off[i] = -foot[i] * length[i] * (cos(x[i]) * z[4] - sin(x[i]) * z[3]);
      for (int k = 0; k < bars; ++k)
        off[i] += mass[k] * centre[k][i] * length[i] * gravity * cos(x[i]);
      off[i] += mass[i] * length[i] * length[i] / 12.0 * z[i];
      for (int j = 0; j < bars; ++j) {
        double inertia = 0.0;
        for (int k = 0; k < bars; ++k)
          inertia += mass[k] * centre[k][i] * centre[k][j] * length[i] * length[j];
        off[i] += inertia * (cos(x[i] - x[j]) * z[j] + sin(x[i] - x[j]) * x[3 + j] * x[3 + j]);
      }
    }
    off[0] -= u[0] - u[1];
    off[1] -= u[1];
    const Vec<S, 2> c = gap(t, x);
    for (int axis = 0; axis < 2; ++axis) off[3 + axis] = damping * damping * c[axis];
    for (int i = 0; i < bars; ++i) {
      const S along = foot[i] * length[i] * cos(x[i]), across = foot[i] * length[i] * sin(x[i]);
      const S rate = x[3 + i], bend = z[i] + 2.0 * damping * rate;
      off[3] += -across * bend - along * rate * rate;
      off[4] += along * bend - across * rate * rate;
    }
    return off;
  }
};

int main() {
  // Guess: symmetric, both legs leaning inwards; then swayed to the right.
  const double lean = std::acos((stance - length[1]) / 2.0 / length[0]);
  const VectorXd upright{{lean, 0.0, M_PI - lean, 0.0, 0.0, 0.0}};
  const double weight = (mass[0] + mass[1] + mass[2]) * gravity;

  Phase<6, 2, 0, 5> shift{"shift", Motion{}, Chain{},
                          Vec<double, 5>{1.0, 1.0, 1.0, 10.0, 0.5 * weight}, exactly(0.8)};
  shift
      .minimise("effort", [](const auto&, const auto&, const auto&,
                             const auto& u) { return 1e-4 * (u[0] * u[0] + u[1] * u[1]); })
      .bound_algebraic(4, between(0.1 * weight, 0.9 * weight))
      .keep("on the right foot", [](const auto&, const auto&, const auto& z) { return z[4]; },
            at_least(0.7 * weight), {.from = 0.6})
      .reach(
          "lean to the right", [](const auto&, const auto& x) { return x[0]; },
          exactly(lean - 0.12))
      .reach(
          "at rest", [](const auto&, const auto& x) { return x[3]; }, exactly(0.0))
      .bound_input(0, between(-25.0, 25.0))  // the sole is narrow
      .nominal(VectorXd::Ones(6), VectorXd::Constant(2, 50.0))
      .guess_state(Guess::constant(upright));
  OptimalControlProblem ocp("shift of weight");
  ocp.start_at(upright).then(shift);

  const Solution plan =
      solve(ocp, {.intervals_per_phase = 40, .integrator = gauss_legendre({.stages = 2})});
  double opened = 0.0;
  std::ofstream table("stance.csv");
  table << "t [s],phase,left leg [rad],right leg [rad],weight on the right foot [1],"
           "torque ankle [N m],torque hip [N m]\n";
  for (const Trajectory::Piece& piece : plan.trajectory.pieces()) {
    const double t = piece.start;
    const VectorXd x = plan.trajectory.state(t), z = plan.trajectory.algebraic(t),
                   u = plan.trajectory.input(t);
    opened = std::max(opened, gap(t, x).norm());
    table << t << ",shift," << x[0] << ',' << x[2] << ',' << z[4] / weight << ',' << u[0] << ','
          << u[1] << '\n';
  }
  std::printf("%s: effort %.4f, the chain opened by %.1e m\n", plan.message.c_str(), plan.cost,
              opened);
  return plan.ok() && opened < 1e-6 ? 0 : 1;
}
