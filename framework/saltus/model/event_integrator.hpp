// Interface of integrators with events: a record of the events, and a mode that persists between
// intervals.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Effect of an event inside an interval.
enum class EventKind {
  crosses,  ///< the dynamics change, the state is continuous
  jumps,    ///< the state is reset
  slides,   ///< sliding begins
  leaves,   ///< sliding ends
};
/// Text for messages.
const char* describe(EventKind kind);

/// A recorded event.
struct HybridEvent {
  double time = 0.0;                          ///< s
  EventKind kind = EventKind::crosses;        ///< effect of the event
  std::string name, mode_before, mode_after;  ///< name of the event and modes before and after it
  VectorXd before, after;                     ///< states x-, x+
  /// d time / d w of the interval (x0 | c | p | t0 | h). In a simulation: d time / d (x0 | p) of
  /// the whole simulation.
  VectorXd time_derivative;
};

/// An integrator that locates events inside an interval and continues after them.
class EventIntegrator : public Integrator {
 public:
  using Integrator::Integrator;

  /// Appends the events of the following calls to `events`, which is not owned. Null stops
  /// recording. Recording allocates; integration itself does not.
  virtual void record(std::vector<HybridEvent>* events) = 0;
  /// Mode in which the following calls start. -1: derive the mode from the state.
  virtual void start_in(int mode) = 0;
  /// Mode at the end of the last successful call. Sliding modes have separate indices.
  virtual int end_mode() const = 0;
  /// Name of a mode, for messages and tables.
  virtual const std::string& mode_name(int mode) const = 0;
};

}  // namespace saltus
