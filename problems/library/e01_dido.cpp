// Dido's problem: the curve of given length between two points that encloses the largest area with
// the line between them.
//
//   max int x   x' = u   x(0) = x(1) = 0,  int sqrt(1 + u^2) <= pi / 3
//
// The length has an upper bound, which makes the program convex. The optimum is an arc of a circle
// with chord 1 and length pi / 3: radius 1, angle pi / 3, area (pi / 3 - sin(pi / 3)) / 2. The
// problem is split into two phases at t = 0.4, and the integral of the length continues through
// both.
// Guess: the line for the state and the slope of a parabola, because the length of the line has a
// zero derivative.
// Source: the isoperimetric problem of antiquity; closed form.
#include <cmath>
#include <numbers>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Slope {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return u;
  }
};

constexpr double length = std::numbers::pi / 3.0;

OptimalControlProblem problem() {
  const auto height = [](const auto&, const auto& x) { return x[0]; };
  const auto area = [](const auto&, const auto& x) { return -x[0]; };
  const auto arc = [](const auto&, const auto&, const auto& u) {
    using std::sqrt;
    return sqrt(1.0 + u[0] * u[0]);
  };
  Phase<1, 1> rise{"rise", Slope{}, exactly(0.4)};
  rise.minimise("area", area).bound_integral("length", arc, at_most(length));
  Phase<1, 1> fall{"fall", Slope{}, exactly(0.6)};
  fall.minimise("area", area)
      .bound_integral("length", arc, at_most(length))
      .reach("end", height, exactly(0.0));
  for (auto* phase : {&rise, &fall})
    phase->inputs(InputParametrisation::piecewise_linear_continuous)
        .bound_input(0, between(-2.0, 2.0));
  rise.guess_input(Guess::interpolate(Vec<double, 1>{0.5}, Vec<double, 1>{0.1}));
  fall.guess_input(Guess::interpolate(Vec<double, 1>{0.1}, Vec<double, 1>{-0.5}));
  OptimalControlProblem ocp("Dido");
  ocp.start_at({0}).then(rise).then(fall);
  return ocp;
}

}  // namespace

ReferenceCase dido() {
  return {.id = "E01",
          .name = "dido",
          .summary = "The largest area below a curve of given length.",
          .states = {"height"},
          .inputs = {"slope"},
          .exercises = "an integral constraint over two phases",
          .source = "the isoperimetric problem; closed form",
          .problem = problem,
          .options = {.intervals = {40, 60}, .integrator = runge_kutta4()},
          .optimum = -0.5 * (length - std::sqrt(0.75)),
          .digits = 15,
          // A piecewise linear slope with h = 1/100 has an error of order h^4.
          .tolerance = 1e-8};
}

}  // namespace saltus::library
