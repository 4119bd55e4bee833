// Tests modes, events and references in absolute time.
#include "saltus/ocp/schedule.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "saltus/core/error.hpp"
#include "saltus/ocp/term.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

Schedule walk() { return Schedule({"left", "both", "right"}, {{"land", 0.5}, {"lift", 0.8}}); }

template <class Action>
std::string message_of(const Action& action) {
  return error_of<DefinitionError>(action, "nothing was thrown");
}

void expect_in(const std::string& fragment, const std::string& text) {
  EXPECT_NE(text.find(fragment), std::string::npos) << "'" << fragment << "' is not in: " << text;
}

TEST(Schedule, NewModeIsActiveAtAnEvent) {
  const Schedule s = walk();
  EXPECT_EQ(s.mode_at(-1.0), "left");
  EXPECT_EQ(s.mode_at(0.5 - 1e-12), "left");
  EXPECT_EQ(s.mode_at(0.5), "both");
  EXPECT_EQ(s.mode_at(0.8), "right");
  EXPECT_EQ(s.mode_at(1e9), "right");
}

TEST(Schedule, SimultaneousEventsSkipTheModeBetween) {
  const Schedule s({"left", "both", "right"}, {{"land", 0.5}, {"lift", 0.5}});
  EXPECT_EQ(s.mode_at(0.5), "right");
}

TEST(Schedule, InfiniteEventsNeverOccur) {
  const Schedule s({"left", "both"}, {{"land", never}});
  EXPECT_EQ(s.mode_at(1e300), "left");
}

TEST(Schedule, RetimeIsAllOrNothing) {
  Schedule s = walk();
  s.retime("land", 0.7);
  EXPECT_EQ(s.time_of("land"), 0.7);
  const std::string order = message_of([&] { s.retime("land", 0.9); });
  expect_in("'lift' at 0.8 s", order);
  expect_in("'land' at 0.9 s", order);
  expect_in("NaN", message_of([&] { s.retime("land", std::nan("")); }));
  expect_in("did you mean 'land'", message_of([&] { s.retime("lnad", 0.6); }));
  EXPECT_EQ(s.time_of("land"), 0.7);
}

TEST(Schedule, ShiftMovesAllEventsAndKeepsInfinity) {
  Schedule s({"left", "both", "right"}, {{"land", 0.5}, {"lift", never}});
  s.shift(0.2);
  EXPECT_DOUBLE_EQ(s.time_of("land"), 0.3);
  EXPECT_EQ(s.time_of("lift"), never);
  for (const double nowhere : {std::nan(""), never})
    expect_in("cannot be shifted", message_of([&] { s.shift(nowhere); }));
  EXPECT_DOUBLE_EQ(s.time_of("land"), 0.3);
}

// "left 0.5:land both 0.8:lift right"
std::string text_of(const Schedule& s) {
  std::string text = s.mode(0);
  for (int i = 0; i < static_cast<int>(s.events().size()); ++i)
    text +=
        fmt::format(" {:.6g}:{} {}", s.events()[i].time, s.events()[i].name.view(), s.mode(i + 1));
  return text;
}

Schedule roomy() { return walk().declare({"flight"}).reserve(4); }

TEST(LiveSchedule, ModesAreInsertedErasedAndReplaced) {
  Schedule s = roomy();
  s.insert("flight", "take-off", 0.7);
  EXPECT_EQ(text_of(s), "left 0.5:land both 0.7:take-off flight 0.8:lift right");
  s.insert("left", "back", 0.8);  // at the same instant: after the existing event
  EXPECT_EQ(text_of(s), "left 0.5:land both 0.7:take-off flight 0.8:lift right 0.8:back left");
  s.erase("land");
  EXPECT_EQ(text_of(s), "left 0.7:take-off flight 0.8:lift right 0.8:back left");
  s.replace("lift", "both");
  s.replace_first("right");
  EXPECT_EQ(text_of(s), "right 0.7:take-off flight 0.8:lift both 0.8:back left");
  s.forget_until(0.7);
  EXPECT_EQ(text_of(s), "flight 0.8:lift both 0.8:back left");
  s.forget_until(0.9);
  EXPECT_EQ(text_of(s), "left");
  EXPECT_EQ(s.mode_at(-9.0), "left");
  s.insert("both", "land", -1.0);
  EXPECT_EQ(text_of(s), "left -1:land both");
}

TEST(LiveSchedule, MovingAnEventMovesLaterEvents) {
  Schedule s = roomy();
  s.insert("left", "back", 1.5);
  s.insert("both", "rest", never);
  const Schedule before = s;
  s.retime_from("lift", 1.0);
  EXPECT_EQ(text_of(s), "left 0.5:land both 1:lift right 1.7:back left inf:rest both");
  s.retime_from("lift", never);
  EXPECT_EQ(text_of(s), "left 0.5:land both inf:lift right inf:back left inf:rest both");
  s.retime_from("lift", 0.6);  // the previous durations of the modes are lost
  EXPECT_EQ(text_of(s), "left 0.5:land both 0.6:lift right inf:back left inf:rest both");
  s = before;
  s.retime_from("rest", never);
  EXPECT_EQ(text_of(s), text_of(before));
}

TEST(LiveSchedule, EarlyEventsHappenNowAndLateEventsAreHeld) {
  Schedule s = walk();
  s.hold("land", 0.3, 0.1);
  EXPECT_EQ(text_of(s), "left 0.5:land both 0.8:lift right");  // not due yet
  s.hold("land", 0.5, 0.1);
  EXPECT_EQ(text_of(s), "left 0.6:land both 0.9:lift right");
  s.confirm("land", 0.55);
  EXPECT_EQ(text_of(s), "left 0.55:land both 0.85:lift right");
  s = walk();
  s.confirm("lift", 0.4);  // without a landing: "both" is skipped
  EXPECT_EQ(text_of(s), "left 0.4:land both 0.4:lift right");
  EXPECT_EQ(s.mode_at(0.4), "right");
}

TEST(LiveSchedule, InvalidEditsChangeNothing) {
  Schedule s = roomy();
  s.insert("left", "back", 1.5);
  const std::string before = text_of(s);
  const auto refused = [&](auto&& edit, const std::string& fragment) {
    expect_in(fragment, message_of([&] { edit(); }));
    EXPECT_EQ(text_of(s), before);
  };
  refused([&] { s.insert("fligth", "x", 1.0); }, "no mode 'fligth'; did you mean 'flight'?");
  refused([&] { s.insert("flight", "lift", 1.0); }, "two events are called 'lift'");
  refused([&] { s.insert("flight", "x", std::nan("")); }, "event 'x' has time NaN");
  refused([&] { s.insert("flight", std::string(64, 'x'), 1.0); }, "has 64 characters");
  refused([&] { s.erase("lnad"); }, "did you mean 'land'");
  refused([&] { s.replace("land", "rigth"); }, "did you mean 'right'");
  refused([&] { s.replace("lnad", "right"); }, "did you mean 'land'");
  refused([&] { s.replace_first("none"); }, "no mode 'none'");
  refused([&] { s.retime_from("lift", 0.4); }, "event 'lift' at 0.4 s comes after event 'land'");
  refused([&] { s.retime_from("lift", std::nan("")); }, "NaN");
  refused([&] { s.confirm("lift", std::nan("")); }, "NaN");
  refused([&] { s.hold("lift", 0.9, -0.1); }, "'lift' cannot be held -0.1 s ahead");
  refused([&] { s.reserve(2); }, "room for 2 events, because it already has 3");
  refused([&] { s.adopt(Schedule({"left", "fly"}, {{"land", 0.1}})); }, "no mode 'fly'");
  Schedule full = s;
  full.insert("both", "rest", 2.0);
  expect_in("event 'x' with mode 'left' would be number 5, but the declared capacity is 4",
            message_of([&] { full.insert("left", "x", 2.0); }));
  refused([&] { s.reserve(3).adopt(full); }, "it has 4 events, but the declared capacity is 3");
  std::vector<std::string> many;
  for (int i = 0; i < 65; ++i) many.push_back(fmt::format("mode {}", i));
  refused([&] { s.declare(many); }, "69 different modes, but at most 64 are allowed");
  refused([] { Schedule().insert("a", "b", 0.0); }, "no mode 'a'");
}

TEST(LiveSchedule, AdoptsModesByName) {
  Schedule s = roomy();
  const Schedule other({"right", "left", "flight"}, {{"a", 0.1}, {"b", 0.2}});
  s.adopt(other);
  EXPECT_EQ(text_of(s), text_of(other));
  EXPECT_EQ(s.capacity(), 4);
  EXPECT_EQ(s.mask_of(std::vector<std::string>{"left", "right"}), 0b101u);
}

TEST(LiveSchedule, NoEditAllocates) {
  const std::string event = "the left foot touches the ground again";
  Schedule s = Schedule({"the left foot stands"}, {}).declare({"both feet stand"}).reserve(2);
  Schedule other = s;
  const testing::AllocationCount count;
  for (int i = 0; i < 10; ++i) {
    s.insert("both feet stand", event, 0.1 * i);
    s.insert("the left foot stands", "lift", 0.1 * i + 0.05);
    s.retime("lift", 0.1 * i + 0.06);
    s.replace(event, "the left foot stands");
    s.hold(event, 0.1 * i, 0.01);
    s.confirm(event, 0.1 * i);
    other.adopt(s);
    s.erase("lift");
    s.forget_until(0.1 * i);
    other = s;
  }
  EXPECT_EQ(count.made(), 0);
}

TEST(Schedule, RejectsInvalidSchedules) {
  expect_in("2 modes need 1 events", message_of([] { Schedule({"a", "b"}, {}); }));
  expect_in("called 'x'", message_of([] { Schedule({"a", "b", "c"}, {{"x", 1.0}, {"x", 2.0}}); }));
  expect_in("must not be smaller", message_of([] {
              Schedule({"a", "b", "c"}, {{"x", 2.0}, {"y", 1.0}});
            }));
}

TEST(Schedule, ReportsMissingModes) {
  expect_in("it has no mode;", message_of([] { Schedule().mode(0); }));
  expect_in("it has no mode;", message_of([] { Schedule().mode_at(1.0); }));
  expect_in("no event 'land'", message_of([] { Schedule().index_of("land"); }));
}

TEST(Reference, IsLinearBetweenSamplesAndConstantOutside) {
  const Reference r({1.0, 2.0, 4.0}, Mat<double, 1, 3>{3.0, 5.0, 1.0});
  EXPECT_DOUBLE_EQ(r.at(0.0, 0), 3.0);
  EXPECT_DOUBLE_EQ(r.at(1.5, 0), 4.0);
  EXPECT_DOUBLE_EQ(r.at(2.0, 0), 5.0);
  EXPECT_DOUBLE_EQ(r.at(3.0, 0), 3.0);
  EXPECT_DOUBLE_EQ(r.at(9.0, 0), 1.0);
  EXPECT_DOUBLE_EQ(r.rate(0.0, 0), 0.0);
  EXPECT_DOUBLE_EQ(r.rate(1.5, 0), 2.0);
  EXPECT_DOUBLE_EQ(r.rate(2.0, 0), -2.0);  // right-sided at a sample
  EXPECT_DOUBLE_EQ(r.rate(4.0, 0), 0.0);
}

TEST(Reference, RejectsInvalidSamples) {
  expect_in("2 times but 1 columns", message_of([] {
              Reference({0.0, 1.0}, MatrixXd::Zero(1, 1));
            }));
  expect_in("not after", message_of([] { Reference({1.0, 1.0}, MatrixXd::Zero(1, 2)); }));
  expect_in("not after", message_of([] { Reference({0.0, std::nan("")}, MatrixXd::Zero(1, 2)); }));
  expect_in("finite", message_of([] { Reference({-never, 0.0}, MatrixXd::Zero(1, 2)); }));
  expect_in("finite", message_of([] { Reference({0.0, never}, MatrixXd::Zero(1, 2)); }));
}

}  // namespace
}  // namespace saltus
