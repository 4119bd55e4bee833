// A controller in a separate process. Clock and measurements are those of the robot and arrive over
// a socket; some are late, some are lost. link_robot starts this program with the robot's port.
//
// Every period of the robot's clock has a tick, which waits for the measurement of its period. A
// late measurement is predicted to the present by the model with the inputs that were sent. Without
// a measurement the plan continues. A command is sent on time in any case.
#include <cmath>

#include "link.hpp"

constexpr double patience = 0.4 * period;  // waiting time of a tick for its measurement, s
constexpr double longest_silence = 2.0;    // silence after which the program ends, s
constexpr int remembered = 8;              // number of sent inputs kept for predictions

OptimalControlProblem regulator() {
  Phase<2, 1> ahead{"ahead", Cart{}, exactly(1.0)};
  ahead.bound_input(0, between(-3.0, 3.0))
      .track(
          "state", [](auto, auto x) { return x; }, VectorXd{{10.0, 1.0}})
      .track(
          "effort", [](auto, auto, auto u) { return u; }, VectorXd{{0.1}});
  OptimalControlProblem problem("regulator");
  problem.start_at({0.0, 0.0}).then(ahead);
  return problem;
}

int main(int argc, char** argv) {
  const int robot = argc == 2 ? std::atoi(argv[1]) : 0;
  if (robot <= 0) {
    std::fprintf(stderr, "usage: link_controller PORT, where the robot listens\n");
    return 2;
  }
  UdpSocket link;
  RecedingHorizonController controller{
      MultipleShooting(regulator(), {.intervals_per_phase = 25, .integrator = runge_kutta4()}),
      {.period = period, .deadline = 0.5 * period}};
  IntegratorPlant model = make_plant<2, 1>(Cart{}, runge_kutta4(), VectorXd{{0.0, 0.0}});

  double sent[remembered] = {};  // indexed by the number of the period
  int in_time = 0, predicted = 0, without = 0;
  const VectorXd unknown = VectorXd::Constant(2, std::nan(""));
  VectorXd state = unknown, input = VectorXd::Zero(1), change(2);

  // The first message synchronises the clocks: `ahead` is the offset from the robot's clock to
  // ours.
  link.send(Command{.number = -1}, robot);
  Measurement last;
  if (!link.receive(last, wall_clock() + 5.0)) return 1;
  double ahead = wall_clock() - last.time;
  int used = -1;  // number of the latest measurement
  for (int k = last.number; last.number >= 0; ++k) {
    controller.prepare(period * k);
    Measurement one = last;
    bool is_new = k == last.number;
    while (!is_new && link.receive(one, period * k + ahead + patience)) {
      if (one.number < 0) break;
      if (one.number <= last.number) continue;  // older than the latest measurement
      last = one;
      is_new = one.number >= k;
      ahead =
          std::fmin(ahead, wall_clock() - one.time);  // the fastest message gives the best offset
    }
    if (one.number < 0 || wall_clock() > last.time + ahead + longest_silence) break;
    for (; k < last.number; ++k)  // missed periods, in which the last input was held
      sent[(k + 1) % remembered] = sent[k % remembered];

    state = unknown;
    if (last.number > used) {
      used = last.number;
      state = Eigen::Map<const VectorXd>(last.state, 2);
      ++(last.number == k ? in_time : predicted);
      change = state - model.state();
      model.disturb(change);
      for (int j = last.number; j < k && k - j < remembered; ++j) {
        input[0] = sent[j % remembered];
        model.advance(input, period);
      }
      state = model.state();
    } else {
      ++without;
    }
    const ControlTick& tick = controller.tick(period * k, state);  // keeps the preparation
    sent[k % remembered] = tick.input[0].input()[0];
    link.send(Command{.number = k,
                      .provenance = static_cast<std::int32_t>(tick.provenance),
                      .input = sent[k % remembered]},
              robot);
  }
  std::printf("controller: %d measurements on time, %d late and predicted, %d missing\n", in_time,
              predicted, without);
  return 0;
}
