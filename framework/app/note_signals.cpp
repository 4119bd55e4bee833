#include "saltus/app/note_signals.hpp"

namespace saltus {
namespace {

volatile std::sig_atomic_t last_signal = 0;

}  // namespace

NoteSignals::NoteSignals() {
  last_signal = 0;
  struct sigaction note = {};
  note.sa_handler = [](int signal) { last_signal = signal; };  // no SA_RESTART: waits end
  ::sigaction(SIGINT, &note, &before_int_);
  ::sigaction(SIGTERM, &note, &before_term_);
}

NoteSignals::~NoteSignals() {
  ::sigaction(SIGINT, &before_int_, nullptr);
  ::sigaction(SIGTERM, &before_term_, nullptr);
}

int NoteSignals::received() { return last_signal; }

}  // namespace saltus
