#include "framework/ocp/schedule.hpp"

#include <fmt/format.h>

#include <cmath>
#include <set>
#include <utility>

#include "framework/core/error.hpp"
#include "framework/core/text.hpp"

namespace saltus {
namespace {

void check_order(const std::vector<Event>& events) {
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (std::isnan(events[i].time))
      throw DefinitionError(fmt::format("schedule: event '{}' has time NaN", events[i].name));
    if (i > 0 && events[i].time < events[i - 1].time)
      throw DefinitionError(
          fmt::format("schedule: event '{}' at {} s comes after event '{}' at {} s in the order of "
                      "modes, so its time must not be smaller",
                      events[i].name, events[i].time, events[i - 1].name, events[i - 1].time));
  }
}

}  // namespace

Schedule::Schedule(std::vector<std::string> modes, std::vector<Event> events)
    : modes_(std::move(modes)), events_(std::move(events)) {
  if (modes_.size() != events_.size() + 1)
    throw DefinitionError(
        fmt::format("schedule: {} modes need {} events between them, but {} were given",
                    modes_.size(), modes_.empty() ? 0 : modes_.size() - 1, events_.size()));
  std::set<std::string> names;
  for (const Event& e : events_)
    if (!names.insert(e.name).second)
      throw DefinitionError(fmt::format("schedule: two events are called '{}'", e.name));
  check_order(events_);
}

int Schedule::index_of(std::string_view event) const {
  for (std::size_t i = 0; i < events_.size(); ++i)
    if (events_[i].name == event) return static_cast<int>(i);
  std::vector<std::string> names;
  for (const Event& e : events_) names.push_back(e.name);
  const std::string near = nearest_name(event, names);
  throw DefinitionError(fmt::format("schedule: there is no event '{}'{}", event,
                                    near.empty() ? "" : "; did you mean '" + near + "'?"));
}

double Schedule::time_of(std::string_view event) const { return events_[index_of(event)].time; }

const std::string& Schedule::mode_at(double t) const {
  std::size_t mode = 0;
  while (mode < events_.size() && events_[mode].time <= t) ++mode;
  return modes_[mode];
}

void Schedule::retime(std::string_view event, double time) {
  const int i = index_of(event);
  const double old = std::exchange(events_[i].time, time);
  try {
    check_order(events_);
  } catch (...) {
    events_[i].time = old;
    throw;
  }
}

void Schedule::shift(double elapsed) {
  for (Event& e : events_) e.time -= elapsed;
}

}  // namespace saltus
