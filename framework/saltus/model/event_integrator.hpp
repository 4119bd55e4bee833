// What integrators of hybrid systems offer beyond one interval: a record of the events, and a mode
// that is carried along from interval to interval.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/integrator.hpp"

namespace saltus {

/// What happens to the state at an event inside an interval.
enum class EventKind {
  crosses,  ///< another field, the state goes on
  jumps,    ///< the state is reset
  slides,   ///< sliding begins
  leaves,   ///< sliding ends
};
/// In words, for messages.
const char* describe(EventKind kind);

/// An event as it happened.
struct HybridEvent {
  double time = 0.0;                          ///< s
  EventKind kind = EventKind::crosses;        ///< what happened
  std::string name, mode_before, mode_after;  ///< the event's, and the modes' on either side
  VectorXd before, after;                     ///< x-, x+
  /// d time / d w of the interval (x0 | c | p | t0 | h); those of a simulation: / d (x0 | p) of all
  /// of it.
  VectorXd time_derivative;
};

/// An integrator that stops at events inside an interval and goes on behind them.
class EventIntegrator : public Integrator {
 public:
  using Integrator::Integrator;

  /// Appends the events of the following calls to `events` (not owned); null ends it. Recording
  /// allocates, integration itself does not.
  virtual void record(std::vector<HybridEvent>* events) = 0;
  /// The mode in which the next calls start; -1: the one that follows from the state.
  virtual void start_in(int mode) = 0;
  /// Where the last successful call ended; sliding modes have indices of their own.
  virtual int end_mode() const = 0;
  /// For messages and tables.
  virtual const std::string& mode_name(int mode) const = 0;
};

}  // namespace saltus
