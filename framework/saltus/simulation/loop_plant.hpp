// What a closed loop drives: anything that moves on by a given time under a given input.
#pragma once

#include <string>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/model/event_integrator.hpp"

namespace saltus {

/// Derive from it to drive a simulator of your own; four functions are needed.
/// IntegratorPlant is the plant for dynamics given as formulas.
class LoopPlant {
 public:
  virtual ~LoopPlant() = default;

  virtual double time() const = 0;     ///< s
  virtual VectorXd state() const = 0;  ///< true state (nx), which the controller sees through noise
  virtual int inputs() const = 0;      ///< nu
  /// Moves on by `length` s, 0 or more, under a constant input (nu). False: it could not; then
  /// time() and state() are as before, and failure() is a sentence that says why.
  virtual bool advance(const VectorRef& input, double length) = 0;

  /// Why advance() could not go on.
  virtual std::string failure() const { return "the plant could not go on"; }
  /// The mode in force; empty: the plant has one only.
  virtual std::string mode() const { return {}; }
  /// Events since the last call, in the order of their times.
  virtual std::vector<HybridEvent> take_events() { return {}; }
  /// Adds `change` (nx) to the state. Throws DefinitionError when the plant cannot do that.
  virtual void disturb(const VectorRef& change);
  /// For messages and results.
  virtual std::string name() const { return "plant"; }
};

/// Why advance() refuses a length below 0 or that is no number, a sentence.
std::string describe_bad_length(double length);

}  // namespace saltus
