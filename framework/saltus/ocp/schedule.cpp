#include "saltus/ocp/schedule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

constexpr std::size_t max_modes = 64;  // bits of a mask

[[noreturn]] void fail(const std::string& what) { throw DefinitionError("schedule: " + what); }

void check_time(std::string_view event, double time) {
  if (std::isnan(time)) fail(fmt::format("event '{}' has time NaN", event));
}

void check_pair(const Event& before, const Event& after) {
  if (after.time < before.time)
    fail(
        fmt::format("event '{}' at {} s comes after event '{}' at {} s in the order of "
                    "modes, so its time must not be smaller",
                    after.name.view(), after.time, before.name.view(), before.time));
}

void check_order(std::span<const Event> events) {
  for (std::size_t i = 0; i < events.size(); ++i) {
    check_time(events[i].name, events[i].time);
    if (i > 0) check_pair(events[i - 1], events[i]);
  }
}

}  // namespace

Schedule::Schedule() = default;
Schedule::Schedule(const Schedule& other) = default;
Schedule::Schedule(Schedule&& other) noexcept { *this = std::move(other); }
Schedule& Schedule::operator=(const Schedule& other) = default;
// The source becomes a schedule without modes, like a default-constructed one.
Schedule& Schedule::operator=(Schedule&& other) noexcept {
  if (&other == this) return *this;
  names_ = std::exchange(other.names_, no_names());
  sequence_ = std::exchange(other.sequence_, {});
  events_ = std::exchange(other.events_, {});
  count_ = std::exchange(other.count_, 0);
  return *this;
}
Schedule::~Schedule() = default;

Schedule::Schedule(std::vector<std::string> modes, std::vector<Event> events)
    : events_(std::move(events)), count_(events_.size()) {
  if (modes.size() != count_ + 1)
    fail(fmt::format("{} modes need {} events between them, but {} were given", modes.size(),
                     modes.empty() ? 0 : modes.size() - 1, count_));
  for (std::size_t i = 0; i < count_; ++i)
    if (index_of(events_[i].name) != static_cast<int>(i))
      fail(fmt::format("two events are called '{}'", events_[i].name.view()));
  check_order(this->events());
  declare(modes);
  for (const std::string& mode : modes) sequence_.push_back(number_of(mode));
}

Schedule& Schedule::declare(const std::vector<std::string>& modes) {
  std::vector<std::string> names = *names_;
  for (const std::string& mode : modes)
    if (std::find(names.begin(), names.end(), mode) == names.end()) names.push_back(mode);
  if (names.size() > max_modes)
    fail(fmt::format("{} different modes, but at most {} are allowed", names.size(), max_modes));
  names_ = std::make_shared<const std::vector<std::string>>(std::move(names));
  return *this;
}

Schedule& Schedule::reserve(int events) {
  if (sequence_.empty()) fail("it has no mode; construct it with its first mode");
  if (events < static_cast<int>(count_))
    fail(fmt::format("cannot reserve room for {} events, because it already has {}", events,
                     count_));
  if (constexpr int most = 1'000'000; events > most)
    fail(fmt::format("cannot reserve room for {} events, at most for {}", events, most));
  events_.resize(events);
  sequence_.resize(events + 1);
  return *this;
}

int Schedule::index_of(std::string_view event) const {
  for (std::size_t i = 0; i < count_; ++i)
    if (events_[i].name.view() == event) return static_cast<int>(i);
  std::vector<std::string> names;
  for (const Event& e : events()) names.push_back(e.name.str());
  fail(fmt::format("there is no event '{}'{}", event, did_you_mean(event, names)));
}

bool Schedule::contains(std::string_view event) const {
  return std::any_of(events().begin(), events().end(),
                     [&](const Event& e) { return e.name.view() == event; });
}

int Schedule::number_of(std::string_view mode) const {
  const auto found = std::find(names_->begin(), names_->end(), mode);
  if (found == names_->end())
    fail(fmt::format("there is no mode '{}'{}", mode, did_you_mean(mode, *names_)));
  return static_cast<int>(found - names_->begin());
}

std::uint64_t Schedule::mask_of(std::span<const std::string> modes) const {
  std::uint64_t mask = 0;
  for (const std::string& mode : modes) mask |= std::uint64_t{1} << number_of(mode);
  return mask;
}

double Schedule::time_of(std::string_view event) const { return events_[index_of(event)].time; }

const Schedule::Names& Schedule::no_names() {
  static const Names none = std::make_shared<const std::vector<std::string>>();
  return none;
}

void Schedule::throw_no_mode(int i) const {
  if (sequence_.empty()) fail("it has no mode; construct it with its first mode");
  fail(fmt::format("it has {} modes in order, so there is no mode {}", count_ + 1, i));
}

const std::string& Schedule::mode(int i) const {
  if (!has_mode(i)) throw_no_mode(i);
  return (*names_)[sequence_[i]];
}

const std::string& Schedule::mode_at(double t) const {
  if (std::isnan(t)) fail("there is no mode at time NaN");
  int i = 0;
  while (i < static_cast<int>(count_) && events_[i].time <= t) ++i;
  return mode(i);
}

// --- edits --------------------------------------------------------------------------------------

void Schedule::insert(std::string_view mode, std::string_view event, double time) {
  const int number = number_of(mode);
  const Event added{event, time};
  check_time(event, time);
  if (sequence_.empty()) fail("it has no mode; construct it with its first mode");
  if (contains(event)) fail(fmt::format("two events are called '{}'", event));
  if (count_ == events_.size())
    fail(
        fmt::format("event '{}' with mode '{}' would be number {}, but the declared capacity is "
                    "{}; increase it with reserve()",
                    event, mode, count_ + 1, events_.size()));
  std::size_t at = count_++;
  for (; at > 0 && events_[at - 1].time > time; --at) {
    events_[at] = events_[at - 1];
    sequence_[at + 1] = sequence_[at];
  }
  events_[at] = added;
  sequence_[at + 1] = number;
}

void Schedule::erase(std::string_view event) {
  const auto at = static_cast<std::size_t>(index_of(event));
  for (std::size_t i = at; i + 1 < count_; ++i) {
    events_[i] = events_[i + 1];
    sequence_[i + 1] = sequence_[i + 2];
  }
  --count_;
}

void Schedule::replace(std::string_view event, std::string_view mode) {
  const int at = index_of(event);
  sequence_[at + 1] = number_of(mode);
}

void Schedule::replace_first(std::string_view mode) {
  const int number = number_of(mode);
  if (sequence_.empty()) fail("it has no mode; construct it with its first mode");
  sequence_[0] = number;
}

void Schedule::forget_until(double t) {
  std::size_t over = 0;
  while (over < count_ && events_[over].time <= t) ++over;
  if (over == 0) return;
  for (std::size_t i = over; i < count_; ++i) events_[i - over] = events_[i];
  for (std::size_t i = over; i <= count_; ++i) sequence_[i - over] = sequence_[i];
  count_ -= over;
}

void Schedule::retime(std::string_view event, double time) {
  const int i = index_of(event);
  const double old = std::exchange(events_[i].time, time);
  try {
    check_order(events());
  } catch (...) {
    events_[i].time = old;
    throw;
  }
}

void Schedule::retime_from(std::string_view event, double time) {
  const auto first = static_cast<std::size_t>(index_of(event));
  check_time(event, time);
  if (first > 0) check_pair(events_[first - 1], {event, time});
  const double later = time - events_[first].time;
  // Infinite times stay infinite. Enforces the order despite rounding.
  double before = events_[first].time = time;
  for (std::size_t i = first + 1; i < count_; ++i) {
    if (std::isfinite(later)) events_[i].time += later;
    before = events_[i].time = std::max(events_[i].time, before);
  }
}

void Schedule::confirm(std::string_view event, double time) {
  const int at = index_of(event);
  check_time(event, time);
  for (int i = 0; i < at; ++i) events_[i].time = std::min(events_[i].time, time);
  retime_from(event, time);
}

void Schedule::hold(std::string_view event, double now, double lead) {
  if (!(std::isfinite(now) && lead >= 0.0 && std::isfinite(lead)))
    fail(
        fmt::format("event '{}' cannot be held {} s ahead of {} s: expected finite numbers and a "
                    "lead that is not negative",
                    event, lead, now));
  if (time_of(event) < now + lead) retime_from(event, now + lead);
}

void Schedule::shift(double elapsed) {
  if (!std::isfinite(elapsed)) fail(fmt::format("it cannot be shifted by {} s", elapsed));
  for (std::size_t i = 0; i < count_; ++i) events_[i].time -= elapsed;
}

void Schedule::adopt(const Schedule& other) {
  if (&other == this) return;
  if (other.count_ > events_.size())
    fail(
        fmt::format("it has {} events, but the declared capacity is {}; increase it with reserve()",
                    other.count_, events_.size()));
  if (other.sequence_.empty() != sequence_.empty())
    fail("a schedule with modes cannot replace one without modes, or vice versa");
  if (sequence_.empty()) return;
  if (other.names_ != names_)
    for (std::size_t i = 0; i <= other.count_; ++i) number_of(other.mode(static_cast<int>(i)));
  count_ = other.count_;
  std::copy_n(other.events_.begin(), count_, events_.begin());
  for (std::size_t i = 0; i <= count_; ++i)
    sequence_[i] =
        other.names_ == names_ ? other.sequence_[i] : number_of(other.mode(static_cast<int>(i)));
}

bool operator==(const Schedule& a, const Schedule& b) {
  if (a.count_ != b.count_ || a.sequence_.empty() != b.sequence_.empty()) return false;
  const auto same_event = [](const Event& e, const Event& f) {
    return e.time == f.time && e.name == f.name;
  };
  const std::span<const Event> events = a.events(), others = b.events();
  if (!std::equal(events.begin(), events.end(), others.begin(), same_event)) return false;
  if (a.sequence_.empty()) return true;
  for (std::size_t i = 0; i <= a.count_; ++i) {
    const bool same = a.names_ == b.names_
                          ? a.sequence_[i] == b.sequence_[i]
                          : a.mode(static_cast<int>(i)) == b.mode(static_cast<int>(i));
    if (!same) return false;
  }
  return true;
}

}  // namespace saltus
