// A point robot tracks a path with a corner: one second along x, then one second along y.
//
//   min int 100 |r - r_ref|^2 + 500 |v - v_ref|^2   r'' = u, |u_i| <= 10
//   r_ref = (t/2, 0), v_ref = (1/2, 0) until t = 1, then (1/2, (t - 1)/2) and (0, 1/2)
//   (r, v)(0) = (0, 0, 1/2, 0), (r, v)(2) = (1/2, 1/2, 0, 1/2)
//
// The input has no cost, so it is singular: v'' follows from the costs, except for a bang of 0.05 s
// at the corner and a very short one at each end. The program is a convex quadratic program.
// Guess: the constant start, no input.
// Source: Becerra, PSOPT examples, "two-phase path tracking robot", whose coarse grids give
// 1.042568 and 1.042533; the optimum was computed independently.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Robot {  // x = (r, v)
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 2>& u) const {
    return {x[2], x[3], u[0], u[1]};
  }
};

OptimalControlProblem problem() {
  const Vec<double, 4> weights{200, 200, 1000, 1000};  // the cost has a factor of 1/2
  const auto state = [](const auto&, const auto& x) { return x; };

  Phase<4, 2> along_x{"along x", Robot{}, exactly(1.0)};
  along_x.track(
      "path",
      [](const auto& t, const auto& x) {
        return decltype(x.eval()){x[0] - 0.5 * t, x[1], x[2] - 0.5, x[3]};
      },
      weights);
  Phase<4, 2> along_y{"along y", Robot{}, exactly(1.0)};
  along_y
      .track(
          "path",
          [](const auto& t, const auto& x) {
            return decltype(x.eval()){x[0] - 0.5, x[1] - 0.5 * (t - 1.0), x[2], x[3] - 0.5};
          },
          weights)
      .reach("end", state, {exactly(0.5), exactly(0.5), exactly(0.0), exactly(0.5)});

  for (auto* phase : {&along_x, &along_y})
    phase->bound_input(0, between(-10.0, 10.0)).bound_input(1, between(-10.0, 10.0));
  OptimalControlProblem ocp("two-phase tracking");
  ocp.start_at({0, 0, 0.5, 0}).then(along_x).then(along_y);
  return ocp;
}

}  // namespace

ReferenceCase two_phase_tracking() {
  return {.id = "B21",
          .name = "two_phase_tracking",
          .summary = "A point robot follows a path with a corner.",
          .states = {"x", "y", "vx", "vy"},
          .inputs = {"ux", "uy"},
          .exercises = "a corner of the reference between two phases, singular inputs",
          .source = "PSOPT examples, two-phase path tracking robot; optimum computed independently",
          .problem = problem,
          // States are quadratic, costs quartic: one step of order four per interval is exact.
          .options = {.intervals_per_phase = 80, .integrator = runge_kutta4()},
          .optimum = 1.0416861484,
          .digits = 11,
          .tolerance = 1e-6};  // 2e-7, because the bang does not end at a node
}

}  // namespace saltus::library
