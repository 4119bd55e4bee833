// Exported tables: names, units, empty cells, and both sides of an event.
#include "saltus/simulation/loop_log.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "saltus/core/csv_table.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/json_object.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/simulation/closed_loop.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

TEST(CsvTable, ReadsBackExactly) {
  CsvTable table({"t [s]", "a, b", "word"});
  table.number(0.1).number(1.0 / 3.0).word("one, \"two\"").end_row();
  table.number(-0.0).number(std::nan("")).end_row();
  EXPECT_EQ(table.text(),
            "t [s],\"a, b\",word\n0.1,0.3333333333333333,\"one, \"\"two\"\"\"\n-0,nan,\n");
  EXPECT_EQ(csv_cells("0.1,,\"one, \"\"two\"\"\""),
            (std::vector<std::string>{"0.1", "", "one, \"two\""}));
  EXPECT_THROW(table.number(1).number(2).number(3).number(4), DefinitionError);
  EXPECT_EQ(json_string("a\"b\\\n"), "\"a\\\"b\\\\\\u000a\"");
  EXPECT_EQ(json_number(std::nan("")), "null");
}

TEST(Recording, NamesColumnsAndLeavesAbsentCellsEmpty) {
  Recording recording;
  recording.state_names = {"height [m]"};
  recording.samples = {{0.0, VectorXd{{1.0, 2.0}}, VectorXd{{3.0}}, "up"},
                       {0.5, VectorXd{{4.0}}, VectorXd(), "down"}};
  recording.events = {{0.5, HybridEvent::Kind::jumps, "impact", "up", "down", {}, {}, {}}};
  EXPECT_EQ(recording.trajectory_csv(), "t [s],mode,height [m],x1,u0\n0,up,1,2,3\n0.5,down,4,,\n");
  EXPECT_EQ(recording.events_csv(),
            "t [s],event,kind,mode before,mode after\n0.5,impact,jumps,up,down\n");
}

struct Fall {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 9.81};
  }
};

TEST(Recording, PlanHasBothSidesOfJumps) {
  Phase<2, 1> fall{"fall", Fall{}, exactly(0.4)}, rise{"rise", Fall{}, exactly(0.3)};
  OptimalControlProblem ocp("ball");
  ocp.start_at({1.0, 0.0}).then(fall).then(rise, jump<2>("bounce", [](const auto&, const auto& x) {
                                             return decltype(x.eval()){x[0], -0.8 * x[1]};
                                           }));
  MultipleShooting shooting(ocp, {.intervals_per_phase = 2, .integrator = runge_kutta4()});
  NlpPoint point = shooting.initial_guess();
  const Recording recording = record(ocp, shooting.trajectory(point.w), 2);
  ASSERT_EQ(recording.events.size(), 1u);
  EXPECT_EQ(recording.events[0].name, "bounce");
  EXPECT_EQ(recording.events[0].mode_before, "fall");
  EXPECT_EQ(recording.events[0].mode_after, "rise");
  EXPECT_NEAR(recording.events[0].time, 0.4, 1e-12);
  int at_event = 0;
  for (const Sample& s : recording.samples) at_event += std::abs(s.time - 0.4) < 1e-12;
  EXPECT_EQ(at_event, 2);
  EXPECT_EQ(recording.samples.front().mode, "fall");
  EXPECT_EQ(recording.samples.back().mode, "rise");
}

Trajectory trajectory_of(const IntervalProblem& problem, const IntegratorChoice& scheme,
                         std::vector<Trajectory::Piece> pieces) {
  return {{{"move", VectorXd(), std::make_shared<const ReentrantIntegrator>(problem, scheme)}},
          std::move(pieces)};
}

void expect_order(const Recording& recording) {
  for (std::size_t i = 1; i < recording.samples.size(); ++i)
    EXPECT_LE(recording.samples[i - 1].time, recording.samples[i].time) << i;
}

// x' = u = 0, 1, 2, ... in pieces of equal length, also far from the origin of time.
TEST(Recording, EveryPieceHasItsInputUpToItsEnd) {
  const auto moved = [](const auto&, const auto& x, const auto& u) { return u[0] + 0.0 * x[0]; };
  IntervalProblem problem;
  problem.arguments = {1, 1, 0};
  problem.dynamics = make_function<1, 1, 0>(moved);
  for (const double start : {0.0, 20.0, 100.0, 1e6, 1.7e9})
    for (const double length : {0.1, 0.01}) {
      std::vector<Trajectory::Piece> pieces;
      for (int k = 0; k < 10; ++k)
        pieces.push_back({0, start + length * k, length, VectorXd{{0.0}}, VectorXd{{double(k)}},
                          VectorXd{{length * k}}});
      const Recording recording =
          record(OptimalControlProblem("move"), trajectory_of(problem, runge_kutta4(), pieces), 4);
      ASSERT_EQ(recording.samples.size(), 50u);
      const double clock = 3e-16 * start;  // rounding of times
      for (int i = 0; i < 50; ++i) {
        const int k = i / 5;
        EXPECT_EQ(recording.samples[i].input[0], k) << start << ", sample " << i;
        EXPECT_NEAR(recording.samples[i].state[0], k * 0.25 * length * (i % 5),
                    k * (clock + 1e-15));
      }
      expect_order(recording);
    }
}

// x' = (1, 1) below 0.35 and (-1, -1) above. The state follows the surface to the end.
TEST(Recording, SlidingBeginsOnce) {
  Automaton<2> automaton;
  const auto field = [](double rate) {
    return [rate](const auto&, const auto& x) {
      return decltype(x.eval()){rate + 0.0 * x[0], rate + 0.0 * x[1]};
    };
  };
  automaton.mode("below", field(1.0)).mode("above", field(-1.0));
  automaton.surface("level", "below", "above",
                    [](const auto&, const auto& x) { return x[0] - 0.35; });
  IntervalProblem problem;
  problem.arguments = {2, 0, 0};
  problem.switching = automaton.system();
  problem.dynamics = problem.switching.modes.front().dynamics;
  const IntegratorChoice scheme = runge_kutta4({.steps = 2});
  const std::unique_ptr<Integrator> integrator = scheme->make(problem);
  std::vector<Trajectory::Piece> pieces;
  VectorXd state = VectorXd::Zero(2), end(2);
  for (int k = 0; k < 10; ++k) {
    VectorXd w(4);
    w << state, 0.1 * k, 0.1;
    ASSERT_EQ(integrator->value(w.data(), end.data()), IntegrationStatus::success);
    pieces.push_back({0, 0.1 * k, 0.1, state, VectorXd(), end});
    state = end;
  }
  for (const int samples : {1, 2, 7}) {
    const Recording recording =
        record(OptimalControlProblem("slide"), trajectory_of(problem, scheme, pieces), samples);
    ASSERT_EQ(recording.events.size(), 1u) << recording.events_csv();
    EXPECT_EQ(recording.events[0].kind, HybridEvent::Kind::slides);
    EXPECT_NEAR(recording.events[0].time, 0.35, 1e-14);
    for (const Sample& s : recording.samples) {
      if (std::abs(s.time - 0.35) <= 1e-9) continue;
      EXPECT_EQ(s.mode == "below", s.time < 0.35) << s.time;
    }
    EXPECT_EQ(recording.samples.back().mode, recording.events[0].mode_after);
    expect_order(recording);
  }
}

// The sum of seven sevenths of an interval may differ from its end by rounding.
TEST(Recording, KeepsAnEventAtTheEndOfAPiece) {
  const auto ramp = [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; };
  const auto reset = [](const auto&, const auto& x) { return x[0] - 5.0; };
  for (int samples = 1; samples <= 24; ++samples)
    for (const double length : {0.1, 0.05, 0.07}) {
      Automaton<1> automaton;
      automaton.mode("a", ramp).mode("b", ramp).event(
          "e", "a", "b", [length](const auto&, const auto& x) { return x[0] - length; },
          Crossing::rising, reset);
      IntervalProblem problem;
      problem.arguments = {1, 0, 0};
      problem.switching = automaton.system();
      problem.dynamics = problem.switching.modes.front().dynamics;
      const Recording recording = record(
          OptimalControlProblem("ramp"),
          trajectory_of(problem, runge_kutta4(),
                        {{0, 0.0, length, VectorXd{{0.0}}, VectorXd(), VectorXd{{length - 5.0}}}}),
          samples);
      ASSERT_EQ(recording.events.size(), 1u) << samples << ' ' << length;
      EXPECT_EQ(recording.samples.back().mode, "b");
      expect_order(recording);
    }
}

TEST(Recording, SavedSolutionHasMultipliersAndSummary) {
  Solution plan;
  plan.status = SolveStatus::optimal;
  plan.multipliers = {{"fall", "ceiling", 0, {0.0, 0.5}, {0.0, -2.0}},
                      {"fall", "ceiling", 1, {0.5, 1.0}, {1.5, 0.0}},
                      {"fall", "landing", 0, {1.0}, {4.0}},
                      {"fall", "bounds of input 0", 0, {0.0, 0.5, 0.5}, {0.25, 0.0, -0.5}},
                      {"fall", Solution::Multiplier::costate, 0, {0.0, 1.0}, {7.0, 8.0}}};
  plan.costs = {{"fall", "effort", 3.0}};
  plan.soft_violations = {{"fall", "landing", 0.5, 1.0}};
  EXPECT_EQ(multipliers_csv(plan),
            "t [s],ceiling 0,ceiling 1,bounds of input 0,costate\n"
            "0,0,,0.25,7\n0.5,-2,1.5,0,\n0.5,,,-0.5,\n1,,0,,8\n");
  const std::string summary = summary_json("ball", plan);
  for (const char* part :
       {R"("name": "ball")", R"("term": "effort", "value": 3)",
        R"("term": "ceiling", "row": 0, "lower": 0, "upper": -2, "t_s": 0.5)",
        R"("term": "bounds of input 0", "row": 0, "lower": 0.25, "upper": -0.5, "t_s": 0.5)",
        R"("kind": "soft", "phase": "fall", "term": "landing", "t_s": 1, "amount": 0.5)"})
    EXPECT_NE(summary.find(part), std::string::npos) << part << " in " << summary;
  EXPECT_EQ(summary.find("costate"), std::string::npos);
}

TEST(Recording, LogWritesItsFiles) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("saltus_loop_" + std::to_string(::getpid()));
  IntegratorPlant plant = make_plant<2, 1>(Fall{}, runge_kutta4(), VectorXd{{1.0, 0.0}});
  LoopOptions options{.duration = 0.3, .period = 0.1};
  options.state_names = {"height [m]", "speed [m/s]"};
  options.input_names = {"thrust [m/s^2]"};
  const LoopLog log = simulate_closed_loop(
      [](double, const VectorRef&, VectorOut u) { u[0] = 9.81; }, plant, options);
  log.write(folder / "deep");
  const auto content = [&](const char* name) {
    std::ifstream stream(folder / "deep" / name);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  EXPECT_EQ(content("trajectory.csv").substr(0, 55),
            "t [s],height [m],speed [m/s],thrust [m/s^2]\n0,1,0,9.81\n");
  EXPECT_NE(content("ticks.csv").find("measured speed [m/s]\n0,feedback law,"), std::string::npos);
  EXPECT_NE(content("summary.json").find("\"ticks\": 3"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "deep/plans.csv"));
  std::filesystem::remove_all(folder);
  EXPECT_THROW(log.write("/proc/saltus"), InputError);
}

}  // namespace
}  // namespace saltus
