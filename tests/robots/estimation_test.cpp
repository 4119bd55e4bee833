// Estimation from sensors: noise, rate and delay of the readings, the filter's Jacobians against
// differences, consistency of its errors with its covariance, and iCub balancing in DART on the
// estimate alone.
#include "saltus/robots/whole_body/estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/simulation/simulated_robot.hpp"
#include "saltus/robots/whole_body/sensor_estimator.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"
#include "tests/robots/balance_on_the_left_foot.hpp"
#include "tests/robots/icub_body.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

using State = robots::ContactInertialState;

constexpr double dt = 1e-3;  // s, of the engine

Vec<double, 3> some_vector(Random& random, double size) { return size * random.vector(3); }

double normal(Random& random) {  // sum of twelve uniform numbers: deviation 1
  double sum = 0.0;
  for (int i = 0; i < 12; ++i) sum += random.uniform(-0.5, 0.5);
  return sum;
}
Vec<double, 3> noise(Random& random, double deviation) {
  Vec<double, 3> v;
  for (double& x : v) x = deviation * normal(random);
  return v;
}

State some_state(Random& random) {
  State s;
  s.R = robots::exp_so3(some_vector(random, 1.0));
  s.v = some_vector(random, 1.0);
  s.p = some_vector(random, 1.0);
  for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
    s.sole(side).linear() = robots::exp_so3(some_vector(random, 0.3));
    s.sole(side).translation() = some_vector(random, 1.0);
  }
  s.b_gyroscope = some_vector(random, 0.1);
  s.b_accelerometer = some_vector(random, 0.1);
  return s;
}

TEST(ContactInertialState, ErrorRoundTripIsExact) {
  for (int seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const State truth = some_state(random);
    const State::Error error = 0.5 * random.vector(State::size);
    // Rounding of a few products of numbers about one.
    EXPECT_LT((truth.displaced(error).error_to(truth) - error).norm(), 1e-13) << "seed " << seed;
  }
}

// Central differences of h = 1e-5 err by h^2 = 1e-10 and by rounding, 1e-16 / h = 1e-11; the
// transition is of first order in dt: its own error is (|omega| dt)^2 and (|a| dt)^2, about 4e-4.
TEST(ContactInertialState, ErrorsFollowTheTransitionMatrix) {
  constexpr double h = 1e-5, first_order = 4.0 * dt * dt;
  const double third = 4.0 * robots::standard_gravity * dt * dt;  // same error, of accelerations
  for (int seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const State truth = some_state(random);
    const Vec<double, 3> omega = some_vector(random, 2.0);
    const Vec<double, 3> force =
        Vec<double, 3>(0.0, 0.0, robots::standard_gravity) + some_vector(random, 3.0);
    State after = truth;
    after.move_on(omega, force, dt);
    const State::Matrix F = truth.transition(dt);
    for (int i = 0; i < State::size; ++i) {
      State::Error growth = State::Error::Zero();
      for (const double sign : {1.0, -1.0}) {
        State displaced = truth.displaced(sign * h * State::Error::Unit(i));
        displaced.move_on(omega, force, dt);
        growth += sign / (2.0 * h) * displaced.error_to(after);
      }
      EXPECT_LT((growth - F.col(i)).norm(), first_order + third)
          << "entry " << i << ", seed " << seed;
    }
    const Mat<double, State::size, 6> G = truth.reading_errors();
    for (int i = 0; i < 6; ++i) {
      State wrong = truth;
      wrong.move_on(omega + h * Vec<double, 3>(i == 0, i == 1, i == 2),
                    force + h * Vec<double, 3>(i == 3, i == 4, i == 5), dt);
      EXPECT_LT((wrong.error_to(after) / h - dt * G.col(i)).norm(), first_order + third)
          << "reading " << i << ", seed " << seed;
    }
  }
}

TEST(ContactInertialState, SoleResidualIsLinearInTheError) {
  constexpr double h = 1e-5, second_order = 10.0 * h;
  for (int seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const State truth = some_state(random);
    for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
      const Eigen::Isometry3d seen = truth.base().inverse() * truth.sole(side);
      EXPECT_LT(truth.mismatch(side, seen).norm(), 1e-14);  // rounding
      for (int i = 0; i < State::size; ++i) {
        const State::Error unit = State::Error::Unit(i);
        Vec<double, 6> expected;
        expected << unit.segment<3>(State::position) -
                        unit.segment<3>(State::foot(State::foot_positions, side)),
            unit.segment<3>(State::turn) - unit.segment<3>(State::foot(State::foot_turns, side));
        const Vec<double, 6> change = truth.displaced(h * unit).mismatch(side, seen) / h;
        EXPECT_LT((change - expected).norm(), second_order) << "entry " << i << ", seed " << seed;
      }
    }
  }
}

// A base that sways and rotates above two feet, known exactly. Sampled inside each step so
// that mean readings are exact.
struct Sway {
  static State at(double t) {
    State s;
    s.R = robots::exp_so3(Vec<double, 3>(0.1 * std::sin(3.0 * t), 0.08 * std::sin(4.0 * t),
                                         0.15 * std::sin(2.0 * t)));
    s.p = position(t);
    constexpr double h = 1e-5;  // s
    s.v = (position(t + h) - position(t - h)) / (2.0 * h);
    s.sole(robots::Side::left).translation() << 0.0, 0.0, 0.0;
    s.sole(robots::Side::right).translation() << 0.02, -0.15, 0.0;
    return s;
  }
  static Vec<double, 3> position(double t) {
    return {0.05 * std::sin(5.0 * t), -0.07 + 0.06 * std::sin(3.0 * t),
            0.5 + 0.02 * std::sin(7.0 * t)};
  }
};

struct FilterRun {
  State estimate, truth;
  State::Matrix covariance;
};

// All errors are drawn from the distributions that the filter assumes.
FilterRun run_filter(int seed, double seconds) {
  Random random(seed);
  robots::BaseEstimatorOptions o;
  // Gyroscope and accelerometer noise above iCub's, so that rounding and linearisation are
  // negligible.
  o.gyroscope_noise = 1e-3;
  o.accelerometer_noise = 5e-3;
  o.foot_walk = o.foot_turn_walk = 0.0;
  o.ground_slope = 2e-3;
  o.gyroscope_walk = o.accelerometer_walk = 1e-6;
  State truth = Sway::at(0.0);
  truth.b_gyroscope = noise(random, o.gyroscope_bias);
  truth.b_accelerometer = noise(random, o.accelerometer_bias);
  robots::BaseEstimator filter(o);
  {
    State::Error first = State::Error::Zero();
    first.segment<3>(State::turn) = noise(random, o.turn);
    first.segment<3>(State::velocity) = noise(random, o.velocity);
    first.segment<3>(State::position) = noise(random, o.position);
    State wrong = truth;
    wrong.v.setZero();  // the velocity that reset() assumes
    Eigen::Isometry3d slope = truth.sole(robots::Side::left);
    slope.linear() = robots::exp_so3(
        Vec<double, 3>(o.ground_slope * normal(random), o.ground_slope * normal(random), 0.0));
    const State start = wrong.displaced(first);
    filter.reset(start.base(), robots::Side::left, slope);
  }
  const int steps = static_cast<int>(std::lround(seconds / dt));
  for (int k = 0; k < steps; ++k) {
    const State next = [&] {
      State s = Sway::at((k + 1) * dt);
      s.b_gyroscope = truth.b_gyroscope;
      s.b_accelerometer = truth.b_accelerometer;
      return s;
    }();
    const Vec<double, 3> turned = robots::log_so3(truth.R.transpose() * next.R);
    const Mat<double, 3, 3> halfway = truth.R * robots::exp_so3(0.5 * turned);
    const Vec<double, 3> omega =
        turned / dt + truth.b_gyroscope + noise(random, o.gyroscope_noise / std::sqrt(dt));
    const Vec<double, 3> force =
        halfway.transpose() *
            ((next.v - truth.v) / dt + Vec<double, 3>(0.0, 0.0, robots::standard_gravity)) +
        truth.b_accelerometer + noise(random, o.accelerometer_noise / std::sqrt(dt));
    filter.predict(omega, force, dt);
    truth = next;
    for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
      robots::SoleReading reading;
      // The right foot is in the air in between.
      reading.stands = side == robots::Side::left || k < steps / 3 || k > steps / 2;
      reading.pose = truth.base().inverse() * truth.sole(side);
      reading.pose.translation() += noise(random, o.leg_position_noise);
      reading.pose.linear() =
          robots::exp_so3(noise(random, o.leg_turn_noise)) * reading.pose.linear();
      filter.correct(side, reading);
    }
  }
  return {filter.state(), truth, filter.covariance()};
}

// 40 runs with 15 entries each (base and biases): the mean of the normalised squares has the
// deviation sqrt(2 / 600) = 5.8 %. The band is four times that, and wider below because the
// initial velocity is better than the filter assumes.
TEST(BaseEstimator, ErrorsMatchTheCovariance) {
  constexpr int runs = 40;
  std::vector<int> entries;
  entries.reserve(static_cast<std::size_t>(State::size));
  for (int i = 0; i < 9; ++i) entries.push_back(i);
  for (int i = State::gyroscope_bias; i < State::size; ++i) entries.push_back(i);
  double sum = 0.0;
  for (int seed = 1; seed <= runs; ++seed) {
    const FilterRun run = run_filter(seed, 1.0);
    const State::Error error = run.estimate.error_to(run.truth);
    const MatrixXd P = run.covariance(entries, entries);
    const VectorXd e = error(entries);
    sum += e.dot(P.ldlt().solve(e)) / static_cast<double>(entries.size());
    // The slope of the ground, 2 mrad, is 1 mm at the height of the base: four times that.
    EXPECT_LT((run.estimate.p - run.truth.p).norm(), 4e-3) << "seed " << seed;
    EXPECT_LT((run.estimate.v - run.truth.v).norm(), 1e-2) << "seed " << seed;
  }
  EXPECT_GT(sum / runs, 0.75);
  EXPECT_LT(sum / runs, 1.25);
}

TEST(BaseEstimator, PinnedFootDoesNotMove) {
  const FilterRun run = run_filter(3, 2.0);
  EXPECT_LT(run.estimate.sole(robots::Side::left).translation().norm(), 1e-12);  // rounding
  const Mat<double, 3, 3> R = run.estimate.sole(robots::Side::left).linear();
  // The heading changes only by products of small tilts.
  EXPECT_LT(std::abs(std::atan2(R(1, 0), R(0, 0))), 1e-4);
}

// At rest on one foot, with an unknown gyroscope bias.
TEST(BaseEstimator, RestingSoleDeterminesGyroscopeBias) {
  const auto error_after_a_second = [](bool rests) {
    Random random(4);
    robots::BaseEstimator filter;
    const State truth = Sway::at(0.0);
    const Eigen::Isometry3d sole = truth.sole(robots::Side::left);
    filter.reset(truth.base(), robots::Side::left, sole);
    const Vec<double, 3> bias(3.5e-3, -3.5e-3, 2e-3);  // rad/s
    const Vec<double, 3> gravity =
        truth.R.transpose() * Vec<double, 3>(0.0, 0.0, robots::standard_gravity);
    robots::SoleReading reading;
    reading.stands = true;
    reading.rests = rests;
    for (int k = 0; k < 1000; ++k) {
      filter.predict(bias + noise(random, 1.75e-4 / std::sqrt(dt)),
                     gravity + noise(random, 5.9e-4 / std::sqrt(dt)), dt);
      reading.pose = truth.base().inverse() * sole;
      filter.correct(robots::Side::left, reading);
    }
    return (filter.state().b_gyroscope - bias).norm();
  };
  EXPECT_LT(error_after_a_second(true), 1e-3);
  EXPECT_GT(error_after_a_second(false), 3e-3);
}

// A sole that has landed on soft ground turns slowly, with its centre of pressure inside. The base
// does not turn, and the gyroscope shows this.
TEST(BaseEstimator, LetsALandedSoleTurnOnSoftGround) {
  const Eigen::Isometry3d base(Eigen::Translation3d(0.0, -0.07, 0.5));
  const Vec<double, 3> force(0.0, 0.0, robots::standard_gravity);
  robots::BaseEstimator filter;
  filter.reset(base, robots::Side::left, Eigen::Isometry3d::Identity());
  Eigen::Isometry3d right(Eigen::Translation3d(0.0, -0.14, 0.0));
  for (int k = 0; k < 3000; ++k) {
    if (k > 1000) right.rotate(Eigen::AngleAxisd(0.02 * dt, Vec<double, 3>::UnitX()));
    filter.predict(Vec<double, 3>::Zero(), force, dt);
    filter.correct(robots::Side::left, {k < 1500, k < 1500, base.inverse()});
    filter.correct(robots::Side::right, {k >= 1000, k >= 1000, base.inverse() * right});
    if (k == 1200) filter.pin(robots::Side::right);
  }
  EXPECT_NEAR(filter.state().R(1, 2), 0.0, 2e-3);
  EXPECT_NEAR(filter.state().b_gyroscope[0], 0.0, 1e-3);
}

// The pin stands on level ground. The other foot lands on a slope, becomes the pin, and the first
// one lifts off. Its tilt is known from the legs, and gravity must not appear to change.
TEST(BaseEstimator, KeepsTheTiltOfASlope) {
  const Eigen::Isometry3d base(Eigen::Translation3d(0.0, -0.07, 0.5));
  const Vec<double, 3> force(0.0, 0.0, robots::standard_gravity);
  for (const double slope : {-0.087, 0.03}) {
    robots::BaseEstimator filter;
    Eigen::Isometry3d right(Eigen::Translation3d(0.0, -0.14, 0.0));
    right.rotate(Eigen::AngleAxisd(slope, Vec<double, 3>::UnitY()));
    filter.reset(base, robots::Side::left, Eigen::Isometry3d::Identity());
    for (int k = 0; k < 6000; ++k) {
      filter.predict(Vec<double, 3>::Zero(), force, dt);
      filter.correct(robots::Side::left, {k < 1500, k < 1500, base.inverse()});
      filter.correct(robots::Side::right, {k >= 1000, k >= 1000, base.inverse() * right});
      if (k == 1200) filter.pin(robots::Side::right);
    }
    const Vec<double, 3> normal = filter.state().sole(robots::Side::right).linear().col(2);
    EXPECT_NEAR(std::atan2(normal[0], normal[2]), slope, 1e-3);
    EXPECT_NEAR(filter.state().R(0, 2), 0.0, 1e-3);
  }
}

// For q = a t^2 / 2 the filter returns the velocity one lag earlier.
TEST(JointVelocityFilter, DelaysByTheLag) {
  constexpr double T = 1e-3, a = 30.0;
  for (const double lag : {0.5e-3, 2e-3, 10e-3, 90e-3}) {
    robots::JointVelocityFilter filter(1, T, lag);
    filter.reset(VectorXd::Zero(1));
    double t = 0.0;
    for (int k = 0; k < 2000; ++k) {
      t += T;
      filter.update(VectorXd::Constant(1, 0.5 * a * t * t));
    }
    // Rounding of positions of 60 rad, divided by T.
    EXPECT_NEAR(filter.velocity()[0], a * (t - lag), 1e-9) << lag;
  }
}

TEST(SensorDevice, SamplesAtItsRateWithDelay) {
  robots::SensorDevice::Options options{250.0, 0.006, 0.0, VectorXd::Zero(1), VectorXd::Zero(1)};
  for (const bool averages : {false, true}) {
    options.averages = averages;
    robots::SensorDevice device(options, dt, 1);
    device.reset(VectorXd::Constant(1, -1.0));
    for (int k = 1; k <= 40; ++k) {
      device.observe(VectorXd::Constant(1, k));
      const int sampled = (k - 6) / 4 * 4;  // every fourth step, with a delay of six
      EXPECT_EQ(device.is_new(), sampled >= 4 && (k - 6) % 4 == 0) << k;
      // The mean over the steps k - 3 to k is 1.5 below the last.
      const double expected = k < 10 ? -1.0 : sampled - (averages ? 1.5 : 0.0);
      EXPECT_EQ(device.reading()[0], expected) << k;
    }
  }
}

TEST(SensorDevice, NoiseBiasAndResolutionMatchTheOptions) {
  constexpr int entries = 200, samples = 200;
  const double deviation = 0.3, bias = 2.0;
  robots::SensorDevice::Options options{1000.0, 0.0, 0.0, VectorXd::Constant(entries, deviation),
                                        VectorXd::Constant(entries, bias)};
  robots::SensorDevice device(options, dt, 7);
  device.reset(VectorXd::Zero(entries));
  VectorXd sum = VectorXd::Zero(entries), squares = sum;
  for (int k = 0; k < samples; ++k) {
    device.observe(VectorXd::Zero(entries));
    sum += device.reading();
    squares += device.reading().cwiseAbs2();
  }
  const VectorXd mean = sum / samples;
  const double spread = std::sqrt(((squares / samples) - mean.cwiseAbs2()).mean());
  // Five deviations: 5 % each for 200 biases, 0.35 % for 40000 samples.
  EXPECT_NEAR(std::sqrt(mean.squaredNorm() / entries), bias, 0.25 * bias);
  EXPECT_NEAR(spread, deviation, 0.0175 * deviation);

  options.noise.setZero();
  options.bias.setZero();
  options.resolution = 0.5;
  robots::SensorDevice coarse(options, dt, 7);
  coarse.reset(VectorXd::Zero(entries));
  coarse.observe(VectorXd::Constant(entries, 1.3));
  EXPECT_EQ(coarse.reading()[0], 1.5);
}

// The noise of a sample follows from the actual sampling rate, which the engine step limits.
TEST_F(IcubBody, RateNoiseMatchesTheSamples) {
  robots::SensorOptions options;
  options.gyroscope = {.rate = 1e5, .noise = 1e-3, .bias = 0.0, .delay = 0.0};
  robots::Sensors sensors(robot, options, dt);
  sensors.reset(start);
  double squares = 0.0;
  constexpr int samples = 4000;
  for (int k = 0; k < samples; ++k) {
    sensors.observe(start, {}, {});
    squares += sensors.readings().angular_velocity.squaredNorm() / 3.0;
  }
  const double deviation = 1e-3 * std::sqrt(1.0 / dt);
  EXPECT_NEAR(std::sqrt(squares / samples), deviation, 0.03 * deviation);  // five deviations
}

// A plant whose state the test sets.
class PuppetPlant final : public robots::Plant {
 public:
  /// Contact force at the origin of the left sole's frame, or at an offset (m).
  explicit PuppetPlant(const robots::WholeBodyState& state, double x = 0.0, double y = 0.0)
      : state_(state) {
    constexpr double force = 300.0;  // N
    contacts_[0].touches = true;
    contacts_[0].wrench[2] = force;
    contacts_[0].wrench[3] = y * force;
    contacts_[0].wrench[4] = -x * force;
  }
  void reset(const robots::WholeBodyState& state) override { state_ = state; }
  void set_torques(const VectorXd&) override {}
  void set_rotor_inertias(const VectorXd&) override {}
  void push(int, const Vec<double, 3>&, const Vec<double, 3>&) override {}
  void step() override { time_ += dt; }
  double time() const override { return time_; }
  const robots::WholeBodyState& state() const override { return state_; }
  const robots::WholeBodyEstimate::Contact& contact(robots::Side side) const override {
    return contacts_[side == robots::Side::left ? 0 : 1];
  }
  std::string name() const override { return "puppet"; }

 private:
  robots::WholeBodyState state_;
  robots::WholeBodyEstimate::Contact contacts_[2];
  double time_ = 0.0;
};

// An engine and an estimator that uses only sensors.
class EstimatedRobot {
 public:
  EstimatedRobot(std::unique_ptr<robots::Plant> engine, const robots::FloatingRobot& body,
                 const robots::SensorOptions& sensors, const robots::Estimator::Options& options)
      : engine_(engine.get()),
        robot_(std::move(engine), body, settings_with(sensors), dt),
        estimator_(body, robots::Side::left, sensors, options, dt) {
    reset(engine_->state());
  }

  void reset(const robots::WholeBodyState& state) {
    robot_.reset(state);
    estimator_.start(state, robot_.read());
  }
  void set_torques(const VectorXd& torques) { robot_.write({torques}); }
  void push(int body, const Vec<double, 3>& force, const Vec<double, 3>& point) {
    engine_->push(body, force, point);
  }
  void step() {
    robot_.wait();
    estimator_.update(robot_.read());
  }
  void pin(robots::Side foot) { estimator_.pin(foot); }
  const robots::WholeBodyState& state() const { return estimator_.estimate().state; }
  const robots::WholeBodyEstimate::Contact& contact(robots::Side side) const {
    return estimator_.estimate().contact(side);
  }
  const robots::BaseEstimator& base() const { return estimator_.base(); }

  static robots::walking::PlantSettings settings_with(const robots::SensorOptions& sensors) {
    robots::walking::PlantSettings settings;
    settings.engine.step = dt;
    settings.sensors = robots::walking::PlantSettings::Sensors::measured;
    settings.sensor = sensors;
    return settings;
  }

 private:
  robots::Plant* engine_;
  robots::walking::SimulatedRobot robot_;
  robots::SensorEstimator estimator_;
};

class Estimated : public IcubBody {
 protected:
  EstimatedRobot still(int seed) const {
    robots::SensorOptions sensors;
    sensors.seed = seed;
    return {std::make_unique<PuppetPlant>(start), robot, sensors, {}};
  }
};

TEST_F(Estimated, IsSeededAndResettable) {
  EstimatedRobot first = still(1), second = still(1), another = still(2);
  EXPECT_EQ(first.state().q, second.state().q);
  EXPECT_NE(first.state().q, another.state().q);
  for (int k = 0; k < 50; ++k)
    for (EstimatedRobot* plant : {&first, &second, &another}) plant->step();
  EXPECT_EQ(first.state().base.matrix(), second.state().base.matrix());
  EXPECT_EQ(first.state().dq, second.state().dq);
  EXPECT_NE(first.state().dq, another.state().dq);
  EstimatedRobot fresh = still(1);
  first.pin(robots::Side::right);
  first.reset(start);
  EXPECT_TRUE(first.base().stands(robots::Side::left));
  EXPECT_EQ(first.state().base.matrix(), fresh.state().base.matrix());
  EXPECT_EQ(first.state().q, fresh.state().q);
}

TEST_F(Estimated, DoesNotAllocate) {
  EstimatedRobot plant = still(1);
  plant.step();
  const testing::AllocationCount count;
  for (int k = 0; k < 100; ++k) plant.step();
  EXPECT_EQ(count.made(), 0);
}

TEST_F(Estimated, SolePosesMatchTheModel) {
  const std::unique_ptr<robots::DynamicsModel> model = robots::make_dart_dynamics(robot);
  Random random(5);
  robots::WholeBodyState state = start;
  state.q += 0.2 * random.vector(robot.joints());
  model->update(state);
  for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
    robots::SoleKinematics sole(robot, side);
    sole.update(state.q);
    const Eigen::Isometry3d pose = model->sole(side).pose;
    // Rounding of a dozen products.
    EXPECT_LT(((state.base * sole.pose()).matrix() - pose.matrix()).norm(), 1e-13);
    const MatrixXd in_world = state.base.linear() * sole.jacobian().topRows<3>();
    EXPECT_LT((in_world - model->sole(side).jacobian.bottomRightCorner(3, robot.joints())).norm(),
              1e-13);
  }
}

// The centre of pressure decides whether a sole can rotate, and so whether the gyroscope's bias is
// observable: 5 mm inside each edge.
TEST_F(Estimated, LoadedSoleDeterminesGyroscopeBias) {
  robots::SensorOptions sensors;
  sensors.gyroscope.bias = 0.01;  // rad/s
  sensors.force_torque = {
      .force_noise = 0.0, .torque_noise = 0.0, .force_bias = 0.0, .torque_bias = 0.0};
  // Remaining bias of roll and pitch after one second at rest.
  const auto turns = [&](double x, double y) {
    EstimatedRobot plant(std::make_unique<PuppetPlant>(start, x, y), robot, sensors, {});
    Vec<double, 2> sum(0.0, 0.0);
    for (int k = 0; k < 1000; ++k) {
      plant.step();
      if (k >= 700) sum += plant.state().base_twist.head<2>() / 300.0;
    }
    return sum.norm();
  };
  const robots::FootRectangle& foot = description.left_foot;
  constexpr double inside = 0.006, outside = 0.004;  // m from an edge
  const double x = 0.5 * (foot.x.lower + foot.x.upper), y = 0.5 * (foot.y.lower + foot.y.upper);
  const double known = 1e-3, unknown = 3e-3;  // rad/s
  for (const double edge : {foot.x.lower, foot.x.upper}) {
    const double inwards = edge < x ? 1.0 : -1.0;
    EXPECT_LT(turns(edge + inwards * inside, y), known) << edge;
    EXPECT_GT(turns(edge + inwards * outside, y), unknown) << edge;
  }
  for (const double edge : {foot.y.lower, foot.y.upper}) {
    const double inwards = edge < y ? 1.0 : -1.0;
    EXPECT_LT(turns(x, edge + inwards * inside), known) << edge;
    EXPECT_GT(turns(x, edge + inwards * outside), unknown) << edge;
  }
}

// The same sole as a box rotated onto its side, and with a wider box above it.
TEST_F(Estimated, IsIndependentOfSoleBoxes) {
  robots::FloatingRobot turned = robot, topped = robot;
  for (const robots::FloatingRobot::Frame* sole : {&robot.left_sole, &robot.right_sole}) {
    for (robots::UrdfModel::Box& box : turned.bodies[sole->body].boxes) {
      box.pose.rotate(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec<double, 3>::UnitX()));
      std::swap(box.size[1], box.size[2]);
    }
    robots::UrdfModel::Box above = robot.bodies[sole->body].boxes.front();
    above.size *= 2.0;
    above.pose =
        Eigen::Translation3d(sole->pose.linear() * Vec<double, 3>(0.0, 0.0, 0.2)) * above.pose;
    topped.bodies[sole->body].boxes.push_back(above);
  }
  robots::SensorOptions sensors;
  sensors.gyroscope.bias = 0.01;  // rad/s
  const auto after_a_second = [&](const robots::FloatingRobot& body) {
    EstimatedRobot plant(std::make_unique<PuppetPlant>(start), body, sensors, {});
    for (int k = 0; k < 1000; ++k) plant.step();
    return plant.state().base_twist;
  };
  const Vec<double, 6> twist = after_a_second(robot);
  EXPECT_LT((after_a_second(turned) - twist).norm(), 1e-9);
  EXPECT_LT((after_a_second(topped) - twist).norm(), 1e-9);
}

// A delay of the forces does not end the contact of the stance foot.
TEST_F(Estimated, AssumesContactUntilTheFirstForceReading) {
  robots::SensorOptions sensors;
  sensors.force_torque.delay = 0.1;
  EstimatedRobot plant(std::make_unique<PuppetPlant>(start), robot, sensors, {});
  for (int k = 0; k < 300; ++k) {
    plant.step();
    ASSERT_TRUE(plant.base().stands(robots::Side::left)) << k;
  }
}

// The clock of a robot need not begin at zero. The first readings have no force yet.
TEST_F(Estimated, IsIndependentOfTheZeroOfTheClock) {
  robots::SensorOptions sensors;
  sensors.force_torque.delay = 0.1;
  robots::walking::SimulatedRobot simulated(std::make_unique<PuppetPlant>(start), robot,
                                            EstimatedRobot::settings_with(sensors), dt);
  robots::SensorEstimator from_zero(robot, robots::Side::left, sensors, {}, dt);
  for (const double zero : {-7.0, 1e6}) {
    robots::SensorEstimator shifted(robot, robots::Side::left, sensors, {}, dt);
    simulated.reset(start);
    robots::Robot::Readings readings = simulated.read();
    from_zero.start(start, readings);
    readings.time += zero;
    shifted.start(start, readings);
    for (int k = 0; k < 300; ++k) {
      simulated.wait();
      readings = simulated.read();
      from_zero.update(readings);
      readings.time += zero;
      shifted.update(readings);
      ASSERT_EQ(shifted.estimate().left.touches, from_zero.estimate().left.touches) << k;
      ASSERT_EQ(shifted.estimate().state.base.matrix(), from_zero.estimate().state.base.matrix())
          << k;
    }
    EXPECT_TRUE(shifted.estimate().left.touches);
  }
}

TEST_F(Estimated, RejectsInvalidOptions) {
  robots::SensorOptions sensors;
  sensors.gyroscope.noise = -1.0;
  EXPECT_THROW(EstimatedRobot(std::make_unique<PuppetPlant>(start), robot, sensors, {}),
               DefinitionError);
  sensors = {};
  sensors.encoder.rate = 0.0;
  EXPECT_THROW(EstimatedRobot(std::make_unique<PuppetPlant>(start), robot, sensors, {}),
               DefinitionError);
  robots::Estimator::Options options;
  options.velocity_lag = infinity;
  EXPECT_THROW(EstimatedRobot(std::make_unique<PuppetPlant>(start), robot, {}, options),
               DefinitionError);
}

// One foot, one push, sensors only. Compares the estimate with the simulated state relative to the
// sole.
TEST_F(Estimated, StandsInDartWithMeasuredSensors) {
  std::unique_ptr<robots::Plant> engine = robots::make_dart_plant(robot, {});
  const robots::Plant& truth = *engine;
  EstimatedRobot plant(std::move(engine), robot, {}, {});
  plant.reset(start);
  const std::unique_ptr<robots::DynamicsModel> model = robots::make_dart_dynamics(robot),
                                               true_model = robots::make_dart_dynamics(robot);
  model->update(plant.state());
  const auto controller = standing_controller();
  const robots::WholeBodyController::Tasks tasks = tasks_on_the_left_foot();
  double largest = 0.0, squares = 0.0;
  long count = 0;
  balance_on_the_left_foot(
      robot, *model, plant, *controller, tasks, {3.0, 1.0, 0.1, 4.0},
      [&](const robots::WholeBodyController::Command&, double t) {
        if (t < 0.25) return;  // the estimator converges to the initial tilt
        true_model->update(truth.state());
        const auto over_the_sole = [](const robots::DynamicsModel& m) {
          return Vec<double, 3>(m.com() - m.sole(robots::Side::left).pose.translation());
        };
        largest = std::max(largest, (over_the_sole(*model) - over_the_sole(*true_model)).norm());
        squares += (model->com_velocity() - true_model->com_velocity()).squaredNorm();
        ++count;
      });
  EXPECT_LT(largest, 5e-3);                                          // m
  EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), 0.02);  // m/s
}

}  // namespace
}  // namespace saltus
