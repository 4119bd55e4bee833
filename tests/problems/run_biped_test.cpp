// Exit status of a run, and the files in its folder.
#include "problems/biped/report/run_biped.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/app/support.hpp"
#include "tests/robots/fixed_steps.hpp"

namespace saltus::robots::walking {
namespace {

struct Ended {
  ExitStatus status = ExitStatus::ok;
  std::string printed;
  nlohmann::json summary;
};

Ended run(const BipedProblem& problem) {
  const TemporaryFolder folder;
  OutputFolder output(folder.path());
  const std::string config = "stance: both\n";
  testing::internal::CaptureStdout();
  Ended ended;
  ended.status = run_biped(problem, config, RunContext{RunRequest{}, output, config});
  ended.printed = testing::internal::GetCapturedStdout();
  ended.summary = nlohmann::json::parse(file_content(folder / "summary.json"));
  return ended;
}

TEST(RunBiped, StandingIsASuccess) {
  const Ended ended = run(FixedSteps({}, 0.03));
  EXPECT_EQ(ended.status, ExitStatus::ok) << ended.printed;
  EXPECT_EQ(ended.summary["failures"], 0);
}

// The force is finite, but the motion it causes is not: the plant fails, not the solver.
TEST(RunBiped, IntegrationFailureIsAFailure) {
  FixedSteps problem({}, 0.03);
  Push push;
  push.start = 0.01;
  push.impulse = 1e307;
  problem.all = {push};
  const Ended ended = run(problem);
  EXPECT_EQ(ended.status, ExitStatus::solver_failed) << ended.printed;
  EXPECT_EQ(ended.summary["failures"], 0);
  EXPECT_TRUE(contains(ended.printed, "the plant could not be integrated at 0.010 s"));
}

}  // namespace
}  // namespace saltus::robots::walking
