// Active periods of terms: instants, and windows between two of them.
#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace saltus {

/// A point in time: a number of seconds or a named event of the problem's Schedule.
class Instant {
 public:
  /// A time on the window's clock, s.
  Instant(double seconds) : seconds_(seconds) {}  // NOLINT(google-explicit-constructor)
  Instant(const Instant& other);
  Instant(Instant&& other) noexcept;
  Instant& operator=(const Instant& other);
  Instant& operator=(Instant&& other) noexcept;
  ~Instant();
  /// The time of the event with this name. Follows the schedule.
  static Instant of_event(std::string name) { return Instant(std::move(name)); }

  /// True if it refers to an event.
  bool is_event() const { return !event_.empty(); }
  /// Name of the event. Empty for a number.
  const std::string& event() const { return event_; }
  /// The time of an instant that is a number, s.
  double seconds() const { return seconds_; }
  friend bool operator==(const Instant&, const Instant&) = default;

 private:
  explicit Instant(std::string name) : event_(std::move(name)) {}
  double seconds_ = 0.0;
  std::string event_;
};

/// The instant of the named event. It moves when the event is retimed.
inline Instant event(std::string name) { return Instant::of_event(std::move(name)); }

/// Origin of the seconds of an Instant. Events are always absolute.
enum class Clock { phase, absolute };

/// The half-open interval [from, to); framework/design/conventions.md has the conventions. Inputs
/// and running costs are active in [from, to). A window without `to` includes the end of the phase.
/// A constraint on states alone also holds at the left limit of `to`. A window without `from`
/// begins with the phase. With `modes`, the window applies only while one of them is active: one
/// half-open interval from event to event per occurrence of a mode.
struct Window {
  std::optional<Instant> from = std::nullopt;  ///< start; empty: start of the phase
  std::optional<Instant> to = std::nullopt;    ///< end; empty: end of the phase
  Clock clock = Clock::phase;                  ///< origin of times given in seconds
  std::vector<std::string> modes = {};  ///< names of modes in the problem's Schedule; empty: any

  /// True if it covers the whole phase.
  bool is_whole() const { return !from && !to && modes.empty(); }
};

/// Window in which one of these modes is active, in all their occurrences: during("left", "both").
template <std::convertible_to<std::string>... Names>
  requires(sizeof...(Names) > 0)
Window during(Names... modes) {
  return {.modes = {std::string(std::move(modes))...}};
}

/// Instants closer than this count as one, in seconds: an event this close to a node is at that
/// node. Far below any control period and far above the rounding error of times.
inline constexpr double same_instant = 1e-6;

}  // namespace saltus
