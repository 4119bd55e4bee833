// A ball under gravity is juggled with minimum effort. After one second and one bounce it returns
// to its start.
//
//   min 1/2 int_0^1 u^2   q'' = u - 9.81   (q, v)(0) = (q, v)(1) = (1, 0), q >= 0
//   at the impact, q = 0:  v+ = -0.8 v-
//
// The time of the impact is free. On each flight the optimal u is linear in time and costs 2 a^2 /
// T - 6 a d / T^2 + 6 d^2 / T^3, where d = q1 + g T^2 / 2 - q0 - v0 T and a = v1 + g T - v0. The
// time and the speed of the impact minimise a function of two variables.
// Guess: the constant start, no input, half a second per flight.
// Source: constructed; closed form as above.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double gravity = 9.81;     // m/s^2
constexpr double restitution = 0.8;  // ratio of the speeds

struct Ball {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - gravity};
  }
};

OptimalControlProblem problem() {
  const auto effort = [](const auto&, const auto&, const auto& u) { return 0.5 * u[0] * u[0]; };
  const auto height = [](const auto&, const auto& x) { return x[0]; };
  const auto speed = [](const auto&, const auto& x) { return x[1]; };
  const auto bounce = [](const auto&, const auto& x) {
    return decltype(x.eval()){x[0], -restitution * x[1]};
  };
  const Bounds flight = between(0.1, 0.9);  // s

  Phase<2, 1> fall{"fall", Ball{}, flight};
  fall.ends_when("impact", height, Crossing::falling);
  Phase<2, 1> rise{"rise", Ball{}, flight};
  rise.reach("back", height, exactly(1.0)).reach("at rest", speed, exactly(0.0));

  for (auto* phase : {&fall, &rise})
    phase->inputs(InputParametrisation::piecewise_linear_continuous)
        .keep("ground", height, at_least(0.0))
        .minimise("effort", effort)
        .guess_duration(0.5);
  OptimalControlProblem ocp("juggled ball");
  ocp.start_at({1, 0}).then(fall).then(rise, jump<2>("bounce", bounce));
  ocp.total_time(exactly(1.0));
  return ocp;
}

constexpr double impact_time = 0.470504556810741;    // s
constexpr double impact_speed = -4.640109107887904;  // m/s

std::vector<CheckedValue> more(const Solution& solution) {
  const VectorXd before = solution.trajectory.state_before(solution.durations[0]);
  constexpr double of_impact = 1e-9;  // the last Newton step is far below the solver's 1e-10
  return {{"t1", solution.durations[0], impact_time, of_impact, 15},
          {"v-", before[1], impact_speed, of_impact, 16}};
}

}  // namespace

ReferenceCase juggled_ball() {
  return {.id = "A20",
          .name = "juggled_ball",
          .summary = "A ball is juggled with minimum effort: one bounce, then back to its start.",
          .states = {"height [m]", "speed [m/s]"},
          .inputs = {"thrust [m/s^2]"},
          .exercises = "a phase that ends by a guard, a jump of the state, a free impact time",
          .source = "constructed; closed form",
          .problem = problem,
          // States are cubic, costs quadratic: one step of order four per interval is exact.
          .options = {.intervals_per_phase = 10, .integrator = runge_kutta4()},
          .optimum = 2.570651595764464,
          .digits = 16,
          .tolerance = 1e-10,  // tolerance of the solver; transcription and integration are exact
          .switching_times = {impact_time},
          .switching_tolerance = 1e-9,
          .more = more};
}

}  // namespace saltus::library
