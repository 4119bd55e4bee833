#include "problems/quadruped/gait.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "problems/quadruped/problem.hpp"

namespace saltus::quadruped {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr int events_per_leg = 8;
constexpr int events_at_a_time = 16;  // events of all legs within a horizon

JointSchedule standing() {
  std::vector<Schedule> each;
  for (int leg = 0; leg < legs; ++leg)
    each.push_back(Schedule({on_ground(leg)}, {}).declare({in_air}).reserve(events_per_leg));
  return {std::move(each), events_at_a_time};
}

// The first event that leads to a mode: 0 stance, 1 swing.
const Event* next_into(const Schedule& leg, int mode) {
  for (int i = 0; i < static_cast<int>(leg.events().size()); ++i)
    if (leg.number_of_mode(i + 1) == mode) return &leg.events()[i];
  return nullptr;
}
double time_of(const Event* event) { return event == nullptr ? never : event->time; }

}  // namespace

Gait::Gait(const GaitSettings& settings, double horizon, double tick)
    : settings_(settings), horizon_(horizon), tick_(tick), contacts_(standing()) {
  write_ahead(horizon_);
  contacts_.join(0.0, horizon_);
}

double Gait::next_lift(int leg) const { return time_of(next_into(contacts_.part(leg), 1)); }
double Gait::next_landing(int leg) const { return time_of(next_into(contacts_.part(leg), 0)); }

void Gait::update(double now, const Touching& touching) {
  if (!settings_.blind) {
    land_early(now, touching);
    put_off(now, touching);
  }
  write_ahead(now + horizon_ + settings_.period);
  for (int leg = 0; leg < legs; ++leg) {
    Leg& l = legs_[leg];
    if (l.stands && next_lift(leg) <= now) {
      l.lifted = next_lift(leg);
      l.due = next_landing(leg);
    }
    if (!l.stands && next_landing(leg) <= now && l.is_overdue) {
      ++late_;
      l.is_overdue = false;
    }
    contacts_.part(leg).forget_until(now);
    l.stands = contacts_.part(leg).number_of_mode(0) == 0;
  }
  contacts_.join(now, now + horizon_);
}

void Gait::land_early(double now, const Touching& touching) {
  for (int leg = 0; leg < legs; ++leg) {
    const Leg& l = legs_[leg];
    const bool is_second_half = now > 0.5 * (l.lifted + l.due);
    if (l.stands || !touching[leg] || !is_second_half) continue;
    const Event* landing = next_into(contacts_.part(leg), 0);
    if (now < l.due - tick_) ++early_;
    contacts_.part(leg).retime(landing->name, now);
  }
}

void Gait::put_off(double now, const Touching& touching) {
  bool has_overdue = false;
  for (int leg = 0; leg < legs; ++leg) {
    const Event* landing = next_into(contacts_.part(leg), 0);
    if (legs_[leg].stands || touching[leg] || landing->time >= now + tick_) continue;
    has_overdue = true;
    legs_[leg].is_overdue = legs_[leg].is_overdue || landing->time <= now;
    wait(now + tick_ + settings_.shortest_stance * stance() - next_lift(leg));
    contacts_.part(leg).retime(landing->name, now + tick_);
  }
  if (!has_overdue) return;
  for (int leg = 0; leg < legs; ++leg)
    if (legs_[leg].stands) wait(now + tick_ - next_lift(leg));
}

// Postpones the lift-off of every leg if necessary.
void Gait::wait(double seconds) {
  if (!(seconds > 0.0)) return;
  for (int leg = 0; leg < legs; ++leg)
    if (const Event* lift = next_into(contacts_.part(leg), 1))
      contacts_.part(leg).retime_from(lift->name, lift->time + seconds);
  waited_ += seconds;
}

void Gait::write_ahead(double until) {
  for (int leg = 0; leg < legs; ++leg) {
    Schedule& schedule = contacts_.part(leg);
    Leg& l = legs_[leg];
    for (;;) {
      const std::span<const Event> events = schedule.events();
      // One period after the last swing, or at the start of the gait.
      double lift = settings_.begin + settings_.lifts_at[leg] * settings_.period;
      if (l.written > 0) {
        if (events.empty()) break;
        lift = events.back().time + stance();
      }
      if (lift > until) break;
      const auto name = [&](const char* what) {
        std::array<char, 48> text{};
        const auto end =
            fmt::format_to_n(text.data(), text.size(), "{} {} {}", leg_names[leg], what, l.written);
        return ShortName(std::string_view(text.data(), end.size));
      };
      schedule.insert(in_air, name("lifts"), lift);
      schedule.insert(schedule.known_modes()[0], name("lands"),
                      lift + (1.0 - settings_.duty) * settings_.period);
      ++l.written;
    }
  }
}

}  // namespace saltus::quadruped
