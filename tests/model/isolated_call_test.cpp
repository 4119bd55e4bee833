// Tests that a crash in an isolated call does not affect the calling process.
#include "saltus/core/isolated_call.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <stdexcept>
#include <string>

namespace saltus {
namespace {

TEST(IsolatedCall, ReturnsTheResult) {
  int calls = 0;
  const std::string large(10'000'000, 'x');  // exceeds the capacity of a pipe
  for (const std::string& text : {std::string(), std::string("a\0b\x03", 4), large}) {
    const auto answer = isolated_call(
        [&] {
          ++calls;  // in the copy only
          return text;
        },
        10);
    ASSERT_TRUE(answer);
    EXPECT_EQ(*answer, text);
  }
  EXPECT_EQ(calls, 0);
}

TEST(IsolatedCall, ReportsACrash) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGKILL})
    EXPECT_FALSE(isolated_call(
        [&]() -> std::string {
          std::raise(signal);
          return "on";
        },
        10))
        << signal;
  EXPECT_FALSE(isolated_call([]() -> std::string { throw std::runtime_error("no"); }, 10));
  EXPECT_FALSE(isolated_call(
      []() -> std::string {
        for (volatile bool on = true; on;) {
        }
        return "on";
      },
      1));
}

}  // namespace
}  // namespace saltus
