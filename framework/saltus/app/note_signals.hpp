// An interrupt that is noted, so that work ends where its results are whole.
#pragma once

#include <csignal>

namespace saltus {

/// While it lives, the first SIGINT or SIGTERM is only noted. The work polls `received`, keeps its
/// results, and raises the signal again after this object is gone, so that callers see the signal's
/// status. The second signal of either kind ends the process at once, wherever it is: from the
/// first on both have their default action, which the system carries out. One object at a time.
class NoteSignals {
 public:
  NoteSignals();
  ~NoteSignals();
  NoteSignals(const NoteSignals&) = delete;
  NoteSignals& operator=(const NoteSignals&) = delete;

  /// The signal that was noted since the last object was made, or 0.
  static int received();

 private:
  struct sigaction before_int_ = {}, before_term_ = {};
};

}  // namespace saltus
