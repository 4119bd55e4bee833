// Injects each fault for twenty ticks in the middle of a run. Tests the source of the inputs during
// the fault and the number of ticks until the plan is optimal again. Both must agree with the table
// of docs/faults.md, whose ticks are upper bounds.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/app/support.hpp"
#include "tests/faults/loop.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus::test {
namespace {

constexpr int before = 60, during = 20, after = 100;  // ticks

struct Outcome {
  std::array<long, provenances> meanwhile{};
  int back = -1;  // ticks from the first one without the fault; -1: never
  bool is_sound = true;
  long allocations = 0;
};

Outcome outcome_of(Fault fault) {
  FaultyLoop loop;
  loop.aim(0.8);
  Outcome outcome;
  for (int k = 0; k < before + during + after; ++k) {
    if (k == before + during) loop.strike(0.05);
    const bool is_faulty = k >= before && k < before + during;
    const testing::AllocationCount count;
    const ControlTick& tick = loop.tick(is_faulty ? fault : Fault::none);
    if (k > 0) outcome.allocations += count.made();
    outcome.is_sound = outcome.is_sound && loop.input_is_sound();
    if (is_faulty) ++outcome.meanwhile[static_cast<std::size_t>(tick.provenance)];
    if (k >= before + during) {
      if (tick.provenance != Provenance::optimal)
        outcome.back = -1;
      else if (outcome.back < 0)
        outcome.back = k - before - during;
    }
  }
  return outcome;
}

// A row "| fault | whose inputs | ticks |" as in docs/faults.md.
struct Row {
  std::string whose;
  int back = -1;
};

Row row_of(Fault fault, const std::string& page) {
  const std::string first = fmt::format("\n| {} | ", describe(fault));
  const std::size_t begin = page.find(first);
  if (begin == std::string::npos) return {};
  const std::size_t whose = begin + first.size(), next = page.find(" | ", whose);
  return {page.substr(whose, next - whose), std::atoi(page.c_str() + next + 3)};
}

TEST(Faults, EveryFaultLeavesAnInputAndTerminates) {
  std::ifstream stream(SALTUS_DOCS "/faults.md");
  const std::string page{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  for (int f = 0; f < static_cast<int>(Fault::count); ++f) {
    const Fault fault = static_cast<Fault>(f);
    SCOPED_TRACE(describe(fault));
    const Outcome outcome = outcome_of(fault);
    EXPECT_TRUE(outcome.is_sound);
    EXPECT_GE(outcome.back, 0);
    const bool allocates = fault == Fault::dynamics_throw || fault == Fault::cost_throws ||
                           fault == Fault::sender_throws || fault == Fault::fallback_throws ||
                           fault == Fault::schedule_impossible;  // throwing an exception allocates
    if (!allocates) {
      EXPECT_EQ(outcome.allocations, 0);
    }
    const Row stated = row_of(fault, page);
    EXPECT_LE(outcome.back, stated.back);
    for (int p = 0; p < provenances; ++p)
      if (outcome.meanwhile[static_cast<std::size_t>(p)] > 0) {
        EXPECT_TRUE(contains(stated.whose, describe(static_cast<Provenance>(p))));
      }
  }
}

}  // namespace
}  // namespace saltus::test
