// Tests that a joint schedule reproduces each of its member schedules.
#include "saltus/ocp/schedule.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

// Alternates between stance and swing. `name` lifts at the even events.
Schedule leg(const std::string& name, const std::vector<double>& times) {
  std::vector<std::string> modes{name};
  std::vector<Event> events;
  for (std::size_t i = 0; i < times.size(); ++i) {
    modes.push_back(i % 2 == 0 ? "-" : name);
    events.push_back({fmt::format("{} {}", name, i), times[i]});
  }
  return Schedule(modes, events).declare({"-"});
}

TEST(JointSchedule, ModeCombinesAllParts) {
  constexpr std::uint64_t seed = 5;
  Random random(seed);
  for (int round = 0; round < 50; ++round) {
    std::vector<Schedule> parts;
    for (const char* name : {"FL", "FR", "RL"}) {
      std::vector<double> times(random.integer(0, 6));
      for (double& t : times) t = 0.1 * random.integer(0, 12);  // many at the same instant
      std::sort(times.begin(), times.end());
      parts.push_back(leg(name, times));
    }
    JointSchedule joint(parts, 18);
    const double from = random.uniform(-0.2, 0.6), to = from + random.uniform(0.0, 1.0);
    const Schedule& all = joint.join(from, to);
    for (double t = from; t <= to; t += 0.0313)
      EXPECT_EQ(all.mode_at(t), fmt::format("{} {} {}", parts[0].mode_at(t), parts[1].mode_at(t),
                                            parts[2].mode_at(t)))
          << "seed " << seed << ", round " << round << ", t = " << t;
    for (const Event& event : all.events()) {
      EXPECT_GT(event.time, from);
      EXPECT_LE(event.time, to);
    }
  }
}

TEST(JointSchedule, SimultaneousEventsAreMerged) {
  JointSchedule joint({leg("left", {0.3, 0.5}), leg("right", {0.3 + 1e-9, 0.7})}, 4);
  const Schedule& all = joint.join(0.0, never);
  ASSERT_EQ(all.events().size(), 3u);
  EXPECT_EQ(all.mode(0), "left right");
  EXPECT_EQ(all.mode(1), "- -");
  EXPECT_EQ(all.mode(2), "left -");
  EXPECT_EQ(all.events()[0].name.view(), "left 0");
}

TEST(JointSchedule, DuringCoversAllModesOfOtherParts) {
  const JointSchedule joint({leg("left", {0.3}), leg("right", {})}, 4);
  EXPECT_EQ(joint.during(0, "-").modes, (std::vector<std::string>{"- right", "- -"}));
  EXPECT_EQ(joint.during(1, "right").modes, (std::vector<std::string>{"left right", "- right"}));
  EXPECT_THROW(joint.during(1, "left"), DefinitionError);
}

TEST(JointSchedule, AppliesEditsOfAPartWithoutAllocation) {
  JointSchedule joint({leg("left", {0.3, 0.5, 0.9}), leg("right", {0.4, 0.8})}, 8);
  const testing::AllocationCount count;
  joint.part(0).retime("left 1", 0.45);
  joint.part(1).hold("right 1", 0.8, 0.1);
  joint.join(0.35, 1.0);
  EXPECT_EQ(count.made(), 0);
  EXPECT_EQ(joint.joined().mode_at(0.46), "left -");
  EXPECT_EQ(joint.joined().mode_at(0.85), "left -");
  EXPECT_EQ(joint.joined().mode_at(0.95), "- right");
}

TEST(JointSchedule, RejectsMismatchedSchedules) {
  EXPECT_THROW(JointSchedule({}, 4), DefinitionError);
  const std::vector<Schedule> seven(7, leg("leg", {}));  // 128 joint modes
  EXPECT_THROW(JointSchedule(seven, 4), DefinitionError);
  JointSchedule small({leg("left", {0.3, 0.5}), leg("right", {0.4})}, 2);
  for (const int part : {-1, 2, 1000000}) {
    EXPECT_THROW(small.part(part), DefinitionError);
    EXPECT_THROW(std::as_const(small).part(part), DefinitionError);
    EXPECT_THROW(small.during(part, "left"), DefinitionError);
  }
  EXPECT_THROW(small.join(0.0, 1.0), DefinitionError);
  small.join(0.35, 0.45);
  EXPECT_EQ(small.joined().mode_at(0.4), "- -");
}

}  // namespace
}  // namespace saltus
