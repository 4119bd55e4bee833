// The Alp rider: a linear system must stay above four steep mountains.
//
//   min int_0^20 100 |x|^2 + 0.01 |u|^2
//   x1' = -10 x1 + u1 + u2, x2' = -2 x2 + u1 + 2 u2,
//   x3' = -3 x3 + 5 x4 + u1 - u2, x4' = 5 x3 - 3 x4 + u1 + 3 u2
//   |x|^2 >= 3 p(t, 3, 12) + 3 p(t, 6, 10) + 3 p(t, 10, 6) + 8 p(t, 15, 4) + 0.01
//   p(t, a, b) = exp(-b (t - a)^2),   x(0) = (2, 1, 2, 1), x(20) = (2, 3, 1, -2)
//
// The constraint is not convex, and a mountain is less than a second wide: with long intervals the
// plan passes through it between two nodes. The state leaves the start and reaches the end within a
// tenth of a second, where 100 equal intervals would have no node. There the intervals grow from 5
// ms on.
// Guess: the constant start, no input.
// Source: Betts, Practical Methods for Optimal Control, 2nd ed., sec. 4.11.7 (2030.856).
#include <cmath>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double horizon = 20.0;  // s

struct Rider {
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 2>& u) const {
    return {-10.0 * x[0] + u[0] + u[1], -2.0 * x[1] + u[0] + 2.0 * u[1],
            -3.0 * x[2] + 5.0 * x[3] + u[0] - u[1], 5.0 * x[2] - 3.0 * x[3] + u[0] + 3.0 * u[1]};
  }
};

OptimalControlProblem problem() {
  const auto state = [](const auto&, const auto& x) { return x; };
  const auto above = [](const auto& t, const auto& x) {
    const auto peak = [&](double a, double b) { return exp(-b * (t - a) * (t - a)); };
    return x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] -
           (3.0 * peak(3.0, 12.0) + 3.0 * peak(6.0, 10.0) + 3.0 * peak(10.0, 6.0) +
            8.0 * peak(15.0, 4.0));
  };
  Phase<4, 2> ride{"ride", Rider{}, exactly(horizon)};
  ride.keep("mountains", above, at_least(0.01))
      .allow("mountains", 1e-2)  // linear inputs cannot follow the mountains of height 3 and 8
      .minimise("cost",
                [](const auto&, const auto& x, const auto& u) {
                  return 100.0 * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]) +
                         0.01 * (u[0] * u[0] + u[1] * u[1]);
                })
      .reach("end", state, {exactly(2.0), exactly(3.0), exactly(1.0), exactly(-2.0)})
      .inputs(InputParametrisation::piecewise_linear_continuous);
  OptimalControlProblem ocp("Alp rider");
  ocp.start_at({2, 1, 2, 1}).then(ride);
  return ocp;
}

// At both ends 12 intervals that grow from 5 ms, then equal ones.
Mesh mesh() {
  constexpr int graded = 12, equal = 240;
  constexpr double shortest = 0.005, growth = 1.35;  // s
  std::vector<double> ends{0.0};                     // s
  for (int i = 0; i < graded; ++i) ends.push_back(ends.back() + shortest * std::pow(growth, i));
  Mesh mesh{.intervals = 2 * graded + equal, .nodes = {}};
  for (const double t : ends) mesh.nodes.push_back(t / horizon);
  const double begin = mesh.nodes.back();
  for (int i = 1; i < equal; ++i) mesh.nodes.push_back(begin + (1.0 - 2.0 * begin) * i / equal);
  for (int i = graded; i >= 0; --i) mesh.nodes.push_back(1.0 - ends[i] / horizon);
  return mesh;
}

}  // namespace

ReferenceCase alp_rider() {
  return {.id = "B20",
          .name = "alp_rider",
          .summary = "A linear system stays above four steep mountains.",
          .states = {"x1", "x2", "x3", "x4"},
          .inputs = {"u1", "u2"},
          .exercises = "a nonconvex path constraint that is narrower than long intervals",
          .source = "Betts, Practical Methods for Optimal Control, sec. 4.11.7",
          .problem = problem,
          .options = {.meshes = {mesh()}, .integrator = runge_kutta4({.steps = 2})},
          .optimum = 2030.856,
          .digits = 7,
          .tolerance = 1e-4,           // linear inputs cost 7e-5 more than the optimum
          .between_nodes = 1e-2,       // at the mountains of height 3 and 8
          .replay = 1e-3,              // two steps of order four, for rates of 10 per second
          .replay_from_start = false,  // x3 and x4 grow by e^40
          .derivatives = {.intervals = 40, .integrator = implicit_midpoint({.steps = 4})}};
}

}  // namespace saltus::library
