// Bryson and Denham's block (B01) under other ceilings, and as one phase.
//
//   min 1/2 int u^2   x' = v, v' = u   x(0) = x(1) = 0, v(0) = 1, v(1) = -1, x <= l
//
// l = 1/12: the block slides along the ceiling from t = 1/4 to 3/4, J = 4 / (9 l) = 16/3. l = 1/5:
// it touches the ceiling once, at t = 1/2, J = 2 + 6 (1 - 4 l)^2 = 2.24 (for 1/6 <= l <= 1/4). Both
// have their kinks at nodes. As three arcs: climb, slide with u = 0, descend, with free durations.
// Guess: the constant start, no input, 0.3 s per arc.
// Source: Bryson and Ho, Applied Optimal Control, sec. 3.11; closed forms.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Block {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0]};
  }
};

constexpr auto effort = [](const auto&, const auto&, const auto& u) { return 0.5 * u[0] * u[0]; };
constexpr auto height = [](const auto&, const auto& x) { return x[0]; };
constexpr auto speed = [](const auto&, const auto& x) { return x[1]; };

// `allowed`: permitted violation of the ceiling between the nodes; 0: the default.
OptimalControlProblem one_phase(double ceiling, double allowed = 0.0) {
  Phase<2, 1> hop{"hop", Block{}, exactly(1.0)};
  hop.keep("ceiling", height, at_most(ceiling))
      .minimise("effort", effort)
      .reach("ground", height, exactly(0.0))
      .reach("landing speed", speed, exactly(-1.0))
      .inputs(InputParametrisation::piecewise_linear_continuous);
  if (allowed > 0.0) hop.allow("ceiling", allowed);
  OptimalControlProblem ocp("Bryson-Denham, one phase");
  ocp.start_at({0, 1}).then(hop);
  return ocp;
}

OptimalControlProblem three_arcs() {
  const Bounds part = between(0.05, 0.9);  // s, of one second
  Phase<2, 1> climb{"climb", Block{}, part};
  climb.keep("ceiling", height, at_most(1.0 / 12.0))
      .minimise("effort", effort)
      .reach("no impact", speed, exactly(0.0));
  Phase<2, 1> slide{"along the ceiling", Block{}, part};
  slide.bound_input(0, exactly(0.0));
  Phase<2, 1> descend{"descend", Block{}, part};
  descend.keep("ceiling", height, at_most(1.0 / 12.0))
      .minimise("effort", effort)
      .reach("ground", height, exactly(0.0))
      .reach("landing speed", speed, exactly(-1.0));
  for (auto* phase : {&climb, &slide, &descend})
    phase->inputs(InputParametrisation::piecewise_linear_continuous).guess_duration(0.3);
  OptimalControlProblem ocp("Bryson-Denham, three arcs");
  ocp.start_at({0, 1}).then(climb).then(slide).then(descend);
  ocp.total_time(exactly(1.0));
  return ocp;
}

ReferenceCase common() {
  ReferenceCase c;
  c.states = {"position", "speed"};
  c.inputs = {"acceleration"};
  c.source = "Bryson and Ho, Applied Optimal Control, sec. 3.11; closed form";
  c.digits = 16;
  return c;
}

}  // namespace

ReferenceCase low_ceiling() {
  ReferenceCase c = common();
  c.id = "B02a";
  c.name = "low_ceiling";
  c.summary = "Bryson and Denham's block under a lower ceiling.";
  c.exercises = "a state constraint of second order along an arc";
  c.between_nodes = 1e-4;  // next to the arc, whose ends are not nodes
  c.problem = [] { return one_phase(1.0 / 12.0, 1e-4); };
  c.options = {.intervals_per_phase = 40, .integrator = runge_kutta4()};
  c.optimum = 16.0 / 3.0;
  c.tolerance = 1e-6;  // next to the arc the plan exceeds the ceiling by 2e-5
  return c;
}

ReferenceCase touched_ceiling() {
  ReferenceCase c = common();
  c.id = "B02b";
  c.name = "touched_ceiling";
  c.summary = "Bryson and Denham's block under a ceiling that it touches once.";
  c.exercises = "a state constraint of second order at a point";
  c.problem = [] { return one_phase(0.2); };
  c.options = {.intervals_per_phase = 40, .integrator = runge_kutta4()};
  c.optimum = 2.24;
  c.tolerance = 1e-8;  // tolerance of the solver; transcription and integration are exact
  return c;
}

ReferenceCase low_ceiling_arcs() {
  ReferenceCase c = common();
  c.id = "B02c";
  c.name = "low_ceiling_arcs";
  c.summary = "Bryson and Denham's block under a lower ceiling, in three arcs.";
  c.exercises = "three phases of free duration, an arc with linearly dependent rows";
  c.problem = three_arcs;
  // With 20 intervals the sparse solver stopped 1.8e-4 s from the optimal switch on one of several
  // processors: with dependent rows, rounding errors change the step lengths.
  c.options = {.intervals_per_phase = 18, .integrator = runge_kutta4()};
  c.optimum = 16.0 / 3.0;
  c.tolerance = 1e-8;  // tolerance of the solver; transcription and integration are exact
  c.switching_times = {0.25, 0.75};
  c.between_nodes = 1e-10;  // plans above the ceiling between the nodes are cheaper
  return c;
}

}  // namespace saltus::library
