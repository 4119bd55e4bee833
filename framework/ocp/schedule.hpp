// The order of modes in absolute time: N modes and the N-1 events between them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// A named instant at which the mode changes. Infinite time: the event lies beyond every horizon.
struct Event {
  std::string name;
  double time = 0.0;  ///< s, absolute
};

/// Modes in order and the events that separate them. Event times may be edited between solves and
/// must not decrease along the schedule.
class Schedule {
 public:
  Schedule() = default;
  /// Throws DefinitionError when the counts do not fit, a name repeats or times decrease.
  Schedule(std::vector<std::string> modes, std::vector<Event> events);

  const std::vector<std::string>& modes() const { return modes_; }
  const std::vector<Event>& events() const { return events_; }

  /// Time of the named event (s). Throws DefinitionError naming the nearest known event.
  double time_of(std::string_view event) const;
  int index_of(std::string_view event) const;
  /// The mode in force at time t; at the event itself the new mode.
  const std::string& mode_at(double t) const;

  /// Moves one event. Throws DefinitionError, changing nothing, if the order would break.
  void retime(std::string_view event, double time);
  /// All events `elapsed` seconds earlier: the schedule seen from a clock that has moved on.
  void shift(double elapsed);

 private:
  std::vector<std::string> modes_;
  std::vector<Event> events_;
};

}  // namespace saltus
