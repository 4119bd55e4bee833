// The controllers have no advance knowledge of a push, and the run reports pushes that no step can
// catch.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "saltus/app/settings.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/simulation/simulate.hpp"
#include "tests/app/support.hpp"
#include "tests/problems/push_recovery_program.hpp"
#include "tests/problems/push_recovery_run.hpp"
#include "tests/support/errors.hpp"

namespace saltus::push_recovery {
namespace {

constexpr const char* words_of[] = {"icp_formula", "reactive", "ocp"};

// One push acts on the robot; the settings of the controllers contain another one.
class Pushed final : public BipedProblem {
 public:
  Pushed(const Config& told, const Push& acting) : problem_(told), acting_(acting) {}
  std::vector<Push> pushes() const override { return {acting_}; }

  const BipedSettings& settings() const override { return problem_.settings(); }
  BipedSettings& settings() override { return problem_.settings(); }
  std::unique_ptr<Planner> make_planner(const robots::RobotDescription& nominal,
                                        const Scene& scene) const override {
    return problem_.make_planner(nominal, scene);
  }
  std::unique_ptr<StepPlanner> make_step_planner(const robots::RobotDescription& nominal,
                                                 const Scene& scene) const override {
    return problem_.make_step_planner(nominal, scene);
  }
  double end_time(double push_end, double landing, double touchdown) const override {
    return problem_.end_time(push_end, landing, touchdown);
  }
  Verdict judge(const RunLog& log) const override { return problem_.judge(log); }

 private:
  PushRecovery problem_;
  Push acting_;
};

Push push_at(double start, double impulse, const Vec<double, 3>& direction, double duration) {
  Push push;
  push.start = start;
  push.impulse = impulse;
  push.direction = direction;
  push.duration = duration;
  return push;
}

// Samples until 0.5 s after the push, when the robot steps.
std::vector<BipedSample> samples(Config config, const Push& told, const Push& acting) {
  config.push = told;
  return walking::simulate(Pushed(config, acting), icub(),
                           [&](const LoopState& state) { return state.time < acting.start + 0.5; })
      .samples;
}

bool are_equal(const std::vector<BipedSample>& a, const std::vector<BipedSample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const BipedSample& x, const BipedSample& y) {
                      return x.time == y.time && x.gamma == y.gamma && x.wrenches == y.wrenches;
                    });
}

TEST(StepKnown, FalseHidesThePush) {
  const Push acting = push_at(0.1, 7.0, {0.0, -1.0, 0.0}, 0.1);
  const Push other = push_at(0.05, 3.0, {1.0, 0.0, 0.0}, 0.15);
  for (const char* planner : words_of) {
    const Config config = config_of({std::string("step.planner=") + planner});
    EXPECT_FALSE(config.step.known);
    const std::vector<BipedSample> truth = samples(config, acting, acting);
    EXPECT_GT(truth.size(), 60u);
    EXPECT_TRUE(are_equal(truth, samples(config, other, acting))) << planner;
  }
  const Config paper = config_of({"preset=paper"});
  EXPECT_TRUE(paper.step.known);
  EXPECT_FALSE(are_equal(samples(paper, acting, acting), samples(paper, other, acting)));
}

// The known push is the first one in time, even if others precede it in the list.
TEST(StepKnown, PassesOnTheFirstPush) {
  const Config config = config_of({"preset=paper", "pushes=1.0 7 -90"});
  ASSERT_GT(config.push.start, 2.0);
  Scene scene;
  scene.stance_foot = {between(-0.05, 0.1), between(-0.03, 0.04)};
  scene.swing_foot = scene.stance_foot.mirrored();
  const auto planner = PushRecovery(config).make_step_planner(icub(), scene);
  StepSituation now;
  now.time = 1.2;
  now.mass = 33.0;
  now.omega = 4.2;
  now.gamma << 0.02, 0.0, 0.53, 0.0, -0.05 * now.omega, Vec<double, 4>::Zero();
  now.right.stands = false;
  const StepPlan& plan = planner->plan(now);
  ASSERT_EQ(plan.count, 1);
  EXPECT_DOUBLE_EQ(plan.steps[0].landing, 1.0 + config.step.duration);
}

TEST(StepKnown, IsTrueForThePaperPresetOnly) {
  EXPECT_TRUE(config_of({}).step.known);  // centroidal model: conditions of the paper
  EXPECT_TRUE(config_of({"plant=dart", "preset=paper"}).step.known);
  EXPECT_FALSE(config_of({"plant=dart"}).step.known);
  EXPECT_FALSE(config_of({"plant=mujoco"}).step.known);
  EXPECT_FALSE(config_of({"stance=both"}).step.known);
  EXPECT_FALSE(config_of({"step.planner=ocp"}).step.known);
  EXPECT_FALSE(config_of({"step.planner=icp_formula"}).step.known);
  EXPECT_TRUE(config_of({"plant=dart", "step.planner=push_formula"}).step.known);
}

// Until version 0.4, the keys of version 0.2 keep their meaning.
TEST(StepKnown, OldKeysKeepTheirMeaning) {
  using Given = std::vector<std::string>;
  struct Case {
    Given given;
    Step::Planner planner;
    bool known;
  };
  const Case cases[] = {
      {{"step.trigger=icp"}, Step::Planner::formula, false},
      {{"step.known=false"}, Step::Planner::formula, false},
      {{"step.planner=formula"}, Step::Planner::formula, true},
      {{"plant=dart", "step.planner=formula"}, Step::Planner::formula, false},
      {{"plant=dart", "preset=paper", "step.planner=formula"}, Step::Planner::formula, true},
      {{"plant=dart", "step.trigger=push"}, Step::Planner::formula, true},
      {{"plant=dart", "step.known=true"}, Step::Planner::formula, true},
      {{"plant=dart", "step.known=false"}, Step::Planner::ocp, false},
      {{"stance=both", "step.known=false"}, Step::Planner::reactive, false},
      {{"step.known=false", "step.planner=ocp"}, Step::Planner::ocp, false},
      {{"step.known=false", "step.trigger=icp", "step.planner=formula"},
       Step::Planner::formula,
       false}};
  for (const Case& c : cases) {
    const Config config = config_of(c.given);
    EXPECT_EQ(config.step.planner, c.planner) << c.given.front();
    EXPECT_EQ(config.step.known, c.known) << c.given.front();
    EXPECT_EQ(config.step.trigger, c.known ? Step::Trigger::push : Step::Trigger::icp);
  }
}

// Version 0.2 named these keys without their units.
TEST(OldKeys, KeysWithoutTheirUnitsAreReadWithAWarning) {
  Config config;
  Settings settings;
  declare_settings(settings, config);
  int renamed = 0;
  for (const std::string& key : settings.keys())
    for (const std::string unit : {"_s", "_m", "_hz", "_nms_per_rad"}) {
      if (!key.ends_with(unit) || key.starts_with("swing.") ||  // new after 0.3
          key == "walk.clearance_m" || key == "walk.swing_s" ||
          (key.starts_with("simulator.ground_") && key != "simulator.ground_step_m" &&
           key != "simulator.ground_edge_m"))
        continue;
      ++renamed;
      const std::string old_key = key.substr(0, key.size() - unit.size());
      const std::string value = key == "step.decision_lead_s" ? "0.1" : "0.08";
      try {
        settings.apply({parse_set_argument(old_key + "=" + value)});
      } catch (const InputError& error) {  // a rule refused the value, not the key
        EXPECT_FALSE(contains(error.what(), "unknown")) << error.what();
      }
      ASSERT_EQ(settings.warnings().size(), 1u) << key;
      EXPECT_TRUE(contains(settings.warnings()[0], "is now called '" + key + "'"));
    }
  EXPECT_EQ(renamed, 25);
  Config other;
  Settings again;
  declare_settings(again, other);
  again.apply({parse_set_argument("step.longest=0.8"), parse_set_argument("mpc.step=0.02")});
  EXPECT_EQ(other.planning.longest, 0.8);
  EXPECT_EQ(other.planner.step, 0.02);
}

TEST(StepKnown, ContradictionsGiveOneSentence) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"step.known=true", "step.planner=ocp"}, "is given; remove one of them"},
      {{"step.known=true", "step.trigger=icp"}, "use step.planner=push_formula or"},
      {{"step.known=false", "step.trigger=push"}, "use step.planner=push_formula or"}};
  for (const auto& c : cases) expect_error<InputError>([&] { config_of(c.first); }, {c.second});
}

TEST(StepKnown, PushTriggerNeedsThePushTime) {
  Config config;
  config.step.known = false;
  const robots::RobotDescription robot = icub();
  const PushRecovery problem(config);
  EXPECT_THROW(problem.make_step_planner(robot, initial_scene(problem, robot)), DefinitionError);
}

// --- printed output ------------------------------------------------------------------------------

class StepProgramRun : public testing::Test {
 protected:
  ProgramRun run(std::vector<std::string> words) {
    words.insert(words.end(), {"--pictures", "false", "--out", (folder / "out").string()});
    return run_program(words);
  }
  TemporaryFolder folder;
};

// A push to the stance side, too large without a step. The feet cannot cross.
TEST_F(StepProgramRun, ReportsInfeasibleLimitsAndContinues) {
  const ProgramRun hard =
      run({"--step.planner", "ocp", "--step.reach", "settings", "--push.impulse", "10",
           "--push.direction", "[0,1,0]", "--push.start", "0.1"});
  EXPECT_EQ(hard.status, 0) << hard.complaint;
  EXPECT_TRUE(contains(hard.printed, "no plan met all limits in "));
  EXPECT_TRUE(contains(hard.printed, "the best of them was used"));
  const auto plans = nlohmann::json::parse(file_content(folder / "out/summary.json"))["step_plans"];
  const double first = plans["first_without_s"].get<double>();
  EXPECT_GE(first, 0.1);
  EXPECT_GE(plans["ticks_without_feasible_alternative"].get<int>(), 2);
  // From then on, every tick has a chosen plan.
  std::istringstream table(file_content(folder / "out/plans.csv"));
  std::string line;
  std::getline(table, line);
  const auto fields = [](const std::string& text) {
    std::vector<std::string> list;
    std::istringstream stream(text);
    for (std::string field; std::getline(stream, field, ',');) list.push_back(field);
    return list;
  };
  const std::vector<std::string> columns = fields(line);
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(columns.begin(), columns.end(), name) -
                                    columns.begin());
  };
  int infeasible = 0, later = 0;
  while (std::getline(table, line)) {
    const std::vector<std::string> row = fields(line);
    infeasible += row[column("feasible")] == "0";
    later += std::stod(row[column("t [s]")]) > first;
    EXPECT_FALSE(row[column("chosen")].empty()) << line;
  }
  EXPECT_EQ(infeasible, plans["ticks_without_feasible_alternative"].get<int>());
  EXPECT_GT(later, 5);  // the run went on

  const ProgramRun easy = run({"--step.planner", "ocp", "--step.reach", "settings",
                               "--push.impulse", "2", "--push.start", "0.1"});
  EXPECT_EQ(easy.status, 0) << easy.complaint;
  EXPECT_TRUE(contains(easy.printed, "recovered\n"));
  EXPECT_FALSE(contains(easy.printed, "met all limits"));
}

TEST_F(StepProgramRun, NamesSettingsWithoutEffect) {
  const std::vector<std::string> short_run{"--push.impulse", "2", "--push.start", "0.1"};
  EXPECT_EQ(run(short_run).complaint, "");
  std::vector<std::string> words = short_run;
  words.insert(words.end(),
               {"--motor.bandwidth_hz", "20", "--simulator.joint_friction_nms_per_rad", "0.1"});
  const ProgramRun asked = run(words);
  EXPECT_EQ(asked.status, 0);
  EXPECT_TRUE(
      contains(asked.complaint,
               "have no effect on the centroidal model: simulator.joint_friction_nms_per_rad, "
               "motor.bandwidth_hz (use --plant dart)"))
      << asked.complaint;
}

TEST_F(StepProgramRun, RejectsImpossibleSettingsAndWritesNothing) {
  using Words = std::vector<std::string>;
  const std::vector<std::pair<Words, std::string>> cases{
      // an empty reach
      {{"--step.planner", "ocp", "--step.reach", "settings", "--step.forward_max", "0"},
       "leave no place for a foot; widen them"},
      {{"--step.lateral_min", "0.3", "--step.lateral_max", "0.2"},
       "step.lateral_min (0.3) exceeds step.lateral_max (0.2)"},
      // durations
      {{"--step.shortest_s", "1"}, "step.shortest_s (1) must be below step.longest_s (0.9)"},
      {{"--step.planner", "ocp", "--step.usual_s", "0.2"}, "must lie between step.shortest_s"},
      {{"--stance", "both", "--step.duration", "0.2"}, "change one of them"},
      {{"--step.planner", "ocp", "--walk.double_support_s", "0.05"}, "increase it"},
      // pushes
      {{"--pushes", "2.45 3 90"}, "move it, or shorten one of them"},
      {{"--pushes", "3 3 90 0.5; 3.2 4 0"}, "move it, or shorten one of them"},
      {{"--pushes", "601 3 90"}, "must have its time within 0 to 600 s"},
      {{"--push.random.rate_hz", "1"},
       "change push.random.rate_hz, push.random.until_s or push.random.apart_s"},
      {{"--push.random.rate_hz", "0.1", "--push.start", "70"},
       "change push.random.rate_hz, push.random.until_s or push.random.apart_s"},
      // velocities
      {{"--step.planner", "ocp", "--walk.velocity", "[1,0,0]"}, "reduce walk.velocity"},
      {{"--step.planner", "ocp", "--walk.velocity", "[0.7,0,0]", "--step.foot_speed", "9",
        "--step.reach", "settings"},
       "beyond the reach of the legs; reduce walk.velocity"},
      {{"--walk.velocity", "[0.1,0,0]"}, "walk.velocity needs step.planner=ocp"},
      // known pushes
      {{"--step.known", "true", "--step.planner", "ocp"}, "now means step.planner=push_formula"}};
  for (const auto& [words, part] : cases) {
    const ProgramRun refused = run(words);
    EXPECT_EQ(refused.status, 2) << part;
    EXPECT_TRUE(contains(refused.complaint, part)) << refused.complaint;
    EXPECT_EQ(refused.complaint.find('\n'), refused.complaint.size() - 1) << refused.complaint;
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << part;
  }
}

}  // namespace
}  // namespace saltus::push_recovery
