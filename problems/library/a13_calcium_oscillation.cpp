// One pulse of an inhibitor stops calcium oscillations in a cell. The start and the length of the
// pulse are free.
//
//   min int_0^22 |x - xbar|^2 dt + 100 int w dt,   w = 0, 1, 0
//
// x contains the four concentrations of Kummer's model. xbar is an unstable steady state: the cell
// stays near it after the pulse for some time only if the pulse is correct to the fifth digit.
// Guess: phases of 5, 0.2 and 16.8 time units; the concentrations are simulated until the end of
// the pulse and equal xbar afterwards.
// Source: Sager, mintOC.de, calcium oscillation (1610.654); Lebiedz, Sager, Bock and Lebiedz, Phys.
// Rev. Lett. 95, 108303 (2005). Optimum and switching times were computed independently.
#include "problems/library/cases.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

struct Cell {
  double inhibitor;  // w

  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x) const {
    constexpr double k1 = 0.09, k2 = 2.30066, k3 = 0.64, K4 = 0.19, k5 = 4.88, K6 = 1.18, k7 = 2.08,
                     k8 = 32.24, K9 = 29.09, k10 = 5.0, K11 = 2.67, k12 = 0.7, k13 = 13.58,
                     k14 = 153.0, K15 = 0.16, k16 = 4.85, K17 = 0.05;
    const S released = k10 * x[1] * x[2] * x[3] / (x[3] + K11);
    const S stored = k16 * x[2] / (x[2] + K17), leak = x[3] / 10.0;
    const S pumped = k14 * x[2] / ((1.0 + 0.3 * inhibitor) * x[2] + K15);
    return {k1 + k2 * x[0] - k3 * x[0] * x[1] / (x[0] + K4) - k5 * x[0] * x[2] / (x[0] + K6),
            k7 * x[0] - k8 * x[1] / (x[1] + K9),
            released + k12 * x[1] + k13 * x[0] - pumped - stored + leak, stored - released - leak};
  }
};

OptimalControlProblem problem() {
  const Vec<double, 4> steady{6.78677, 22.65836, 0.384306, 0.28977};
  const double durations[] = {5.0, 0.2, 16.8};
  const char* const names[] = {"oscillate", "inhibit", "rest"};
  OptimalControlProblem ocp("calcium oscillation");
  ocp.start_at({0.03966, 1.09799, 0.00142, 1.65431});
  for (int i = 0; i < 3; ++i) {
    const double inhibitor = i == 1 ? 1.0 : 0.0;
    Phase<4, 0> phase{names[i], Cell{inhibitor}, between(0.01, 22.0)};
    phase
        .minimise("deviation",
                  [steady, inhibitor](const auto&, const auto& x) {
                    const auto a = x[0] - steady[0], b = x[1] - steady[1], c = x[2] - steady[2],
                               d = x[3] - steady[3];
                    return a * a + b * b + c * c + d * d + 100.0 * inhibitor;
                  })
        .guess_state(i < 2 ? Guess::simulate() : Guess::constant(steady))
        .guess_duration(durations[i]);
    ocp.then(phase);
  }
  ocp.total_time(exactly(22.0));
  return ocp;
}

}  // namespace

ReferenceCase calcium_oscillation() {
  return {.id = "A13",
          .name = "calcium_oscillation",
          .summary = "Calcium oscillations in a cell are stopped by one pulse of an inhibitor.",
          .states = {"x1", "x2", "x3", "x4"},
          .exercises = "two free switching times, stiff dynamics, an unstable target",
          .source = "mintOC, calcium oscillation; computed independently",
          .problem = problem,
          // Stiff: an explicit scheme of order 8 is unstable with fewer than 100 steps.
          .options = {.intervals = {60, 10, 150},
                      .integrator = gauss_legendre({.stages = 4, .steps = 4})},
          .optimum = 1610.6442,
          .digits = 8,
          .tolerance = 1e-6,  // accuracy of the reference
          .switching_times = {4.69469454, 4.84379836},
          .switching_tolerance = 1e-5,
          .replay = 1e-6,              // four steps are accurate to 2e-7 in the spikes
          .replay_from_start = false,  // errors grow until no digit is correct
          .derivatives = {.integrator = implicit_midpoint({.steps = 20})}};
}

}  // namespace saltus::library
