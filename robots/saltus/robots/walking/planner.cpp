#include "saltus/robots/walking/planner.hpp"

#include <algorithm>
#include <functional>
#include <random>
#include <utility>

#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/any_real_time_solver.hpp"
#include "saltus/qp/riccati_kernels.hpp"

namespace saltus::walking {
namespace {

// Sizes of a tick's stages where changes of the wrenches cost: 9 states, the previous wrench of
// every foot that bears, and its wrench. Others are swept at run-time sizes.
constexpr qp::RiccatiKernel tick_kernels[] = {
    qp::riccati_kernel<0, 6, 15, true>(),  qp::riccati_kernel<15, 6, 15, true>(),
    qp::riccati_kernel<15, 6, 9>(),        qp::riccati_kernel<15, 12, 21, true>(),
    qp::riccati_kernel<0, 12, 21, true>(), qp::riccati_kernel<21, 12, 21, true>(),
    qp::riccati_kernel<21, 12, 9>(),       qp::riccati_kernel<9, 0, 0>()};

// Ticks that are denied their solve: runs of one to five, as often as the fraction asks.
std::function<bool(long)> missed_ticks(const PlannerSettings& settings) {
  if (settings.missed_fraction <= 0.0) return {};
  constexpr int longest = 5;
  constexpr double mean = 0.5 * (1 + longest);
  const double begin =
      std::min(1.0, settings.missed_fraction / (mean * (1.0 - settings.missed_fraction)));
  return [random = std::mt19937(static_cast<unsigned>(settings.missed_seed)), begin,
          left = 0](long) mutable {
    if (left == 0) {
      left = -1;  // at least one tick between runs
      return false;
    }
    if (left < 0) {
      if (std::uniform_real_distribution<double>(0.0, 1.0)(random) >= begin) return false;
      left = std::uniform_int_distribution<int>(1, longest)(random);
    }
    --left;
    return true;
  };
}

}  // namespace

ControllerOptions controller_options(const PlannerSettings& settings, double mass, Side stance) {
  ControllerOptions options;
  options.period = settings.step;
  if (settings.deadline > 0.0) options.deadline = settings.deadline;
  options.miss_deadline = missed_ticks(settings);
  options.fallback_input = VectorXd::Zero(12);
  options.fallback_input[stance == Side::left ? 2 : 8] = mass * standard_gravity;
  return options;
}

RecedingHorizonController make_tick_controller(OptimalControlProblem problem, int intervals,
                                               const PlannerSettings& settings, double mass,
                                               Side stance) {
  MultipleShooting shooting(std::move(problem),
                            {.intervals_per_phase = intervals, .integrator = zero_order_hold()});
  return make_controller(
      std::move(shooting),
      {.solver = settings.solver, .tolerance = settings.tolerance, .kernels = tick_kernels},
      controller_options(settings, mass, stance));
}

}  // namespace saltus::walking
