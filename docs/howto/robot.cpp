// A controller on a robot: the loop is yours, the controller answers in time whatever happens.
#include <cmath>

#include "cart.hpp"

// Your robot. Here it is a simulation, of which every tenth message is lost.
class Robot {
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

  Robot robot;
  ControllerOptions options{.period = 0.02, .deadline = 0.02};
  options.fallback_input = VectorXd::Zero(1);  // where there is no plan at all
  options.send = [&](const ControlTick& tick) { robot.apply(tick.input[0].input()); };
  RecedingHorizonController controller{
      MultipleShooting(problem, {.intervals_per_phase = 25, .integrator = runge_kutta4()}),
      options};

  // From here on nothing is allocated, locked or thrown.
  VectorXd state;
  for (int k = 0; k < 200; ++k) {
    const double now = 0.02 * k;
    controller.prepare(now);     // while waiting: everything that needs no measurement
    state = robot.measure();     // your clock, your messages
    controller.feedback(state);  // `send` is called as soon as the input stands
  }
  const LoopStatistics& log = controller.statistics();
  std::printf("20 ticks had no measurement and went on with their plan: %s; none had no plan: %s\n",
              log.count(Provenance::shifted) >= 20 ? "yes" : "no",
              log.count(Provenance::fallback) == 0 ? "yes" : "no");
  const double left = std::abs(robot.measure()[0]);
  std::printf("less than 1 cm from where it should be: %s\n", left < 0.01 ? "yes" : "no");
  return left < 0.01 ? 0 : 1;
}
