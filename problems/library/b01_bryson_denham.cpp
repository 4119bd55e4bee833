// Bryson and Denham's block must not rise above a ceiling. The minimum effort brings it from the
// ground back to the ground in one second.
//
//   min 1/2 int u^2   x' = v, v' = u   x(0) = x(1) = 0, v(0) = 1, v(1) = -1, x <= l = 1/9
//
// For l <= 1/6 the block rises until it touches the ceiling at t = 3 l, slides along it with u = 0,
// and leaves it at 1 - 3 l; J = 4 / (9 l) = 4 exactly. On both outer arcs u is linear in t. No
// constraint requires the middle phase to touch the ceiling: this is optimal.
// Guess: the constant start, no input, 0.3 s per phase.
// Source: Bryson and Ho, Applied Optimal Control, sec. 3.11.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double ceiling_height = 1.0 / 9.0;  // m

struct Block {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0]};
  }
};

OptimalControlProblem problem() {
  const auto effort = [](const auto&, const auto&, const auto& u) { return 0.5 * u[0] * u[0]; };
  const auto height = [](const auto&, const auto& x) { return x[0]; };
  const auto speed = [](const auto&, const auto& x) { return x[1]; };
  const Bounds part = between(0.05, 0.9);  // s, of one second

  Phase<2, 1> climb{"climb", Block{}, part};
  climb.keep("ceiling", height, at_most(ceiling_height))
      .minimise("effort", effort)
      .reach("no impact", speed, exactly(0.0));

  Phase<2, 1> slide{"along the ceiling", Block{}, part};
  slide.bound_input(0, exactly(0.0));

  Phase<2, 1> descend{"descend", Block{}, part};
  descend.keep("ceiling", height, at_most(ceiling_height))
      .minimise("effort", effort)
      .reach("ground", height, exactly(0.0))
      .reach("landing speed", speed, exactly(-1.0));

  for (auto* phase : {&climb, &slide, &descend})
    phase->inputs(InputParametrisation::piecewise_linear_continuous).guess_duration(0.3);
  OptimalControlProblem ocp("Bryson-Denham");
  ocp.start_at({0, 1}).then(climb).then(slide).then(descend);
  ocp.total_time(exactly(1.0));
  return ocp;
}

}  // namespace

ReferenceCase bryson_denham() {
  return {.id = "B01",
          .name = "bryson_denham",
          .summary = "Bryson and Denham's block, which must not rise above a ceiling.",
          .states = {"position", "speed"},
          .inputs = {"acceleration"},
          .exercises = "three phases of free duration, their sum given, piecewise linear inputs",
          .source = "Bryson and Ho, Applied Optimal Control, sec. 3.11; closed form",
          .problem = problem,
          // States are cubic, costs quadratic: one step of order four per interval is exact.
          .options = {.intervals_per_phase = 10, .integrator = runge_kutta4()},
          .optimum = 4.0,
          .digits = 16,
          .tolerance = 1e-8,  // tolerance of the solver; transcription and integration are exact
          .switching_times = {1.0 / 3.0, 2.0 / 3.0},
          .between_nodes = 1e-10};  // plans above the ceiling between the nodes are cheaper
}

}  // namespace saltus::library
