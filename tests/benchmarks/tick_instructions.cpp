// Runs whole ticks of push recovery, from the measurement to the input. compare_instructions.py
// counts the instructions:
//
//     tick_instructions one-foot|landing|two-feet
//
// It uses the default weights on the numbers of case ICUB-1. The plant is the plan's own motion
// with disturbances. The program prints the compiler and its vector width, then the numbers of
// ticks and iterations.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>

#include "benchmarks/push_recovery_cases.hpp"
#include "saltus/core/random.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/qp/lanes.hpp"
#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/robots/model/capture_point.hpp"

namespace {

using namespace saltus;                 // NOLINT(google-build-using-namespace): one file
using namespace saltus::push_recovery;  // NOLINT(google-build-using-namespace)

// Same settings as make_tick_controller() in robots/saltus/robots/walking/planner.cpp.
constexpr qp::RiccatiKernel kernels[] = {
    qp::riccati_kernel<0, 6, 15, true>(),  qp::riccati_kernel<15, 6, 15, true>(),
    qp::riccati_kernel<15, 6, 9>(),        qp::riccati_kernel<15, 12, 21, true>(),
    qp::riccati_kernel<0, 12, 21, true>(), qp::riccati_kernel<21, 12, 21, true>(),
    qp::riccati_kernel<21, 12, 9>(),       qp::riccati_kernel<9, 0, 0>()};
constexpr int ticks = 15;
constexpr double period = 0.01;  // s

// Landing time of the second foot in s: after the last horizon, in every horizon, before the first.
double landing(const std::string& batch) {
  return batch == "one-foot" ? 10.0 : batch == "landing" ? ticks * period : 0.0;
}

}  // namespace

int main(int arguments, char** argument) {
  if (arguments != 2) return EXIT_FAILURE;
  const double impact = landing(argument[1]);
  QpCase c = read_case("ICUB-1");
  MultipleShooting shooting(
      problem(c.model, Weights(), c.data, walking::one_foot_then_two(impact)),
      {.intervals_per_phase = c.model.intervals, .integrator = zero_order_hold()});
  auto solver = make_real_time_iteration(shooting.nlp(), {.tolerance = 1e-8, .kernels = kernels});
  RecedingHorizonController controller(std::move(shooting), std::move(solver), {.period = period});
  VectorXd state = c.start;
  Vec<double, 12> applied = Vec<double, 12>::Zero();
  applied[2] = c.model.mass * robots::standard_gravity;
  Random random(1);
  int iterations = 0;
  bool failed = false;
  for (int k = 0; k < ticks; ++k) {
    const double t = period * k;
    c.data.com = state.head<3>();
    c.data.force = applied.head<3>() + applied.segment<3>(6);
    c.data.omega = std::sqrt(robots::standard_gravity / state[2]);
    controller.set_data("tick", c.data);
    Vec<double, 12> before = applied;
    if (t < impact) before.tail<6>().setConstant(std::numeric_limits<double>::quiet_NaN());
    controller.set_previous_input(before);
    const ControlTick& tick = controller.tick(t, state);
    iterations += tick.iterations;
    failed = failed || tick.provenance != Provenance::optimal;
    const Solution plan = controller.report();
    applied = plan.trajectory.input(t + 0.5 * period);
    state = plan.trajectory.state(t + period);
    for (int i = 0; i < 9; ++i) state[i] += random.uniform(-1.0, 1.0) * (i < 3 ? 1e-4 : 1e-3);
  }
  fmt::print("gcc {}, vectors of {}\n{} ticks, {} iterations\n", __GNUC__, qp::lanes, ticks,
             iterations);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
