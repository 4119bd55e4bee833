// The order of modes in absolute time: N modes and the N-1 events between them, which may be
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

/// A named instant at which the mode changes. Infinite time: the event lies beyond every horizon.
struct Event {
  ShortName name;     ///< by which it is moved, inserted and erased
  double time = 0.0;  ///< s, absolute
};

/// Modes in order and the events that separate them; times do not decrease along the schedule. A
/// mode may occur any number of times, an event's name once. Whatever is edited, a DefinitionError
/// leaves the schedule as it was, and nothing allocates as long as nothing is wrong.
class Schedule {
 public:
  Schedule();
  Schedule(const Schedule& other);
  Schedule(Schedule&& other) noexcept;
  Schedule& operator=(const Schedule& other);
  Schedule& operator=(Schedule&& other) noexcept;
  ~Schedule();
  /// Throws DefinitionError when the counts do not fit, a name repeats or times decrease.
  Schedule(std::vector<std::string> modes, std::vector<Event> events);

  // --- set-up: what the schedule may become (these two allocate)

  /// Names of further modes that may be inserted; at most 64 different ones in all.
  Schedule& declare(const std::vector<std::string>& modes);
  /// Room for so many events at a time; never less than there are.
  Schedule& reserve(int events);

  // --- what it is

  /// In the order of time.
  std::span<const Event> events() const { return {events_.data(), count_}; }
  /// How many events there is room for.
  int capacity() const { return static_cast<int>(events_.size()); }
  /// Mode i lies between events i - 1 and i. Throws DefinitionError where there is no mode.
  const std::string& mode(int i) const;
  /// All modes that there may be, each once: its position is its number.
  const std::vector<std::string>& known_modes() const { return *names_; }
  /// Of the mode behind event i - 1. Throws as mode().
  int number_of_mode(int i) const {
    if (!has_mode(i)) refuse_mode(i);
    return sequence_[i];
  }

  /// Time of the named event (s). Throws DefinitionError naming the nearest known event.
  double time_of(std::string_view event) const;
  /// Position of the named event. Throws DefinitionError naming the nearest known event.
  int index_of(std::string_view event) const;
  /// Whether there is an event of the name.
  bool contains(std::string_view event) const;
  /// The mode in force at time t; at the event itself the new mode. Throws as mode(), and
  /// DefinitionError for NaN.
  const std::string& mode_at(double t) const;
  /// Bit m is set for mode m. Throws DefinitionError naming the nearest known mode.
  std::uint64_t mask_of(std::span<const std::string> modes) const;

  // --- edits between solves

  /// From `time` to the event after it, `mode` is in force; before it, what was.
  void insert(std::string_view mode, std::string_view event, double time);
  /// The mode that the event opens goes with it; the one before lasts until the next event.
  void erase(std::string_view event);
  /// Another mode is opened by the event.
  void replace(std::string_view event, std::string_view mode);
  /// Another mode is in force before the first event.
  void replace_first(std::string_view mode);
  /// Events up to time t are over: only the mode that they led to is kept, as the first.
  void forget_until(double t);
  /// Moves one event. Throws DefinitionError, changing nothing, if the order would break.
  void retime(std::string_view event, double time);
  /// Moves an event and all later ones by as much, so that their modes last as long as before.
  void retime_from(std::string_view event, double time);
  /// The event has happened at `time`, early or late: later ones move along. Events that should
  /// have come before it are skipped: they move to the same instant.
  void confirm(std::string_view event, double time);
  /// The event has not happened yet: if it is due before now + lead, it is put off until then,
  /// and later ones with it. With lead >= one period a tick's input is all of the old mode.
  void hold(std::string_view event, double now, double lead);
  /// All events `elapsed` seconds earlier: the schedule seen from a clock that has moved on.
  void shift(double elapsed);
  /// Becomes what `other` is, within the modes and the capacity declared here.
  void adopt(const Schedule& other);

  /// The same modes in the same order with the same events at the same times.
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
  std::vector<int> sequence_;  // numbers of the modes; count_ + 1 of them count
  std::vector<Event> events_;  // count_ of them count
  std::size_t count_ = 0;
};

}  // namespace saltus
