// Can a walker stop, and within how many steps? The linear inverted pendulum answers this in closed
// form, and optimal control gives the same answer.
//
//   x'' = omega^2 (x - p), xi = x + x' / omega: xi' = omega (xi - p)
//   d_0 = r, d_N = (l - r + d_(N-1)) e^(-omega t_s) + r
//
// Steps have a length of at most l = 0.4 m and a duration of at least t_s = 0.3 s. The centre of
// pressure p is at most r = 5 cm from the ankle. If |xi - p0| <= d_N, the walker can stop within N
// steps, otherwise it cannot. The optimal control problem has N phases of t_s with a step from
// ankle to ankle between two of them, and a last phase at whose end the capture point is above the
// foot. It starts one micrometre inside and outside of d_N: the first problem must be feasible, the
// second infeasible.
// Source: Pratt et al. 2006; Koolen et al. 2012; numbers evaluated in high precision.
#include "saltus/robots/model/capture_point.hpp"

#include <fmt/format.h>

#include <cmath>

#include "problems/library/motion.hpp"
#include "problems/library/simulations.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::library {
namespace {

constexpr double height = 0.53;  // m
constexpr robots::StepLimits point_foot{
    .longest_step = 0.4, .shortest_time = 0.3, .foot_radius = 0.0};
constexpr robots::StepLimits flat_foot{
    .longest_step = 0.4, .shortest_time = 0.3, .foot_radius = 0.05};
constexpr double rounding = 1e-13;  // 15 digits are given
constexpr double margin = 1e-6;     // m, distance from the threshold at which feasibility is tested

// x = (capture point, ankle, next ankle), u = (centre of pressure from the ankle, speed of the next
// ankle): m and m/s.
struct Walker {
  double omega = 0.0;
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 2>& u) const {
    return {omega * (x[0] - x[1] - u[0]), S(0.0), u[1]};
  }
};

OptimalControlProblem walk(int steps, double capture_point, const robots::StepLimits& limits) {
  const double omega = pendulum_frequency(height), r = limits.foot_radius;
  const auto inputs = [](const auto&, const auto&, const auto& u) { return u; };
  const auto stride = [](const auto&, const auto& x) { return x[2] - x[1]; };
  const auto distance = [](const auto&, const auto& x) { return x[0] - x[1]; };
  const auto land = jump<3>("step", [](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{x[0], x[2], x[2]};
  });

  OptimalControlProblem ocp("walk");
  ocp.start_at({capture_point, 0.0, 0.0});
  for (int i = 0; i <= steps; ++i) {
    const bool last = i == steps;
    Phase<3, 2> phase{fmt::format("{} {}", last ? "stand" : "step", i + 1), Walker{omega},
                      exactly(limits.shortest_time)};
    phase.bound_input(0, between(-r, r)).track("effort", inputs, Vec<double, 2>::Ones());
    if (last)
      phase.reach("above the foot", distance, between(-r, r));
    else
      phase.reach("longest step", stride, between(-limits.longest_step, limits.longest_step));
    if (i == 0)
      ocp.then(phase);
    else
      ocp.then(phase, land);
  }
  return ocp;
}

// 1: feasible, 0: certified infeasible, NaN: undecided.
double is_feasible(int steps, double capture_point) {
  MultipleShooting shooting(walk(steps, capture_point, flat_foot),
                            {.intervals_per_phase = 2, .integrator = zero_order_hold()});
  const auto solver = make_native_solver({.tolerance = 1e-9});
  const Solution solution = solve(shooting, *solver);
  if (solution.status == SolveStatus::optimal) return 1.0;
  return solution.status == SolveStatus::infeasible ? 0.0 : std::nan("");
}

void check_pendulum(double omega, std::vector<CheckedValue>& values) {
  const robots::PendulumState<double> start{-0.05, 0.4};
  const robots::PendulumState<double> end = propagate_pendulum(start, 0.0, omega, 0.6);
  const double xi = saltus::capture_point(start.position, start.velocity, omega);
  values.insert(
      values.end(),
      {{"omega", omega, 4.30225916958337, 10 * rounding, 15},
       {"orbital energy", orbital_energy(start, 0.0, omega), 0.0568632075471698, rounding, 15},
       {"orbital energy later", orbital_energy(end, 0.0, omega), 0.0568632075471698, rounding, 15},
       {"capture point", xi, 0.0429744081500177, rounding, 15},
       {"x(0.6)", end.position, 0.278544706479575, rounding, 15},
       {"v(0.6)", end.velocity, 1.24491795282536, 10 * rounding, 15},
       {"capture point at 0.6", propagate_capture_point(xi, 0.0, omega, 0.6), 0.567908481127747,
        rounding, 15}});
}

void check_margins(double omega, std::vector<CheckedValue>& values) {
  const double point[] = {0.110033712513468, 0.140302257237209, 0.148628658108042,
                          0.150919120107274, 0.151549190200141};
  for (int n = 1; n <= 5; ++n)
    values.push_back({fmt::format("d_{} of a point foot", n),
                      capturability_margin(n, point_foot, omega), point[n - 1], rounding, 15});
  const double flat[] = {0.05, 0.160033712513468, 0.190302257237209, 0.198628658108042};
  for (int n = 0; n <= 3; ++n)
    values.push_back({fmt::format("d_{} of a flat foot", n),
                      capturability_margin(n, flat_foot, omega), flat[n], rounding, 15});
  values.push_back({"limit of a point foot", capturability_limit(point_foot, omega),
                    0.151788283344598, rounding, 15});
  values.push_back({"limit of a flat foot", capturability_limit(flat_foot, omega),
                    0.201788283344598, rounding, 15});
}

std::vector<CheckedValue> run() {
  const double omega = pendulum_frequency(height);
  std::vector<CheckedValue> values;
  check_pendulum(omega, values);
  check_margins(omega, values);
  for (int n = 0; n <= 3; ++n) {
    const double d = capturability_margin(n, flat_foot, omega);
    for (const double side : {1.0, -1.0}) {
      const char* which = side > 0.0 ? "ahead" : "behind";
      values.push_back({fmt::format("{} steps suffice slightly inside d, {}", n, which),
                        is_feasible(n, side * (d - margin)), 1.0, 0.0, 1});
      values.push_back({fmt::format("{} steps suffice slightly outside d, {}", n, which),
                        is_feasible(n, side * (d + margin)), 0.0, 0.0, 0});
    }
  }
  return values;
}

std::vector<Motion> motions(const IntegratorChoice& scheme) {
  const IntegratorChoice used = scheme ? scheme : zero_order_hold();
  const double far = capturability_margin(3, flat_foot, pendulum_frequency(height)) - margin;
  const OptimalControlProblem problem = walk(3, far, flat_foot);
  MultipleShooting shooting(problem, {.intervals_per_phase = 2, .integrator = used});
  const auto solver = make_native_solver({.tolerance = 1e-9});
  const Solution solution = solve(shooting, *solver);
  Motion motion;
  motion.recording = record(problem, solution.trajectory, 20);
  motion.recording.state_names = {"capture point [m]", "ankle [m]", "next ankle [m]"};
  motion.recording.input_names = {"centre of pressure from the ankle [m]",
                                  "speed of the next ankle [m/s]"};
  motion.integrator = used->name();
  if (!solution.ok()) motion.failure = solution.message;
  return {motion};
}

}  // namespace

SimulationCase capture_point() {
  return {.id = "C07",
          .name = "capture_point",
          .summary = "Capturability of a walker: can it stop, and within how many steps?",
          .exercises = "closed forms of the pendulum; the effect of steps by optimal control",
          .source = "Pratt et al. 2006; Koolen et al. 2012; closed form",
          .run = run,
          .motions = motions};
}

}  // namespace saltus::library
