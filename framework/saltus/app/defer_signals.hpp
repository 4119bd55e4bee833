// Records an interrupt, so that work stops when its results are complete.
#pragma once

#include <csignal>

namespace saltus {

/// While an object lives, the first SIGINT or SIGTERM is only recorded. The caller polls
/// `received`, saves its results, and raises the signal again after this object is destroyed, so
/// that the parent process sees the signal. A second signal of either kind ends the process at
/// once: after the first one, both kinds have their default action. Only one object may live at a
/// time.
class DeferSignals {
 public:
  DeferSignals();
  ~DeferSignals();
  DeferSignals(const DeferSignals&) = delete;
  DeferSignals& operator=(const DeferSignals&) = delete;

  /// The signal recorded since the last object was created, or 0.
  static int received();

 private:
  struct sigaction before_int_ = {}, before_term_ = {};
};

}  // namespace saltus
