// The brachistochrone: a bead slides without friction from rest at (0, 10) to (10, 5) in minimum
// time.
//
//   min T   x' = v sin a, y' = -v cos a, v' = g cos a   x(0) = (0, 10, 0), (x, y)(T) = (10, 5)
//
// The angle a is measured from the vertical. On the cycloid x = R (phi - sin phi), y = 10 - R (1 -
// cos phi) it is proportional to time, a = phi / 2, and T = phi_T sqrt(R / g). The equation (phi_T
// - sin phi_T) / (1 - cos phi_T) = 10 / 5 gives phi_T. The optimal input is a continuous piecewise
// linear one.
// Guess: a straight line to the end, speed from 0 to 10 m/s, a from 0 to pi/2, two seconds.
// Source: Bernoulli 1696; the numbers of the example in OpenMDAO Dymos, which finds 1.8016 s.
#include <numbers>

#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

constexpr double gravity = 9.80665;             // m/s^2
constexpr double final_angle = 3.508368768524;  // phi_T, rad

struct Bead {  // x = (x, y, v)
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 1>& u) const {
    return {x[2] * sin(u[0]), -x[2] * cos(u[0]), gravity * cos(u[0])};
  }
};

OptimalControlProblem problem() {
  const auto clock = [](const auto& t, const auto&) { return t; };
  const auto along = [](const auto&, const auto& x) { return x[0]; };
  const auto height = [](const auto&, const auto& x) { return x[1]; };

  Phase<3, 1> slide{"slide", Bead{}, between(0.5, 10.0)};
  slide.inputs(InputParametrisation::piecewise_linear_continuous)
      .bound_input(0, between(-std::numbers::pi / 2, std::numbers::pi))
      .minimise_at_end("time", clock)
      .reach("end, along", along, exactly(10.0))
      .reach("end, height", height, exactly(5.0))
      .nominal(Vec<double, 3>{10, 10, 10}, Vec<double, 1>{1})
      .guess_state(Guess::interpolate(Vec<double, 3>{0, 10, 0}, Vec<double, 3>{10, 5, 10}))
      .guess_input(Guess::interpolate(Vec<double, 1>{0}, Vec<double, 1>{std::numbers::pi / 2}))
      .guess_duration(2.0);
  OptimalControlProblem ocp("brachistochrone");
  ocp.start_at({0, 10, 0}).then(slide);
  return ocp;
}

std::vector<CheckedValue> more(const Solution& solution) {
  const Trajectory& trajectory = solution.trajectory;
  const double T = trajectory.end_time();
  constexpr double of_input = 1e-5;  // square root of the solver's 1e-10, because the cost is flat
  return {{"a(0)", trajectory.input(0.0)[0], 0.0, of_input, 16},
          {"a(T/2)", trajectory.input(T / 2.0)[0], final_angle / 4.0, of_input, 13},
          {"a(T)", trajectory.input(T)[0], final_angle / 2.0, of_input, 13}};
}

}  // namespace

ReferenceCase brachistochrone() {
  return {.id = "B03",
          .name = "brachistochrone",
          .summary = "The curve of quickest descent between two points.",
          .states = {"x [m]", "y [m]", "speed [m/s]"},
          .inputs = {"angle [rad]"},
          .exercises = "one phase of free duration, minimum time, a start from rest",
          .source = "Dymos examples, brachistochrone; closed form",
          .problem = problem,
          .options = {.intervals_per_phase = 10, .integrator = runge_kutta8()},
          .optimum = 1.801603122453081,
          .digits = 16,
          .tolerance = 1e-9,  // solver; the input is exact, the integration to 1e-12
          .more = more};
}

}  // namespace saltus::library
