// The program as a user calls it, within a test.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "problems/push_recovery/push_recovery.hpp"
#include "saltus/app/program.hpp"

namespace saltus::push_recovery {

struct ProgramRun {
  int status = 0;
  std::string printed, complaint;  ///< standard output and error stream
};

/// Runs `saltus run push_recovery` with these arguments.
inline ProgramRun run_program(const std::vector<std::string>& words) {
  std::vector<const char*> arguments{"saltus", "run", "push_recovery"};
  for (const std::string& word : words) arguments.push_back(word.c_str());
  const std::vector<ProblemEntry> problems{entry()};
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  ProgramRun run;
  run.status = saltus_main(static_cast<int>(arguments.size()), arguments.data(), problems);
  run.printed = testing::internal::GetCapturedStdout();
  run.complaint = testing::internal::GetCapturedStderr();
  return run;
}

}  // namespace saltus::push_recovery
