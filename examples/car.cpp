// A car drives 100 m from rest to rest in minimum time. The unknown is the time of the gear shift.
#include <cstdio>
#include <fstream>
#include <saltus/saltus.hpp>

using namespace saltus;

template <class S>
struct Road {        // data of the road, by name
  S slope = 0.0;     // rad
  S headwind = 0.0;  // m/s

  using Entries = ParameterEntries<&Road::slope, &Road::headwind>;
};

struct Gear {              // x = (position m, speed m/s), u = (throttle, brake)
  double thrust, braking;  // m/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u,
                       const Vec<S, size_of<Road>>& p) const {
    const auto road = view_as<Road>(p);
    const S air = x[1] + road.headwind;
    return {x[1], thrust * u[0] - braking * u[1] - 0.01 * air * air - 9.81 * sin(road.slope)};
  }
};

int main() {
  const auto position = [](auto, auto x) { return x[0]; };
  const auto speed = [](auto, auto x) { return x[1]; };
  const auto clock = [](auto t, auto) { return t; };

  Phase<2, 2, size_of<Road>> first{"first gear", Gear{6.0, 8.0}, between(0.5, 10.0)};
  first.bound_input(0, between(0.0, 1.0))
      .bound_input(1, exactly(0.0))
      .keep("rev limit", speed, at_most(12.0))
      .data("road", Road<double>{});
  Phase<2, 2, size_of<Road>> second{"second gear", Gear{3.0, 8.0}, between(0.5, 20.0)};
  second.bound_input(0, between(0.0, 1.0))
      .bound_input(1, between(0.0, 1.0))
      .reach("finish line", position, exactly(100.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("time", clock)
      .data("road", Road<double>{});
  OptimalControlProblem car("car");
  car.start_at({0, 0}).then(first).then(second, jump<2>("clutch", [](auto, auto x) {
                                          return decltype(x){x[0], 0.97 * x[1]};
                                        }));

  const Solution plan = solve(car);
  std::printf("level road: %s: %.3f s, shift after %.3f s\n", plan.message.c_str(), plan.cost,
              plan.durations[0]);
  Recording recording = record(car, plan.trajectory);
  recording.state_names = {"position [m]", "speed [m/s]"};
  recording.input_names = {"throttle", "brake"};
  std::ofstream("car.csv") << recording.trajectory_csv();

  // A second solve with other data; the program is built once.
  MultipleShooting shooting{car, {.intervals_per_phase = 30, .integrator = runge_kutta4()}};
  shooting.set_data("road", Road<double>{.slope = 0.05, .headwind = 5.0});
  const Solution uphill = solve(shooting, *make_native_solver());
  std::printf("uphill, against the wind: %.3f s, shift after %.3f s\n", uphill.cost,
              uphill.durations[0]);
  return plan.ok() && uphill.ok() ? 0 : 1;
}
