// Interface of plants in a closed loop.
#pragma once

#include <string>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/model/event_integrator.hpp"

namespace saltus {

/// Derive from this class to use your own simulator; four functions are required. For dynamics
/// given as formulas use IntegratorPlant.
class LoopPlant {
 public:
  virtual ~LoopPlant() = default;

  virtual double time() const = 0;     ///< current time in seconds
  virtual VectorXd state() const = 0;  ///< true state (nx); the controller measures it with noise
  virtual int inputs() const = 0;      ///< number of inputs, nu
  /// Advances by `length` >= 0 seconds under a constant input (nu). On failure returns false,
  /// leaves time() and state() unchanged, and failure() explains the reason in a sentence.
  virtual bool advance(const VectorRef& input, double length) = 0;

  /// Reason why advance() failed.
  virtual std::string failure() const { return "the plant could not advance"; }
  /// Name of the active mode; empty if the plant has only one.
  virtual std::string mode() const { return {}; }
  /// Events since the last call, in order of time.
  virtual std::vector<HybridEvent> take_events() { return {}; }
  /// Called when the problem of a ShrinkingHorizonController enters this phase. Make the jump of
  /// the state here if the plant does not make it by itself.
  virtual void enter_phase(int /*phase*/) {}
  /// Adds `change` (nx) to the state. Throws DefinitionError if the plant does not support it.
  virtual void disturb(const VectorRef& change);
  /// Name of the plant in messages and results.
  virtual std::string name() const { return "plant"; }
};

/// Error sentence of advance() for a negative or non-finite length.
std::string describe_bad_length(double length);

}  // namespace saltus
