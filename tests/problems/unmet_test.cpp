// Unmet constraints of the push recovery planners: the run records and reports them correctly.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "problems/biped/report/unmet.hpp"
#include "problems/push_recovery/unmet_explanations.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/walking/unmet_decision.hpp"
#include "tests/problems/push_recovery_run.hpp"

namespace saltus::push_recovery {
namespace {

Config pushed_by(double impulse, const Vec<double, 3>& direction) {
  Config config;
  config.push.impulse = impulse;
  config.push.direction = direction;
  config.push.start = 0.1;
  config.pictures = false;
  return config;
}

robots::walking::UnmetReport report_of(const Config& config, const RunLog& log) {
  const PushRecoveryExplanations words(limits_on_the_way(config, log.robot));
  return walking::explain_unmet(words, log.unmet_decisions, 60.0);
}

TEST(Unmet, ExplainsALateStepOfFixedTime) {
  const Config config = pushed_by(13.0, {0.0, -1.0, 0.0});
  const RunLog log = simulate(config, icub());
  ASSERT_FALSE(log.unmet_decisions.empty());
  const robots::walking::UnmetDecision& first = log.unmet_decisions.front();
  EXPECT_EQ(first.decision, "wrenches");
  EXPECT_GT(first.missed, 1e-3);
  // The landing, 0.6 s after the push, enters the horizon of 0.15 s.
  EXPECT_GT(first.time, 0.1 + 0.6 - 0.15 - 1e-9);
  EXPECT_LT(first.time, 0.7);
  const robots::walking::UnmetReport report = report_of(config, log);
  EXPECT_NE(report.text.find("the capture point is not in the hull of the feet at t = 0.700 s"),
            std::string::npos)
      << report.text;
  EXPECT_NE(report.text.find("outside towards -y"), std::string::npos) << report.text;
  EXPECT_NE(report.text.find("if the foot landed"), std::string::npos) << report.text;
  EXPECT_NE(report.text.find("ms earlier"), std::string::npos) << report.text;
  EXPECT_EQ(report.json.size(), log.unmet_decisions.size());

  // With the proposed change, the robot recovers in the run.
  double earlier = 0.0;
  for (const auto& remedy : report.json[0]["explanation"]["remedies"])
    if (remedy["changes"][0]["kind"] == "event") earlier = remedy["changes"][0]["by"].get<double>();
  ASSERT_LT(earlier, 0.0) << report.text;
  Config better = config;
  better.step.duration += 1.2 * earlier;  // 1.2: part of the motion was fixed at that tick
  const RunLog caught = simulate(better, icub());
  const Verdict verdict = judge(better, caught);
  EXPECT_FALSE(judge(config, log).recovered);
  EXPECT_TRUE(verdict.recovered) << better.step.duration << " s: " << verdict.reason;
}

TEST(Unmet, StepPlannerExplainsAnImpossibleStance) {
  Config config = pushed_by(9.0, {0.0, 1.0, 0.0});  // towards the stance side, where no step helps
  config.step.planner = robots::walking::Step::Planner::ocp;
  const RunLog log = simulate(config, icub());
  ASSERT_FALSE(log.unmet_decisions.empty());
  const robots::walking::UnmetDecision& first = log.unmet_decisions.front();
  EXPECT_EQ(first.decision, "steps");
  const robots::walking::UnmetReport report = report_of(config, log);
  EXPECT_NE(report.text.find("the robot is not captured"), std::string::npos) << report.text;
  EXPECT_NE(report.text.find("to the stance side"), std::string::npos) << report.text;
  // The report does not propose changes of measured data.
  EXPECT_EQ(report.text.find("'now."), std::string::npos) << report.text;
  // Times are relative to the start of the run.
  EXPECT_GT(report.json[0]["explanation"]["gives_way"][0]["t_s"].get<double>(), first.time);
}

TEST(Unmet, RecoveredRunHasNoExplanation) {
  const Config config = pushed_by(6.0, {0.0, -1.0, 0.0});
  const RunLog log = simulate(config, icub());
  EXPECT_TRUE(log.unmet_decisions.empty());
}

TEST(Unmet, KeepsTheFirstAndTheWorstOfAKind) {
  Phase<1, 1> phase{"p", [](const auto&, const auto&, const auto& u) { return u; }, exactly(1.0)};
  OptimalControlProblem problem("kept");
  problem.start_at({0.0}).then(phase);
  const MultipleShooting shooting(problem,
                                  {.intervals_per_phase = 2, .integrator = runge_kutta4()});
  robots::walking::UnmetDecisions kept;
  const double missed[] = {2.0, 1.0, 5.0, 3.0, 4.0};
  for (int k = 0; k < 5; ++k) kept.keep("wrenches", k, missed[k], shooting);
  kept.keep("steps", 2.5, 0.1, shooting);
  const std::vector<robots::walking::UnmetDecision> all = kept.take();
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].time, 0.0);
  EXPECT_EQ(all[1].time, 2.0);
  EXPECT_EQ(all[1].missed, 5.0);
  EXPECT_EQ(all[2].decision, "steps");
  EXPECT_EQ(all[2].problem.start_time(), 2.5);
}

}  // namespace
}  // namespace saltus::push_recovery
