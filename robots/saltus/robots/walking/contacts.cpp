#include "saltus/robots/walking/contacts.hpp"

#include <algorithm>
#include <iterator>

namespace saltus::robots::walking {
namespace {

constexpr const char* lift_offs[] = {lift_off, "second lift-off"};
constexpr const char* impacts[] = {impact, "second impact"};

Schedule with_room(Schedule contacts, int events) {
  contacts.declare({left_support, right_support, double_support});
  contacts.reserve(std::max(events, static_cast<int>(contacts.events().size())));
  return contacts;
}

}  // namespace

Schedule one_foot_then_two(double landing, Side stance, int events) {
  return with_room(Schedule({support_of(stance), double_support}, {{impact, landing}}), events);
}

Schedule two_feet_throughout(int events) {
  return with_room(Schedule({double_support}, {}), events);
}

void schedule_contacts(Schedule& contacts, bool left_stands, bool right_stands,
                       std::span<const StepPlan::Step> steps) {
  while (!contacts.events().empty()) contacts.erase(contacts.events().back().name.view());
  const bool both = left_stands && right_stands;
  contacts.replace_first(both ? double_support
                              : support_of(left_stands ? Side::left : Side::right));
  bool in_the_air = !both;
  double last = -infinity;
  const auto add = [&](const char* mode, const char* event, double time) {
    last = std::max(last, time);
    if (static_cast<int>(contacts.events().size()) < contacts.capacity())
      contacts.insert(mode, event, last);
  };
  for (std::size_t i = 0; i < std::min(std::size(impacts), steps.size()); ++i) {
    if (!in_the_air) add(support_of(other(steps[i].foot)), lift_offs[i], steps[i].lift_off);
    add(double_support, impacts[i], steps[i].landing);
    in_the_air = false;
  }
}

double landing_time(const Schedule& contacts) {
  if (contacts.contains(impact)) return contacts.time_of(impact);
  return contacts.mode(0) == double_support ? -infinity : infinity;
}

}  // namespace saltus::robots::walking
