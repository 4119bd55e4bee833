// The initial guess of a phase: constant, interpolated or simulated.
#pragma once

#include <functional>
#include <utility>

#include "saltus/core/types.hpp"

namespace saltus {

/// A trajectory over the phase, as a function of the fraction in [0, 1] of its duration.
class Guess {
 public:
  Guess() = default;  ///< not given: the start of the problem for states, zero for inputs
  static Guess constant(VectorXd value) {
    return Guess([v = std::move(value)](double) { return v; });
  }
  /// Straight line from `first` at the start of the phase to `last` at its end.
  static Guess interpolate(VectorXd first, VectorXd last) {
    return Guess([a = std::move(first), b = std::move(last)](double s) -> VectorXd {
      return a + s * (b - a);
    });
  }
  static Guess trajectory(std::function<VectorXd(double fraction)> f) {
    return Guess(std::move(f));
  }
  /// States only: integrate the dynamics from where the phase starts with the inputs guessed.
  static Guess simulate() {
    Guess guess;
    guess.simulated_ = true;
    return guess;
  }

  bool is_given() const { return static_cast<bool>(trajectory_); }
  bool is_simulated() const { return simulated_; }
  VectorXd at(double fraction) const { return trajectory_(fraction); }

 private:
  explicit Guess(std::function<VectorXd(double)> f) : trajectory_(std::move(f)) {}
  std::function<VectorXd(double)> trajectory_;
  bool simulated_ = false;
};

}  // namespace saltus
