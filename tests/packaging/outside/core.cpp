// A user's first program, with the core alone: a car drives 100 m and stops, in the shortest time.
#include <cmath>
#include <cstdio>
#include <saltus/integrators/runge_kutta.hpp>
#include <saltus/ocp/problem.hpp>
#include <saltus/solver/native_solver.hpp>
#include <saltus/transcription/multiple_shooting.hpp>

// The folders of the source tree must not be on a user's path.
#if __has_include(<framework/saltus/ocp/problem.hpp>) || __has_include(<ocp/problem.hpp>)
#error "names of Saltus's own folders are on the include path"
#endif
#ifdef SALTUS_EXPECT_INSTALLED
#if __has_include(<saltus/qp/lanes.hpp>)
#error "internals are installed"
#endif
#endif

using namespace saltus;

struct Car {  // x = (position m, speed m/s), u = acceleration m/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0]};
  }
};

int main() {
  const auto position = [](auto, auto x) { return x[0]; };
  const auto speed = [](auto, auto x) { return x[1]; };
  const auto clock = [](auto t, auto) { return t; };
  Phase<2, 1> drive{"drive", Car{}, between(5.0, 40.0)};
  drive.bound_input(0, between(-1.0, 1.0))
      .reach("finish", position, exactly(100.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("time", clock);
  OptimalControlProblem race("race");
  race.start_at({0, 0}).then(drive);
  MultipleShooting shooting{race, {.intervals_per_phase = 20, .integrator = runge_kutta4()}};
  const auto solver = make_native_solver();
  const Solution plan = solve(shooting, *solver);
  // Full throttle to the middle, full brake from there: 2 sqrt(100 m / 1 m/s^2).
  std::printf("%s: %.9f s\n", plan.message.c_str(), plan.cost);
  return std::abs(plan.cost - 20.0) < 1e-6 ? 0 : 1;
}
