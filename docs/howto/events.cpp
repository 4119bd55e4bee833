// A simulation with events: a ball bounces down a step, and a guard in time switches a wind on.
#include <cstdio>
#include <saltus/saltus.hpp>

using namespace saltus;

int main() {
  // x = (distance, height, their rates)
  const auto calm = [](auto, auto x) {
    return decltype(x){x[2], x[3], 0.0 * x[0], 0.0 * x[0] - 9.81};
  };
  const auto windy = [](auto, auto x) {
    return decltype(x){x[2], x[3], 0.0 * x[0] - 2.0, 0.0 * x[0] - 9.81};
  };
  const auto height = [](auto, auto x) { return x[1]; };
  const auto bounce = [](auto, auto x) { return decltype(x){x[0], x[1], x[2], -0.8 * x[3]}; };
  const auto clock = [](auto t, auto) { return t - 1.0; };

  Automaton<4, 0> ball;
  ball.mode("calm", calm)
      .mode("windy", windy)
      .event("impact", "calm", "calm", height, Crossing::falling, bounce)
      .event("impact", "windy", "windy", height, Crossing::falling, bounce)
      .event("wind", "calm", "windy", clock, Crossing::rising);

  IntegratorPlant plant =
      make_plant(ball, runge_kutta8({.steps = 4}), VectorXd{{0.0, 1.0, 1.0, 0.0}});
  while (plant.time() < 1.999) {
    if (!plant.advance(VectorXd(0), 0.1)) {
      std::printf("%s\n", plant.failure().c_str());
      return 1;
    }
    for (const HybridEvent& event : plant.take_events())
      std::printf("%.4f s: %s, from '%s' to '%s'\n", event.time, event.name.c_str(),
                  event.mode_before.c_str(), event.mode_after.c_str());
  }
  std::printf("after 2 s at %.4f m\n", plant.state()[0]);
  return 0;
}
