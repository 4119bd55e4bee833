// Tests that results from other processes arrive and that a crash stays in its process.
#include "saltus/app/process_pool.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <map>
#include <stdexcept>

#include "saltus/core/error.hpp"
#include "tests/app/support.hpp"

namespace saltus {
namespace {

using End = WorkResult::End;

constexpr double ample = 30.0;  // s, timeout for work that takes milliseconds

std::map<long, WorkResult> finish_all(ProcessPool& pool) {
  std::map<long, WorkResult> all;
  while (!pool.is_idle())
    for (WorkResult& work : pool.wait(1.0)) all[work.id] = std::move(work);
  return all;
}

WorkResult result_of(const std::function<std::string()>& work, double time_limit = ample) {
  ProcessPool pool(1, time_limit);
  pool.start(7, work);
  return finish_all(pool).at(7);
}

TEST(ProcessPool, ReturnsCompleteTexts) {
  const std::string large(1'000'000, 'x');  // exceeds the capacity of a pipe
  ProcessPool pool(3, ample);
  pool.start(1, [] { return std::string("one, with a\nline"); });
  pool.start(2, [&] { return large; });
  pool.start(3, [] { return std::string(); });
  EXPECT_TRUE(pool.is_full());
  EXPECT_THROW(pool.start(4, [] { return std::string(); }), DefinitionError);
  const auto all = finish_all(pool);
  ASSERT_EQ(all.size(), 3u);
  for (const auto& [id, work] : all) EXPECT_EQ(work.end, End::done) << work.text;
  EXPECT_EQ(all.at(1).text, "one, with a\nline");
  EXPECT_EQ(all.at(2).text, large);
  EXPECT_EQ(all.at(3).text, "");
}

TEST(ProcessPool, PrintedTextIsNotTheResult) {
  const WorkResult work = result_of([] {
    std::printf("a library warns\n");
    std::fprintf(stderr, "and warns again\n");
    return std::string("result");
  });
  EXPECT_EQ(work.end, End::done);
  EXPECT_EQ(work.text, "result");
}

TEST(ProcessPool, ExceptionsKeepTheirMessage) {
  const WorkResult refused = result_of([]() -> std::string { throw InputError("no such link"); });
  EXPECT_EQ(refused.end, End::refused);
  EXPECT_EQ(refused.text, "no such link");
  const WorkResult threw =
      result_of([]() -> std::string { throw std::runtime_error("out of luck"); });
  EXPECT_EQ(threw.end, End::died);
  EXPECT_EQ(threw.text, "it threw: out of luck");
}

TEST(ProcessPool, CrashGivesOneResult) {
  ProcessPool pool(2, ample);
  pool.start(1, []() -> std::string {
    std::fprintf(stderr, "assertion 'x > 0' failed\n");
    std::raise(SIGKILL);
    return "not reached";
  });
  pool.start(2, [] { return std::string("fine"); });
  const auto all = finish_all(pool);
  EXPECT_EQ(all.at(1).end, End::died);
  EXPECT_TRUE(contains(all.at(1).text, "it crashed"));
  EXPECT_TRUE(contains(all.at(1).text, "assertion 'x > 0' failed"));
  EXPECT_EQ(all.at(2).text, "fine");
  const WorkResult left = result_of([]() -> std::string { ::_exit(4); });
  EXPECT_EQ(left.text, "it exited with 4");
}

TEST(ProcessPool, EndlessWorkIsStopped) {
  const WorkResult work = result_of(
      []() -> std::string {
        for (;;) ::pause();
      },
      0.05);
  EXPECT_EQ(work.end, End::died);
  EXPECT_EQ(work.text, "it took longer than 0.05 s");
}

TEST(ProcessPool, StopEndsAllProcesses) {
  ProcessPool pool(2, ample);
  for (const long id : {1, 2})
    pool.start(id, []() -> std::string {
      for (;;) ::pause();
    });
  pool.stop();
  EXPECT_TRUE(pool.is_idle());
  EXPECT_TRUE(pool.wait(0.0).empty());
}

TEST(ProcessPool, RejectsInvalidOptions) {
  EXPECT_THROW(ProcessPool(0, 1.0), DefinitionError);
  EXPECT_THROW(ProcessPool(1, 0.0), DefinitionError);
}

}  // namespace
}  // namespace saltus
