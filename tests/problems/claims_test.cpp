// Claims of problems/push_recovery/experiments.md on the whole body, run by run. Each line contains
// the arguments after `saltus run push_recovery --set`. Needs the URDF, whose file
// SALTUS_ICUB_URDF names.
#include <gtest/gtest.h>

#include <algorithm>

#include "saltus/robots/mujoco/mujoco_plant.hpp"
#include "tests/problems/icub_in_dart.hpp"

namespace saltus::push_recovery {
namespace {

struct Claim {
  const char* name;
  std::vector<std::string> settings;
};

struct Outcome {
  RunLog log;
  Verdict verdict;
};

class OnTheBody : public IcubInDart {
 protected:
  // The claims hold under the conditions of the paper.
  Outcome outcome(std::vector<std::string> words) {
    words.insert(words.begin(), "preset=paper");
    apply(words);
    Outcome o{run(), {}};
    o.verdict = judge(config, o.log);
    return o;
  }
};

class Claims : public OnTheBody, public testing::WithParamInterface<Claim> {};

class Recovered : public Claims {};
TEST_P(Recovered, BodyStaysWithinItsLimits) {
  const std::vector<std::string>& settings = GetParam().settings;
  if (std::count(settings.begin(), settings.end(), "plant=mujoco") > 0 && !robots::has_mujoco())
    GTEST_SKIP() << "built without MuJoCo";
  const auto [log, verdict] = outcome(settings);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  EXPECT_EQ(log.control_failures, 0);
  ASSERT_TRUE(verdict.body.has_value());
  for (std::size_t i = 0; i < log.body.size(); ++i)
    for (int j = 0; j < log.floating.joints(); ++j)
      ASSERT_LE(std::abs(log.body[i].torques[j]), log.floating.bodies[j + 1].effort + 1e-9)
          << log.floating.bodies[j + 1].joint << " at " << log.samples[i].time << " s";
}

const Claim recovered[] = {
    {"4Ns", {"push.impulse=4"}},
    {"5Ns", {"push.impulse=5"}},
    {"5p5Ns", {"push.impulse=5.5"}},
    {"6Ns", {"push.impulse=6"}},
    {"6p5Ns", {"push.impulse=6.5"}},
    {"7Ns", {"push.impulse=7"}},
    {"10NsStep0p3", {"push.impulse=10", "step.duration=0.3"}},
    {"FixedFoot6Ns", {"push.impulse=6", "step.placement=fixed"}},
    {"FixedFoot11NsStep0p3", {"push.impulse=11", "step.placement=fixed", "step.duration=0.3"}},
    {"DartsOwnCollision", {"push.impulse=6", "dart.collision=dart"}},
    {"FclCollision", {"push.impulse=6", "dart.collision=fcl"}},
    {"OdeCollision", {"push.impulse=6", "dart.collision=ode"}},
    {"PgsContactSolver", {"push.impulse=6", "dart.lcp=pgs"}},
    {"RightStance", {"push.impulse=6", "stance=right", "push.direction=[0, 1, 0]"}},
    {"Forward13Ns", {"push.impulse=13", "push.direction=[1, 0, 0]"}},
    {"MujocoFixedFoot6Ns", {"push.impulse=6", "step.placement=fixed", "plant=mujoco"}},
};
INSTANTIATE_TEST_SUITE_P(Pushes, Recovered, testing::ValuesIn(recovered),
                         [](const auto& p) { return std::string(p.param.name); });

class Standing : public Claims {};
TEST_P(Standing, FeetStayAndTheBaseStaysUpright) {
  const auto [log, verdict] = outcome(GetParam().settings);
  EXPECT_TRUE(verdict.recovered) << verdict.reason;
  ASSERT_TRUE(verdict.body.has_value());
  EXPECT_TRUE(verdict.body->standing);
}
const Claim standing[] = {
    {"4p0Ns", {"stepping=false", "push.impulse=4.0"}},
    {"4p2Ns", {"stepping=false", "push.impulse=4.2"}},
    {"4p4Ns", {"stepping=false", "push.impulse=4.4"}},
    {"4p6Ns", {"stepping=false", "push.impulse=4.6"}},
};
INSTANTIATE_TEST_SUITE_P(Pushes, Standing, testing::ValuesIn(standing),
                         [](const auto& p) { return std::string(p.param.name); });

using Landing = OnTheBody;
TEST_F(Landing, CapturePointSettlesFasterWithPrediction) {
  const Outcome mpc = outcome({"push.impulse=6"});
  const Outcome baseline = outcome({"controller=capture_point"});
  EXPECT_TRUE(baseline.verdict.recovered) << baseline.verdict.reason;
  EXPECT_LT(mpc.verdict.icp_settling, 0.3);  // s, to within 1 cm
  EXPECT_LT(mpc.verdict.icp_settling, baseline.verdict.icp_settling);
  const robots::SupportPolygon hull = mpc.log.final_scene.hull();
  for (const BipedSample& s : mpc.log.samples) {
    if (s.time <= mpc.log.touchdown + mpc.verdict.icp_settling) continue;
    ASSERT_TRUE(hull.contains(s.capture_point)) << s.time;
  }
  EXPECT_FALSE(mpc.verdict.body->touches_joint_limit())
      << mpc.verdict.body->limit_joint << " at " << mpc.verdict.body->limit_time << " s";
  EXPECT_LT(mpc.verdict.body->slip.maxCoeff(), 0.01);  // m
}

}  // namespace
}  // namespace saltus::push_recovery
