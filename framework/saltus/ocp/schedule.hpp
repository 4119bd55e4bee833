// Sequence of modes in absolute time: N modes and the N-1 events between them. Events can be
// retimed, inserted, replaced and erased between solves, within a capacity declared once.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "saltus/core/short_name.hpp"

namespace saltus {

/// A named instant at which the mode changes. An infinite time lies beyond every horizon.
struct Event {
  ShortName name;     ///< identifies the event
  double time = 0.0;  ///< absolute, s
};

/// Modes in order and the events between them. Event times do not decrease. Modes may repeat, event
/// names may not. If an edit throws DefinitionError, the schedule is unchanged. Edits do not
/// allocate without an error.
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
    if (!has_mode(i)) refuse_mode(i);
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
  /// Moves an event and all later events by the same amount, so that durations of later modes stay.
  void retime_from(std::string_view event, double time);
  /// Records that the event happened at `time`, early or late. Later events move by the same
  /// amount. Earlier events still pending are skipped: they move to the same instant.
  void confirm(std::string_view event, double time);
  /// Records that the event has not happened yet. If it is due before now + lead, moves it to that
  /// time, and later events with it. With lead >= one control period, the input of the next period
  /// belongs to the old mode.
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
  [[noreturn]] void refuse_mode(int i) const;

  Names names_ = no_names();
  std::vector<int> sequence_;  // indices into names_; the first count_ + 1 are used
  std::vector<Event> events_;  // the first count_ are used
  std::size_t count_ = 0;
};

}  // namespace saltus
