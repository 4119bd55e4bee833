#include "saltus/robots/whole_body/base_estimator.hpp"

#include <Eigen/Cholesky>

namespace saltus::robots {
namespace {

using State = ContactInertialState;

// s, in which the feet that stand from the start are found.
constexpr double first_contacts = 0.1;

double square(double x) { return x * x; }

}  // namespace

void BaseEstimator::reset(const Eigen::Isometry3d& base, Side pin,
                          const Eigen::Isometry3d& pin_sole) {
  state_ = {};
  state_.R = base.linear();
  state_.p = base.translation();
  state_.sole(pin) = pin_sole;
  pin_ = pin;
  stands(pin) = true;
  stands(other(pin)) = false;
  rests_[0] = rests_[1] = false;
  landed_[0] = landed_[1] = false;
  time_ = 0.0;
  P_.setZero();
  const auto start = [this](int first, int entries, double deviation) {
    P_.diagonal().segment(first, entries).setConstant(square(deviation));
  };
  start(State::turn, 2, options_.turn);
  start(State::turn + 2, 1, options_.turn);
  start(State::velocity, 3, options_.velocity);
  start(State::position, 3, options_.position);
  start(State::foot(State::foot_turns, pin), 2, options_.ground_slope);
  start(State::gyroscope_bias, 3, options_.gyroscope_bias);
  start(State::accelerometer_bias, 3, options_.accelerometer_bias);
}

// Expresses the estimate relative to the new pin. The errors of its position and heading become
// common to the whole estimate and are subtracted from every position and heading. This is linear
// for right-invariant errors.
void BaseEstimator::pin(Side side) {
  pin_ = side;
  if (!stands(side)) return;  // it becomes the pin when it touches down
  transition_.setIdentity();
  const int place = State::foot(State::foot_positions, side),
            heading = State::foot(State::foot_turns, side) + 2;
  for (const int first :
       {static_cast<int>(State::position), State::foot(State::foot_positions, Side::left),
        State::foot(State::foot_positions, Side::right)})
    transition_.block<3, 3>(first, place) -= Mat<double, 3, 3>::Identity();
  for (const int turn :
       {static_cast<int>(State::turn) + 2, State::foot(State::foot_turns, Side::left) + 2,
        State::foot(State::foot_turns, Side::right) + 2})
    transition_(turn, heading) -= 1.0;
  product_.noalias() = transition_ * P_;
  P_.noalias() = product_ * transition_.transpose();
  if (!stands(other(side))) forget(other(side));
}

void BaseEstimator::predict(const Vec<double, 3>& angular_velocity,
                            const Vec<double, 3>& specific_force, double dt) {
  transition_ = state_.transition(dt);
  const Mat<double, State::size, 6> G = state_.reading_errors();
  time_ += dt;
  state_.move_on(angular_velocity, specific_force, dt);
  product_.noalias() = transition_ * P_;
  P_.noalias() = product_ * transition_.transpose();
  Vec<double, 6> readings;
  readings << Vec<double, 3>::Constant(dt * square(options_.gyroscope_noise)),
      Vec<double, 3>::Constant(dt * square(options_.accelerometer_noise));
  P_.noalias() += G * readings.asDiagonal() * G.transpose();
  const auto walk = [&](int first, int entries, double density) {
    P_.diagonal().segment(first, entries).array() += dt * square(density);
  };
  walk(State::gyroscope_bias, 3, options_.gyroscope_walk);
  walk(State::accelerometer_bias, 3, options_.accelerometer_walk);
  for (const Side side : {Side::left, Side::right}) {
    if (!stands(side)) {
      forget(side);  // noise of the gyroscope acts on it through the lever arm
      continue;
    }
    const bool rests = rests_[index(side)];
    if (side != pin_)
      walk(State::foot(State::foot_positions, side), 3, options_.foot_walk);
    else if (!rests && options_.rocking_walk > 0.0)
      walk(State::foot(State::foot_positions, side), 3, options_.rocking_walk);
    walk(State::foot(State::foot_turns, side), side == pin_ ? 2 : 3,
         rests && !landed_[index(side)] ? options_.resting_turn_walk : options_.foot_turn_walk);
  }
}

void BaseEstimator::correct(Side side, const SoleReading& reading) {
  rests_[index(side)] = reading.stands && reading.rests;
  if (!reading.stands) {
    if (stands(side)) forget(side);
    stands(side) = false;
    return;
  }
  if (!stands(side)) return plant(side, reading);

  // z = H error + noise, H = (position | turn) of the base minus those of the foot.
  const int d = State::foot(State::foot_positions, side), f = State::foot(State::foot_turns, side);
  Mat<double, State::size, 6> PH;  // P H'
  PH << P_.middleCols<3>(State::position) - P_.middleCols<3>(d),
      P_.middleCols<3>(State::turn) - P_.middleCols<3>(f);
  Mat<double, 6, 6> S;
  S << PH.middleRows<3>(State::position) - PH.middleRows<3>(d),
      PH.middleRows<3>(State::turn) - PH.middleRows<3>(f);
  S += noise_of(reading);
  const Eigen::LLT<Mat<double, 6, 6>> factor(S);
  const Mat<double, 6, State::size> gain = factor.solve(PH.transpose());  // K'
  const State::Error error = gain.transpose() * state_.mismatch(side, reading.pose);
  state_ = state_.displaced(-error);
  product_.noalias() = PH * gain;
  P_ -= 0.5 * (product_ + product_.transpose());
}

// A foot without estimate has no error.
void BaseEstimator::forget(Side side) {
  for (const int first :
       {State::foot(State::foot_positions, side), State::foot(State::foot_turns, side)}) {
    P_.middleRows<3>(first).setZero();
    P_.middleCols<3>(first).setZero();
  }
}

// Places the foot by leg kinematics. Its error is the sum of the errors of the base and of the
// legs.
void BaseEstimator::plant(Side side, const SoleReading& reading) {
  const int d = State::foot(State::foot_positions, side), f = State::foot(State::foot_turns, side);
  state_.sole(side) = state_.base() * reading.pose;
  forget(side);
  P_.middleRows<3>(d) = P_.middleRows<3>(State::position);
  P_.middleRows<3>(f) = P_.middleRows<3>(State::turn);
  P_.middleCols<3>(d) = P_.middleCols<3>(State::position).eval();
  P_.middleCols<3>(f) = P_.middleCols<3>(State::turn).eval();
  const Mat<double, 6, 6> noise = noise_of(reading);
  P_.block<3, 3>(d, d) += noise.topLeftCorner<3, 3>();
  P_.block<3, 3>(d, f) += noise.topRightCorner<3, 3>();
  P_.block<3, 3>(f, d) += noise.bottomLeftCorner<3, 3>();
  P_.block<3, 3>(f, f) += noise.bottomRightCorner<3, 3>();
  stands(side) = true;
  landed_[index(side)] = time_ > first_contacts;
  if (side == pin_) pin(side);  // all positions are relative to the pin
}

// Noise covariance of mismatch(), world axes.
Mat<double, 6, 6> BaseEstimator::noise_of(const SoleReading& reading) const {
  Mat<double, 6, 6> noise = reading.covariance;
  for (const int i : {0, 3})
    for (const int j : {0, 3})
      noise.block<3, 3>(i, j) =
          state_.R * reading.covariance.block<3, 3>(i, j) * state_.R.transpose();
  noise.diagonal().head<3>().array() += square(options_.leg_position_noise);
  noise.diagonal().tail<3>().array() += square(options_.leg_turn_noise);
  return noise;
}

}  // namespace saltus::robots
