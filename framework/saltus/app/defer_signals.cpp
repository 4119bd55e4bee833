#include "saltus/app/defer_signals.hpp"

namespace saltus {
namespace {

volatile std::sig_atomic_t last_signal = 0;

// Calls only async-signal-safe functions. A second signal during this call is blocked (sa_mask) and
// takes its default action when the call returns.
void note_first(int signal) {
  last_signal = signal;
  struct sigaction by_default = {};
  by_default.sa_handler = SIG_DFL;
  ::sigaction(SIGINT, &by_default, nullptr);
  ::sigaction(SIGTERM, &by_default, nullptr);
}

}  // namespace

DeferSignals::DeferSignals() {
  last_signal = 0;
  struct sigaction note = {};
  note.sa_handler = note_first;  // no SA_RESTART: system calls return
  ::sigemptyset(&note.sa_mask);
  ::sigaddset(&note.sa_mask, SIGINT);
  ::sigaddset(&note.sa_mask, SIGTERM);
  ::sigaction(SIGINT, &note, &before_int_);
  ::sigaction(SIGTERM, &note, &before_term_);
}

DeferSignals::~DeferSignals() {
  ::sigaction(SIGINT, &before_int_, nullptr);
  ::sigaction(SIGTERM, &before_term_, nullptr);
}

int DeferSignals::received() { return last_signal; }

}  // namespace saltus
