// A cart that reaches mud: beyond 1 m the ground drags. The switch depends on the position.
#include <cstdio>
#include <saltus/saltus.hpp>

using namespace saltus;

struct Ride {   // x = (place m, speed m/s), u = force per mass, m/s^2
  double drag;  // 1/s
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - drag * x[1]};
  }
};

int main() {
  const auto into_the_mud = [](auto, auto x) { return x[0] - 1.0; };
  const auto place = [](auto, auto x) { return x[0]; };
  const auto speed = [](auto, auto x) { return x[1]; };
  const auto pull = [](auto, auto, auto u) { return u[0]; };

  Phase<2, 1> ride{"ride", Ride{0.0}, exactly(2.0)};
  ride.switch_at("mud", into_the_mud, Ride{2.0})
      .bound_input(0, between(-6.0, 6.0))
      .track("effort", pull, VectorXd::Ones(1))
      .reach("there", place, exactly(2.0))
      .reach("at rest", speed, exactly(0.0));
  OptimalControlProblem problem("into the mud");
  problem.start_at({0.0, 0.0}).then(ride);

  const Solution plan = solve(problem);
  std::printf("%s: cost %.4f\n", plan.message.c_str(), plan.cost);
  // Simulates the inputs of the plan in the same dynamics. The default grid has 30 intervals.
  IntegratorPlant cart = nominal_plant(problem, runge_kutta4());
  const double interval = 2.0 / 30;
  for (int k = 0; k < 30; ++k) cart.advance(plan.trajectory.input((k + 0.5) * interval), interval);
  for (const HybridEvent& event : cart.take_events())
    std::printf("%.3f s: %s, at %.3f m/s\n", event.time, event.name.c_str(), event.before[1]);
  return plan.ok() ? 0 : 1;
}
