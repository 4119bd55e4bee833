// Sequence of modes in absolute time: N modes and the N-1 events between them. Events can be
// retimed, inserted, replaced and erased between solves, within a capacity declared once.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"

namespace saltus {

// A name of bounded length, stored in place. Copying and assigning never allocate.

/// Text of bounded length without allocation. Converts to std::string_view. The constructor throws
/// DefinitionError if the text is longer than max_size.
class ShortName {
 public:
  static constexpr std::size_t max_size = 63;  // with the length, one cache line

  ShortName() = default;
  /// Copies the text. Throws DefinitionError if it is longer than max_size.
  template <class Text>
    requires std::convertible_to<const Text&, std::string_view>
  ShortName(const Text& text) {  // NOLINT(google-explicit-constructor)
    assign(text);
  }

  /// The text. Valid during the lifetime of this object.
  std::string_view view() const { return {text_.data(), size_}; }
  /// The text as a std::string.
  std::string str() const { return std::string(view()); }
  /// Same as view().
  operator std::string_view() const { return view(); }  // NOLINT(google-explicit-constructor)
  /// Compares the texts.
  friend bool operator==(const ShortName& a, const ShortName& b) { return a.view() == b.view(); }

 private:
  void assign(std::string_view text) {
    if (text.size() > max_size)
      throw DefinitionError("the name '" + std::string(text) + "' has " +
                            std::to_string(text.size()) + " characters, but a name has at most " +
                            std::to_string(max_size));
    std::copy(text.begin(), text.end(), text_.begin());
    size_ = static_cast<unsigned char>(text.size());
  }

  std::array<char, max_size> text_{};
  unsigned char size_ = 0;
};

// Active periods of terms: instants, and windows between two of them.

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

/// A named instant at which the mode changes. An infinite time lies beyond every horizon.
struct Event {
  ShortName name;     ///< identifies the event
  double time = 0.0;  ///< absolute, s
};

/// Modes in order and the events between them. Event times do not decrease. Modes may repeat, event
/// names may not. If an edit throws DefinitionError, the schedule is unchanged. Edits
/// allocate only if they throw.
class Schedule {
 public:
  Schedule();
  Schedule(const Schedule& other);
  Schedule(Schedule&& other) noexcept;
  Schedule& operator=(const Schedule& other);
  Schedule& operator=(Schedule&& other) noexcept;
  ~Schedule();
  /// Throws DefinitionError if the counts do not match, a name repeats or times decrease.
  Schedule(std::vector<std::string> modes, std::vector<Event> events);

  // Set-up: possible modes and capacity. These two functions allocate.

  /// Declares further modes that may be inserted. At most 64 different modes in total.
  Schedule& declare(const std::vector<std::string>& modes);
  /// Reserves capacity for this number of events, at least the present number.
  Schedule& reserve(int events);

  // Queries.

  /// The events in order of time.
  std::span<const Event> events() const { return {events_.data(), count_}; }
  /// Maximum number of events.
  int capacity() const { return static_cast<int>(events_.size()); }
  /// Mode i, between events i - 1 and i. Throws DefinitionError if there is no such mode.
  const std::string& mode(int i) const;
  /// All declared modes, each once. The position is the number of the mode.
  const std::vector<std::string>& known_modes() const { return *names_; }
  /// Number of mode i, which follows event i - 1. Throws like mode().
  int number_of_mode(int i) const {
    if (!has_mode(i)) throw_no_mode(i);
    return sequence_[i];
  }

  /// Time of the event, s. Throws DefinitionError with the nearest known event.
  double time_of(std::string_view event) const;
  /// Index of the event. Throws DefinitionError with the nearest known event.
  int index_of(std::string_view event) const;
  /// True if there is an event with this name.
  bool contains(std::string_view event) const;
  /// The active mode at time t. At an event, this is the new mode. Throws like mode(), and throws
  /// DefinitionError for NaN.
  const std::string& mode_at(double t) const;
  /// Bit set of these modes: bit m is mode m. Throws DefinitionError with the nearest known mode.
  std::uint64_t mask_of(std::span<const std::string> modes) const;

  // Edits between solves.

  /// Makes `mode` active from `time` to the next event.
  void insert(std::string_view mode, std::string_view event, double time);
  /// Removes the event and the mode after it. The mode before it lasts until the next event.
  void erase(std::string_view event);
  /// Replaces the mode after the event.
  void replace(std::string_view event, std::string_view mode);
  /// Replaces the mode before the first event.
  void replace_first(std::string_view mode);
  /// Removes events up to time t. The mode after the last of them becomes the first mode.
  void forget_until(double t);
  /// Moves one event. Throws DefinitionError without a change if the order would break.
  void retime(std::string_view event, double time);
  /// Moves an event and all later events by the same amount, so that the durations of later modes
  /// do not change.
  void retime_from(std::string_view event, double time);
  /// Records that the event happened at `time`, early or late. Later events move by the same
  /// amount. Earlier events still pending are skipped: they move to the same instant.
  void confirm(std::string_view event, double time);
  /// Records that the event has not happened yet. If it is due before now + lead, moves it to that
  /// time and shifts later events by the same amount. With lead >= one control period, the input of
  /// the next period belongs to the old mode.
  void hold(std::string_view event, double now, double lead);
  /// Moves all events `elapsed` seconds earlier, for a clock whose origin moved forward.
  void shift(double elapsed);
  /// Copies the modes and events of `other`, within the modes and the capacity declared here.
  void adopt(const Schedule& other);

  /// True if modes, events and times are equal.
  friend bool operator==(const Schedule& a, const Schedule& b);

 private:
  using Names = std::shared_ptr<const std::vector<std::string>>;
  static const Names& no_names();
  int number_of(std::string_view mode) const;
  bool has_mode(int i) const {
    return i >= 0 && !sequence_.empty() && i <= static_cast<int>(count_);
  }
  [[noreturn]] void throw_no_mode(int i) const;

  Names names_ = no_names();
  std::vector<int> sequence_;  // indices into names_; the first count_ + 1 are used
  std::vector<Event> events_;  // the first count_ are used
  std::size_t count_ = 0;
};

// Several independent schedules, for example one per leg, and the schedule of their joint modes.

/// Several schedules that run at the same time, such as one per leg. Each part is edited like a
/// single schedule. A joint mode combines one mode per part and joins their names: "FL - - RR". It
/// changes when any part changes. There are at most 64 joint modes.
///
///     JointSchedule contacts({leg("left"), leg("right")}, 8);
///     phase.bound_input(0, exactly(0.0), contacts.during(0, "swing"));
///     contacts.part(0).retime("left lands", 0.31);
///     controller.set_schedule(contacts.join(now, now + horizon));
class JointSchedule {
 public:
  /// `capacity` is the maximum number of events of the joint schedule. Throws DefinitionError if
  /// there is no part or if there are too many joint modes.
  JointSchedule(std::vector<Schedule> parts, int capacity);

  /// Number of parts.
  int parts() const { return static_cast<int>(parts_.size()); }
  /// The schedule of part i, for editing. join() applies the edits. Throws DefinitionError if there
  /// is no such part.
  Schedule& part(int i) { return parts_[checked(i)]; }
  /// The schedule of part i. Throws like the other part().
  const Schedule& part(int i) const { return parts_[checked(i)]; }

  /// Window in which part i is in this mode, for any modes of the other parts. Throws
  /// DefinitionError with the nearest known mode, and if there is no such part.
  Window during(int i, const std::string& mode) const;

  /// The joint schedule of (from, to]. It excludes events before and after. Simultaneous events of
  /// several parts become one event with the name of the first. Allocates only if it throws.
  /// Throws DefinitionError if the events exceed the capacity, or if two events at different times
  /// have the same name.
  const Schedule& join(double from, double to);
  /// The result of the last join().
  const Schedule& joined() const { return joined_; }

 private:
  std::size_t checked(int i) const;

  // Joint modes are numbers in a mixed radix whose digits are the modes of the parts.
  struct Digit {
    int stride = 1;    // change of the joint mode per step of the part's mode
    int position = 0;  // index of the part's active mode in its schedule
  };

  std::vector<Schedule> parts_;
  std::vector<Digit> digits_;
  Schedule joined_;
};

}  // namespace saltus
