// An interrupt that is noted, so that work ends where its results are whole.
#pragma once

#include <csignal>

namespace saltus {

/// While it lives, SIGINT and SIGTERM are only noted. Who works looks at `received` now and then,
/// keeps what there is, and raises the signal again when this is gone: callers see its status. One
/// at a time.
class NoteSignals {
 public:
  NoteSignals();
  ~NoteSignals();
  NoteSignals(const NoteSignals&) = delete;
  NoteSignals& operator=(const NoteSignals&) = delete;

  /// The last one since this began, or 0.
  static int received();

 private:
  struct sigaction before_int_ = {}, before_term_ = {};
};

}  // namespace saltus
