#include "saltus/robots/walking/progress.hpp"

#include <fmt/format.h>

#include <cmath>

#include "saltus/ocp/schedule.hpp"

namespace saltus::robots::walking {
namespace {

constexpr double terminal_period = 0.05;  // s of wall clock; a faster update is not readable
constexpr double line_period = 1.0;       // s simulated

}  // namespace

const char* describe(LoopState::Footing footing) {
  constexpr const char* names[] = {"standing", "pushed", "stepping", "landed"};
  return names[static_cast<int>(footing)];
}

std::string progress_line(const LoopState& s, double wall_clock) {
  const double factor = wall_clock > 0.0 ? s.time / wall_clock : 0.0;
  return fmt::format(
      "t = {:5.2f} s | {:4.1f} x real time | CoM {:.3f} m | capture point {:3.0f} mm {} | {}",
      s.time, factor, s.com_height, 1e3 * std::abs(s.margin), s.margin < 0.0 ? "outside" : "inside",
      describe(s.footing));
}

void Progress::show(const LoopState& state) {
  state_ = state;
  shown_ = false;
  const double now = seconds_since(begin_);
  if ((terminal_ ? now : state.time + same_instant) < next_) return;
  print(now);
  next_ = terminal_ ? now + terminal_period : next_ + line_period;
}

void Progress::finish() {
  if (!shown_) print(seconds_since(begin_));
  if (terminal_) fmt::print(out_, "\n");
}

// On a terminal, rewrites the line and clears its rest.
void Progress::print(double now) {
  const std::string line = progress_line(state_, now);
  if (terminal_)
    fmt::print(out_, "\r{}\x1b[K", line);
  else
    fmt::print(out_, "{}\n", line);
  std::fflush(out_);
  shown_ = true;
}

}  // namespace saltus::robots::walking
