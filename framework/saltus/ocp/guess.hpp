// The initial guess of a phase: constant, interpolated or simulated.
#pragma once

#include <functional>

#include "saltus/core/types.hpp"

namespace saltus {

/// A trajectory over a phase as a function of the fraction in [0, 1] of its duration.
class Guess {
 public:
  Guess();  ///< not given: the start of the problem for states, zero for inputs
  Guess(const Guess& other);
  Guess(Guess&& other) noexcept;
  Guess& operator=(const Guess& other);
  Guess& operator=(Guess&& other) noexcept;
  ~Guess();
  /// A constant value.
  static Guess constant(VectorXd value);
  /// A straight line from `first` at the start of the phase to `last` at its end.
  static Guess interpolate(VectorXd first, VectorXd last);
  /// A function of the fraction of the phase, 0 to 1.
  static Guess trajectory(std::function<VectorXd(double fraction)> f);
  /// For states only: integrates the dynamics from the start of the phase with the guessed inputs.
  static Guess simulate();

  /// True if a trajectory was given.
  bool is_given() const { return static_cast<bool>(trajectory_); }
  /// True if the guess is a simulation.
  bool is_simulated() const { return simulated_; }
  /// Value at a fraction of the phase, 0 to 1.
  VectorXd at(double fraction) const { return trajectory_(fraction); }

 private:
  explicit Guess(std::function<VectorXd(double)> f);
  std::function<VectorXd(double)> trajectory_;
  bool simulated_ = false;
};

}  // namespace saltus
