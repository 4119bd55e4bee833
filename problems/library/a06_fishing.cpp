// Predators and prey are fished to keep both populations near 1. Fishing is on or off, and the boat
// goes out four times.
//
//   min int_0^12 (x1 - 1)^2 + (x2 - 1)^2      x(0) = (0.5, 0.7)
//   x1' = x1 - x1 x2 - 0.4 x1 w, x2' = -x2 + x1 x2 - 0.2 x2 w     w = 0, 1, 0, 1, 0, 1, 0, 1, 0
//
// Guess: the boat is out from 2.5 to 4, then for half a time unit in each unit until 7; the
// populations are simulated. Each phase lasts at least 0.05, because a phase of zero length removes
// its two switches. From phases of equal length, solvers converge to a plan with one trip fewer
// (1.3463).
// Source: Sager, mintOC.de, Lotka Volterra fishing problem; the sequence from B. Stellato, S.
// Ober-Bloebaum and P. Goulart, SwitchTimeOpt.jl (2017). Its switching times (2.44356, 4.12262,
// ..., 6.46604) with 1.34543556 are optimal for a linearised model; in this model they cost
// 1.3452978. The reference was computed independently.
#include <fmt/format.h>

#include <array>

#include "problems/library/cases.hpp"
#include "problems/library/fishing.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::library {
namespace {

OptimalControlProblem problem() {
  const std::array guess{2.5, 1.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 5.0};
  OptimalControlProblem ocp("fishing");
  ocp.start_at({0.5, 0.7});
  for (int i = 0; i < 9; ++i) {
    const bool out = i % 2 == 1;
    Phase<2, 0> phase{fmt::format("{} {}", out ? "fish" : "wait", i / 2 + 1),
                      Populations{out ? 1.0 : 0.0}, between(0.05, 12.0)};
    phase.minimise("deviation", Deviation{})
        .guess_state(Guess::simulate())
        .guess_duration(guess[i]);
    ocp.then(phase);
  }
  ocp.total_time(exactly(12.0));
  return ocp;
}

}  // namespace

ReferenceCase fishing() {
  return {
      .id = "A06",
      .name = "fishing",
      .summary = "Predators and prey are fished on four trips, with full effort, at free times.",
      .states = {"prey", "predators"},
      .exercises = "nine phases without inputs, eight free switching times",
      .source = "mintOC and SwitchTimeOpt.jl; computed independently",
      .problem = problem,
      .options = {.intervals = {12, 8, 2, 2, 4, 2, 4, 2, 24}, .integrator = runge_kutta8()},
      .optimum = 1.3452952183,
      .digits = 11,
      .tolerance = 1e-9,  // tolerance of the solver
      .switching_times = {2.442039, 4.116872, 4.419770, 4.669964, 5.182837, 5.353706, 6.355744,
                          6.452765}};
}

}  // namespace saltus::library
