// Robertson's chemical kinetics: rates that differ by nine orders of magnitude, over five decades
// of time, with the sensitivities to the three rate constants.
//
//   y1' = p2 y2 y3 - p1 y1, y2' = p1 y1 - p2 y2 y3 - p3 y2^2, y3' = p3 y2^2
//   y(0) = (1, 0, 0), p = (0.04, 1e4, 3e7)
//
// Source: Robertson 1966; Hairer and Wanner, sec. IV.1; CVODES, example cvsRoberts_FSA.
#include <fmt/format.h>

#include "problems/library/initial_value_problems.hpp"
#include "problems/library/motion.hpp"
#include "problems/library/simulations.hpp"
#include "saltus/integrators/sundials.hpp"

namespace saltus::library {
namespace {

// Global errors of CVODES with a local tolerance of 1e-12, with a margin of ten.
constexpr double of_state = 1e-9, of_sensitivity = 1e-8;

void check_states(Integrator& integrator, std::vector<CheckedValue>& values) {
  const std::vector<std::pair<double, Vec<double, 3>>> known{
      {0.4, {0.985172113861, 3.38639537898e-5, 1.47940221852e-2}},
      {40.0, {0.715827068719, 9.18553476456e-6, 0.284163745746}},
      {4e4, {3.89833770855e-2, 1.62176831591e-7, 0.961016460738}}};
  for (const auto& [time, reference] : known) {
    const VectorXd y = integrate(integrator, robertson_point(time));
    for (int i = 0; i < 3; ++i)
      values.push_back({fmt::format("y{}({:g})", i + 1, time), y[i], reference[i],
                        of_state * std::abs(reference[i]), 12});
  }
}

void check_sensitivities(Integrator& integrator, std::vector<CheckedValue>& values) {
  Mat<double, 3, 3> known;
  known << -0.355952565984, 9.54238142759e-8, -1.58317663551e-11,  //
      3.90254405381e-4, -2.13096103022e-10, -5.29004109321e-13,    //
      0.355562311578, -9.52107181728e-8, 1.63607704645e-11;
  const MatrixXd dy = sensitivities(integrator, robertson_point(0.4));
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      values.push_back({fmt::format("dy{}/dp{}(0.4)", i + 1, k + 1), dy(i, 3 + k), known(i, k),
                        of_sensitivity * std::abs(known(i, k)), 12});
}

std::vector<CheckedValue> run() {
  const auto integrator =
      cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-13})->make(robertson());
  std::vector<CheckedValue> values;
  check_states(*integrator, values);
  check_sensitivities(*integrator, values);
  return values;
}

std::vector<Motion> motions(const IntegratorChoice& scheme) {
  const IntegratorChoice own = cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-13});
  VectorXd times(202);
  times << 0.0, VectorXd::LinSpaced(201, -5.0, std::log10(4e4)).unaryExpr([](double decade) {
    return std::pow(10.0, decade);
  });
  const VectorXd point = robertson_point(0.0);
  Motion motion = simulate_motion(robertson(), scheme ? scheme : own, point.head(3), times,
                                  point.segment(3, 3));
  motion.recording.state_names = {"y1", "y2", "y3"};
  motion.logarithmic_time = true;
  return {motion};
}

}  // namespace

SimulationCase robertson_kinetics() {
  return {.id = "D02",
          .name = "robertson_kinetics",
          .summary = "Robertson's chemical kinetics, with rates over nine orders of magnitude.",
          .exercises = "CVODES on stiff kinetics, forward sensitivities to parameters",
          .source = "Robertson 1966; CVODES cvsRoberts_FSA; recomputed independently",
          .run = run,
          .motions = motions};
}

}  // namespace saltus::library
