// A controller on a robot: your program owns the loop, the controller returns an input every tick.
#include <cmath>

#include "cart.hpp"

// Your robot, here a simulation in which every tenth message is lost.
class YourRobot {
 public:
  VectorXd measure() {
    if (++messages_ % 10 == 0) return VectorXd::Constant(2, std::nan(""));
    return plant_.state();
  }
  void apply(const VectorRef& input) { plant_.advance(input, 0.02); }

 private:
  IntegratorPlant plant_ = make_plant<2, 1>(Cart{}, runge_kutta4(), VectorXd{{0.5, 0.0}});
  int messages_ = 0;
};

int main() {
  Phase<2, 1> ahead{"ahead", Cart{}, exactly(1.0)};
  ahead.bound_input(0, between(-3.0, 3.0))
      .track("place", position, VectorXd::Constant(1, 10.0))
      .track("speed", speed, VectorXd::Constant(1, 1.0))
      .track("effort", pull, VectorXd::Constant(1, 0.1));
  OptimalControlProblem problem("regulator");
  problem.start_at({0.0, 0.0}).then(ahead);

  YourRobot robot;
  ControllerOptions options{.period = 0.02, .deadline = 0.02};
  options.fallback_input = VectorXd::Zero(1);  // used without a plan
  options.send = [&](const ControlTick& tick) { robot.apply(tick.input[0].input()); };
  RecedingHorizonController controller{
      MultipleShooting(problem, {.intervals_per_phase = 25, .integrator = runge_kutta4()}),
      options};

  // From here on there is no allocation, no lock and no exception.
  VectorXd state;
  for (int k = 0; k < 200; ++k) {
    const double now = 0.02 * k;
    controller.prepare(now);     // while waiting: work that needs no measurement
    state = robot.measure();     // your clock, your messages
    controller.feedback(state);  // calls `send` as soon as the input is known
  }
  const LoopStatistics& log = controller.statistics();
  std::printf("20 ticks without a measurement used their plan: %s; every tick had a plan: %s\n",
              log.count(Provenance::shifted) >= 20 ? "yes" : "no",
              log.count(Provenance::fallback) == 0 ? "yes" : "no");
  const double left = std::abs(robot.measure()[0]);
  std::printf("less than 1 cm from the target: %s\n", left < 0.01 ? "yes" : "no");
  return left < 0.01 ? 0 : 1;
}
