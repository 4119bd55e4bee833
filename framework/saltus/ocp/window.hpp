// When does a term act? Instants, and the window between two of them.
#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace saltus {

/// A point in time: seconds, or a named event of the problem's Schedule.
class Instant {
 public:
  /// So many seconds on the window's clock.
  Instant(double seconds) : seconds_(seconds) {}  // NOLINT(google-explicit-constructor)
  Instant(const Instant& other);
  Instant(Instant&& other) noexcept;
  Instant& operator=(const Instant& other);
  Instant& operator=(Instant&& other) noexcept;
  ~Instant();
  /// When the event of this name is, wherever the schedule puts it.
  static Instant of_event(std::string name) { return Instant(std::move(name)); }

  /// Whether it is an event's.
  bool is_event() const { return !event_.empty(); }
  /// Its name; empty: a number.
  const std::string& event() const { return event_; }
  /// The number, s.
  double seconds() const { return seconds_; }
  friend bool operator==(const Instant&, const Instant&) = default;

 private:
  explicit Instant(std::string name) : event_(std::move(name)) {}
  double seconds_ = 0.0;
  std::string event_;
};

/// The instant at which the named event of the schedule happens; moves when the event is retimed.
inline Instant event(std::string name) { return Instant::of_event(std::move(name)); }

/// What the seconds of an Instant count from. Events are always absolute.
enum class Clock { phase, absolute };

/// The half-open interval [from, to). Conventions, see framework/design/conventions.md:
/// inputs and running costs act in [from, to); a window without `to` includes the end of the
/// phase; a constraint on states alone also holds at the left limit of `to`. Without `from` the
/// window opens with the phase. With `modes` the window is cut down to where one of them is in
/// force: one half-open interval from event to event for each time that a mode occurs.
struct Window {
  std::optional<Instant> from = std::nullopt;  ///< not before; nothing: from the start
  std::optional<Instant> to = std::nullopt;    ///< not after; nothing: to the end
  Clock clock = Clock::phase;                  ///< in phase time or in absolute time
  std::vector<std::string> modes = {};  ///< names that the problem's Schedule knows; empty: any

  /// Whether it is all of the phase.
  bool is_whole() const { return !from && !to && modes.empty(); }
};

/// While one of these modes is in force, however often they occur: during("left", "both").
template <std::convertible_to<std::string>... Names>
  requires(sizeof...(Names) > 0)
Window during(Names... modes) {
  return {.modes = {std::string(std::move(modes))...}};
}

/// Instants of time closer than this (s) are one instant: an event this close to a node is that
/// node. Far below any sampling time in use, far above the rounding of times in double precision.
inline constexpr double same_instant = 1e-6;

}  // namespace saltus
