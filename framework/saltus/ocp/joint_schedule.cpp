#include "saltus/ocp/schedule.hpp"

#include <fmt/format.h>

#include <bit>
#include <limits>
#include <span>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr std::size_t max_modes = 64;  // same limit as for a Schedule

}  // namespace

JointSchedule::JointSchedule(std::vector<Schedule> parts, int capacity)
    : parts_(std::move(parts)), digits_(parts_.size()) {
  if (parts_.empty()) throw DefinitionError("joint schedule: it has no part");
  std::vector<std::string> names{""};
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].known_modes().empty())
      throw DefinitionError(
          fmt::format("joint schedule: part {} has no mode; construct it with its first mode", i));
    digits_[i].stride = static_cast<int>(names.size());
    if (names.size() * parts_[i].known_modes().size() > max_modes)
      throw DefinitionError(
          fmt::format("joint schedule: the modes of parts 0 to {} give {} joint modes, but at most "
                      "{} are allowed",
                      i, names.size() * parts_[i].known_modes().size(), max_modes));
    std::vector<std::string> longer;
    for (const std::string& mode : parts_[i].known_modes())
      for (const std::string& name : names) longer.push_back(name + (i > 0 ? " " : "") + mode);
    names = std::move(longer);
  }
  joined_ = Schedule({names.front()}, {}).declare(names).reserve(capacity);
  join(-never, -never);
}

std::size_t JointSchedule::checked(int i) const {
  if (i < 0 || i >= parts())
    throw DefinitionError(
        fmt::format("joint schedule: it has {} parts, so there is no part {}", parts(), i));
  return static_cast<std::size_t>(i);
}

Window JointSchedule::during(int i, const std::string& mode) const {
  const auto wanted = static_cast<int>(std::countr_zero(part(i).mask_of({&mode, 1})));
  const int stride = digits_[i].stride, count = static_cast<int>(part(i).known_modes().size());
  Window window;
  const std::vector<std::string>& names = joined_.known_modes();
  for (int number = 0; number < static_cast<int>(names.size()); ++number)
    if (number / stride % count == wanted) window.modes.push_back(names[number]);
  return window;
}

const Schedule& JointSchedule::join(double from, double to) {
  int mode = 0;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Schedule& part = parts_[i];
    int& position = digits_[i].position = 0;
    while (position < static_cast<int>(part.events().size()) &&
           part.events()[position].time <= from)
      ++position;
    mode += digits_[i].stride * part.number_of_mode(position);
  }
  joined_.forget_until(never);
  joined_.replace_first(joined_.known_modes()[mode]);
  const Event* last = nullptr;
  for (;;) {
    std::size_t next = parts_.size();  // the part with the earliest next event
    double time = never;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const std::span<const Event> events = parts_[i].events();
      const auto position = static_cast<std::size_t>(digits_[i].position);
      if (position < events.size() && events[position].time < time) {
        next = i;
        time = events[position].time;
      }
    }
    if (next == parts_.size() || time > to) return joined_;
    const Schedule& part = parts_[next];
    int& position = digits_[next].position;
    mode +=
        digits_[next].stride * (part.number_of_mode(position + 1) - part.number_of_mode(position));
    const Event& event = part.events()[position++];
    const std::string& name = joined_.known_modes()[mode];
    if (last != nullptr && event.time < last->time + same_instant) {
      joined_.replace(last->name, name);
    } else {
      joined_.insert(name, event.name, event.time);
      last = &event;
    }
  }
}

}  // namespace saltus
