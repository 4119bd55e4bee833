// The car is a kinematic bicycle, state (x, y, heading, speed, steering angle), inputs the
// acceleration and the rate of the steering angle:
//     x' = v cos(psi), y' = v sin(psi), psi' = v tan(delta) / L, v' = a, delta' = omega
#include "benchmarks/suite/closed_loops.hpp"

#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "benchmarks/chain_sqp.hpp"
#include "benchmarks/data_file.hpp"
#include "benchmarks/point_shift.hpp"
#include "benchmarks/tracking_program.hpp"
#include "saltus/core/data_file.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {
namespace {

struct Car {
  static constexpr int nx = 5, nu = 2, intervals = 40;
  static constexpr double wheel_base = 2.7, sample = 0.05;      // m, s
  static constexpr double speed = 12.0, lane = 3.5;             // m/s, m
  static constexpr double change = 20.0, back = 50.0;           // m along the road
  static constexpr double acceleration = 3.0;                   // m/s^2
  static constexpr double steering_rate = 0.6, steering = 0.5;  // rad/s, rad

  template <class S>
  Vec<S, nx> operator()(const S&, const Vec<S, nx>& x, const Vec<S, nu>& u) const {
    using std::cos, std::sin, std::tan;
    Vec<S, nx> rate;
    rate[0] = x[3] * cos(x[2]);
    rate[1] = x[3] * sin(x[2]);
    rate[2] = x[3] * tan(x[4]) / wheel_base;
    rate[3] = u[0];
    rate[4] = u[1];
    return rate;
  }

  /// State after the given number of samples.
  static VectorXd reference(int samples) {
    const double x = speed * sample * samples;
    VectorXd at(nx);
    at << x, x > change && x < back ? lane : 0.0, 0.0, speed, 0.0;
    return at;
  }
};

TrackingProgram car_program() {
  Tracking tracking{.nx = Car::nx,
                    .nu = Car::nu,
                    .intervals = Car::intervals,
                    .substeps = 1,
                    .sample = Car::sample,
                    .dynamics = make_function<Car::nx, Car::nu, 0>(Car{})};
  tracking.state_weight.resize(Car::nx);
  tracking.state_weight << 0.1, 1.0, 1.0, 0.1, 0.1;
  tracking.input_weight = VectorXd::Constant(Car::nu, 0.1);
  tracking.input_upper.resize(Car::nu);
  tracking.input_upper << Car::acceleration, Car::steering_rate;
  tracking.input_lower = -tracking.input_upper;
  tracking.state_upper = VectorXd::Constant(Car::nx, infinity);
  tracking.state_upper[4] = Car::steering;
  tracking.state_lower = -tracking.state_upper;
  TrackingProgram program(std::move(tracking));
  program.start_at(Car::reference(0));
  return program;
}

// One program per tick; then the model advances with the first input.
std::vector<ClosedLoop::Tick> recorded(TrackingProgram program, int ticks,
                                       const std::function<void(TrackingProgram&, int)>& follow) {
  std::vector<ClosedLoop::Tick> all;
  follow(program, 0);
  qp::StagePoint plan = program.reference_point();
  program.linearise(plan);
  const auto solver = qp::make_riccati_solver(program.qp(), {}, {});
  const auto solve = [&] {
    if (solver->solve(program.qp(), plan, /*warm=*/false).status != qp::QpStatus::optimal)
      throw std::runtime_error("a program of the closed loop was not solved");
  };
  solve();
  for (int tick = 1; tick <= ticks; ++tick) {
    const qp::StageQp before = program.qp();
    program.start_at(program.next(before.start, plan.stages[0].u));
    follow(program, tick);
    qp::StagePoint about(program.qp());
    shift_by_one_stage(before, plan, program.qp(), plan, about);
    program.linearise(about);
    all.push_back({program.qp(), about});
    solve();
  }
  return all;
}

// Recorded at the first request.
ClosedLoop loop_of(const std::string& name, int ticks, int intervals,
                   std::function<std::vector<ClosedLoop::Tick>()> record) {
  const auto known = std::make_shared<std::vector<ClosedLoop::Tick>>();
  return {name, ticks, intervals, [known, record = std::move(record)](int number) {
            if (known->empty()) *known = record();
            return known->at(number - 1);
          }};
}

}  // namespace

ClosedLoop chain_loop() {
  constexpr int ticks = 30;
  return loop_of("steps/chain", ticks, HangingChain::intervals, [] {
    return recorded(chain_program(read_chain(data_file("hanging_chain.json"))), ticks,
                    [](TrackingProgram&, int) {});
  });
}

ClosedLoop car_loop() {
  constexpr int ticks = 80;
  return loop_of("steps/car", ticks, Car::intervals, [] {
    return recorded(car_program(), ticks, [](TrackingProgram& program, int tick) {
      for (int k = 0; k <= Car::intervals; ++k) program.follow(k, Car::reference(tick + k));
    });
  });
}

}  // namespace saltus::bench
