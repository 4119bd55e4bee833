// Tables that others read: names, units, empty cells, both sides of an event.
#include "saltus/simulation/recording.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/simulation/closed_loop.hpp"
#include "saltus/simulation/text_table.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

TEST(TextTable, ReadsBackExactly) {
  TextTable table({"t [s]", "a, b", "word"});
  table.number(0.1).number(1.0 / 3.0).word("one, \"two\"").end_row();
  table.number(-0.0).number(std::nan("")).end_row();
  EXPECT_EQ(table.text(),
            "t [s],\"a, b\",word\n0.1,0.3333333333333333,\"one, \"\"two\"\"\"\n-0,,\n");
  EXPECT_THROW(table.number(1).number(2).number(3).number(4), DefinitionError);
  EXPECT_EQ(json_string("a\"b\\\n"), "\"a\\\"b\\\\\\u000a\"");
  EXPECT_EQ(json_number(std::nan("")), "null");
}

TEST(Recording, NamesColumnsAndLeavesAbsentCellsEmpty) {
  Recording recording;
  recording.state_names = {"height [m]"};
  recording.samples = {{0.0, VectorXd{{1.0, 2.0}}, VectorXd{{3.0}}, "up"},
                       {0.5, VectorXd{{4.0}}, VectorXd(), "down"}};
  recording.events = {{0.5, EventKind::jumps, "impact", "up", "down", {}, {}, {}}};
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

TEST(Recording, APlanHasItsJumpsTwice) {
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

TEST(Recording, ALogWritesItsFiles) {
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
