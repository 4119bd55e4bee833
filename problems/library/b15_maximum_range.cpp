// Maximum range in two seconds. The input is the direction of flight, and a descent increases the
// speed.
//
//   max x(2)   x' = V cos g, y' = V sin g, V' = 1/2 - sin g   from rest in the origin, y(2) = 0.1
//
// Acceleration is in units of gravity; g is the angle of the path above the horizontal. At rest the
// direction affects the speed but not the position, so the flight begins with g = -pi/2.
// Guess: a straight line to (1, 0.1) and speed 1, horizontal flight.
// Source: Bryson, Dynamic Optimization, "maximum range"; Becerra, PSOPT examples, 1.712314.
#include <numbers>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Flight {  // x = (x, y, V)
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 1>& u) const {
    return {x[2] * cos(u[0]), x[2] * sin(u[0]), 0.5 - sin(u[0])};
  }
};

OptimalControlProblem problem() {
  const auto minus_range = [](const auto&, const auto& x) { return -x[0]; };
  const auto height = [](const auto&, const auto& x) { return x[1]; };
  const Vec<double, 3> start{0, 0, 0}, end{1, 0.1, 1};

  Phase<3, 1> fly{"fly", Flight{}, exactly(2.0)};
  fly.inputs(InputParametrisation::piecewise_linear_continuous)
      .bound_input(0, between(-std::numbers::pi, std::numbers::pi))
      .minimise_at_end("range", minus_range)
      .reach("height", height, exactly(0.1))
      .guess_state(Guess::interpolate(start, end));
  OptimalControlProblem ocp("maximum range");
  ocp.start_at(start).then(fly);
  return ocp;
}

std::vector<CheckedValue> more(const Solution& solution) {
  // Piecewise linear g with h = 1/20 has an error of up to h^2 |g''| / 8, with |g''| < 1.
  return {{"g(0)", solution.trajectory.input(0.0)[0], -std::numbers::pi / 2, 4e-4, 16}};
}

}  // namespace

ReferenceCase maximum_range() {
  return {.id = "B15",
          .name = "maximum_range",
          .summary = "Maximum range in two seconds: the descent increases the speed.",
          .states = {"x", "y", "speed"},
          .inputs = {"path angle [rad]"},
          .exercises = "a terminal value to maximise, a start at which the input has no effect",
          .source = "Bryson, Dynamic Optimization; PSOPT examples; optimum computed independently",
          .problem = problem,
          .options = {.intervals_per_phase = 40, .integrator = runge_kutta8()},
          .optimum = -1.712314875075,
          .digits = 13,
          .tolerance = 1e-7,  // piecewise linear inputs cost an excess of order h^4
          .more = more};
}

}  // namespace saltus::library
