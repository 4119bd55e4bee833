// A hang glider crosses a thermal and maximises its range while it loses 100 m of height.
//
//   max x(T)   x' = vx, y' = vy, m vx' = -L w/V - D vx/V, m vy' = L vx/V - D w/V - m g
//   updraft    U = 2.5 (1 - r) exp(-r), r = (x/100 - 2.5)^2
//   airspeed   w = vy - U, V = sqrt(vx^2 + w^2)
//   forces     D = 1/2 (0.034 + 0.069662 cL^2) rho S V^2, L = 1/2 cL rho S V^2
//   (x, y, vx, vy)(0) = (0, 1000, 13.23, -1.288), (y, vx, vy)(T) = (900, 13.23, -1.288)
//
// The input is the lift coefficient, 0 <= cL <= 1.4; T is free; rho = 1.13, S = 14, m = 100. In the
// middle of the thermal the lift is at its bound: this is a separate phase of free duration. At
// another place such a phase gives a worse optimum, so the bounds of the durations keep it there.
// Guess: a straight glide to x = 1250, y = 900 at the given speeds, cL = 1, each duration in the
// middle of its interval, 102.5 s in total.
// Source: COPS 3.1, "hang glider", after Bulirsch, Nerz, Pesch and von Stryk 1993. COPS finds
// 1248.03 on a coarse grid; the optimum was computed independently.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double most_lift = 1.4;  // lift coefficient

struct Glider {                           // x = (x, y, vx, vy), u = cL
  double mass = 100.0;                    // kg
  double gravity = 9.81;                  // m/s^2
  double half_rho_S = 0.5 * 1.13 * 14.0;  // kg/m
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 1>& u) const {
    const S from_centre = x[0] / 100.0 - 2.5, r = from_centre * from_centre;
    const S w = x[3] - 2.5 * (1.0 - r) * exp(-r);
    const S V = sqrt(x[2] * x[2] + w * w);
    const S D = (0.034 + 0.069662 * u[0] * u[0]) * half_rho_S * V;  // drag over V, N s/m
    const S L = u[0] * half_rho_S * V;
    return {x[2], x[3], (-L * w - D * x[2]) / mass, (L * x[2] - D * w) / mass - gravity};
  }
};

OptimalControlProblem problem() {
  const auto minus_range = [](const auto&, const auto& x) { return -x[0]; };
  const auto rest = [](const auto&, const auto& x) {
    return Vec<std::decay_t<decltype(x[0])>, 3>{x[1], x[2], x[3]};
  };
  const Vec<double, 4> start{0, 1000, 13.23, -1.288}, end{1250, 900, 13.23, -1.288};

  Phase<4, 1> approach{"approach", Glider{}, between(10.0, 25.0)};
  approach.bound_input(0, between(0.0, most_lift));
  Phase<4, 1> thermal{"most lift", Glider{}, between(5.0, 20.0)};
  thermal.bound_input(0, exactly(most_lift));
  Phase<4, 1> glide{"glide", Glider{}, between(45.0, 100.0)};
  glide.bound_input(0, between(0.0, most_lift))
      .reach("end", rest, {exactly(end[1]), exactly(end[2]), exactly(end[3])})
      .minimise_at_end("range", minus_range);

  OptimalControlProblem ocp("hang glider");
  ocp.start_at(start);
  double t = 0.0;  // s, in the guess
  for (auto* phase : {&approach, &thermal, &glide}) {
    const double duration = phase->definition().duration_guess;
    const auto at = [&](double s) -> Vec<double, 4> { return start + s / 102.5 * (end - start); };
    phase->inputs(InputParametrisation::piecewise_linear_continuous)
        .nominal(Vec<double, 4>{1000, 1000, 10, 10}, Vec<double, 1>{1})
        .nominal_duration(100.0)
        .guess_state(Guess::interpolate(at(t), at(t + duration)))
        .guess_input(Guess::constant(Vec<double, 1>{1.0}));
    t += duration;
    ocp.then(*phase);
  }
  return ocp;
}

std::vector<CheckedValue> more(const Solution& solution) {
  return {{"T", solution.trajectory.end_time(), 98.4166, 1e-3, 6}};  // the cost is flat in T
}

}  // namespace

ReferenceCase hang_glider() {
  return {
      .id = "B12",
      .name = "hang_glider",
      .summary = "Maximum range of a hang glider that crosses a thermal.",
      .states = {"distance [m]", "height [m]", "horizontal speed [m/s]", "vertical speed [m/s]"},
      .inputs = {"lift coefficient"},
      .exercises = "free durations of all phases, an input at its bound, an uneven force field",
      .source = "COPS 3.1, hang glider; optimum computed independently",
      .problem = problem,
      .options = {.intervals = {30, 12, 50}, .integrator = runge_kutta8({.steps = 4})},
      .optimum = -1247.9876,
      .digits = 8,
      .tolerance = 1e-6,  // piecewise linear inputs cost an excess of order h^4: 3e-7
      .more = more,
      // Steps of at most five seconds: in longer ones the forces overshoot.
      .derivatives = {.intervals = 15}};
}

}  // namespace saltus::library
