#include <cstdio>

#include <saltus/saltus.hpp>

using namespace saltus;

struct Gear {              // x = (position m, speed m/s), u = (throttle, brake)
  double thrust, braking;  // m/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u) const {
    return {x[1], thrust * u[0] - braking * u[1] - 0.01 * x[1] * x[1]};
  }
};

int main() {
  const auto position = [](auto, auto x) { return x[0]; };
  const auto speed = [](auto, auto x) { return x[1]; };
  const auto clock = [](auto t, auto) { return t; };

  // The duration and the time of the shift are free.
  Phase<2, 2> first{"first gear", Gear{6.0, 8.0}, between(0.5, 10.0)};
  first.bound_input(0, between(0.0, 1.0))
      .bound_input(1, exactly(0.0))
      .keep("rev limit", speed, at_most(12.0));

  Phase<2, 2> second{"second gear", Gear{3.0, 8.0}, between(0.5, 20.0)};
  second.bound_input(0, between(0.0, 1.0))
      .bound_input(1, between(0.0, 1.0))
      .keep("clutch settles", speed, at_most(14.0), Window{.from = 0.0, .to = 0.3})
      .reach("finish line", position, exactly(100.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("time", clock);

  OptimalControlProblem car("car");
  car.start_at({0, 0}).then(first).then(second, jump<2>("clutch", [](auto, auto x) {
                                          return decltype(x){x[0], 0.97 * x[1]};
                                        }));
  const Solution plan = solve(car);
  std::printf("%s: %.3f s, shift after %.3f s\n", describe(plan.status), plan.cost,
              plan.durations[0]);
  save(car, plan, "car_plan", {"position [m]", "speed [m/s]"}, {"throttle", "brake"});
}
