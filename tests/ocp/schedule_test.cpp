// Modes, events and references in absolute time.
#include "framework/ocp/schedule.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "framework/core/error.hpp"
#include "framework/ocp/reference.hpp"

namespace saltus {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

Schedule walk() { return Schedule({"left", "both", "right"}, {{"land", 0.5}, {"lift", 0.8}}); }

template <class Action>
std::string message_of(Action&& action) {
  try {
    action();
  } catch (const DefinitionError& e) {
    return e.what();
  }
  return "nothing was thrown";
}

void expect_in(const std::string& fragment, const std::string& text) {
  EXPECT_NE(text.find(fragment), std::string::npos) << "'" << fragment << "' is not in: " << text;
}

TEST(Schedule, AtAnEventTheNewModeIsInForce) {
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

TEST(Schedule, InfiniteEventsNeverCome) {
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
}

TEST(Schedule, RefusesWhatIsNoSchedule) {
  expect_in("2 modes need 1 events", message_of([] { Schedule({"a", "b"}, {}); }));
  expect_in("called 'x'", message_of([] { Schedule({"a", "b", "c"}, {{"x", 1.0}, {"x", 2.0}}); }));
  expect_in("must not be smaller", message_of([] {
              Schedule({"a", "b", "c"}, {{"x", 2.0}, {"y", 1.0}});
            }));
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

TEST(Reference, RefusesSamplesThatAreNone) {
  expect_in("2 times but 1 columns", message_of([] {
              Reference({0.0, 1.0}, MatrixXd::Zero(1, 1));
            }));
  expect_in("not after", message_of([] { Reference({1.0, 1.0}, MatrixXd::Zero(1, 2)); }));
  expect_in("not after", message_of([] { Reference({0.0, std::nan("")}, MatrixXd::Zero(1, 2)); }));
}

}  // namespace
}  // namespace saltus
