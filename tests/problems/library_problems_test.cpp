// `saltus run` for problems of the library: finds each one and writes correct tables.
#include "problems/suite/library_problems.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "problems/library/catalogue.hpp"
#include "saltus/app/program.hpp"
#include "saltus/solver/solver.hpp"
#include "tests/app/support.hpp"

namespace saltus {
namespace {

// Lines and cells of a CSV table without quoted cells.
std::vector<std::vector<std::string>> table_of(const std::filesystem::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream stream(file_content(file));
  for (std::string line; std::getline(stream, line);) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

struct LibraryProblems : testing::Test {
  // Exit status of `saltus run NAME ...`, with the results in the folder.
  int run(std::vector<const char*> words) {
    const std::string out = folder.path().string();
    words.insert(words.begin(), {"saltus", "run"});
    words.insert(words.end(), {"--out", out.c_str()});
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int status = saltus_main(static_cast<int>(words.size()), words.data(), problems);
    printed = testing::internal::GetCapturedStdout();
    complaint = testing::internal::GetCapturedStderr();
    return status;
  }
  nlohmann::json summary() const {
    return nlohmann::json::parse(file_content(folder / "summary.json"));
  }

  const std::vector<ProblemEntry> problems = library_problems();
  TemporaryFolder folder;
  std::string printed, complaint;
};

TEST_F(LibraryProblems, EveryCaseHasThreeNamesAndASummary) {
  EXPECT_EQ(problems.size(), reference_cases().size() + simulation_cases().size() + 1);
  std::set<std::string> names;
  for (const ProblemEntry& entry : problems) {
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
    ASSERT_FALSE(entry.summary.empty()) << entry.name;
    EXPECT_NE(std::string(".?").find(entry.summary.back()), std::string::npos) << entry.summary;
    EXPECT_FALSE(entry.kind.empty());
    EXPECT_EQ(entry.aliases.size(), 2u);
  }
  for (const SimulationCase& c : simulation_cases()) EXPECT_TRUE(c.motions) << c.name;
}

TEST_F(LibraryProblems, StatesAndInputsHaveNames) {
  for (const ReferenceCase& c : reference_cases()) {
    int nx = 0, nu = 0;
    const OptimalControlProblem problem = c.problem();
    for (const PhaseDefinition& phase : problem.phases()) {
      nx = std::max(nx, phase.sizes.nx);
      nu = std::max(nu, phase.sizes.nu);
    }
    EXPECT_EQ(static_cast<int>(c.states.size()), nx) << c.name;
    EXPECT_EQ(static_cast<int>(c.inputs.size()), nu) << c.name;
  }
}

TEST_F(LibraryProblems, OptimalControlProblemWritesItsTables) {
  ASSERT_EQ(run({"A20", "--pictures=false"}), 0) << complaint;
  EXPECT_TRUE(contains(printed, "2.57065"));
  const auto trajectory = table_of(folder / "trajectory.csv");
  EXPECT_EQ(trajectory[0], (std::vector<std::string>{"t [s]", "mode", "height [m]", "speed [m/s]",
                                                     "thrust [m/s^2]"}));
  EXPECT_EQ(trajectory[1][1], "fall");
  EXPECT_EQ(trajectory.back()[1], "rise");
  EXPECT_NEAR(std::stod(trajectory.back()[0]), 1.0, 1e-12);
  const auto events = table_of(folder / "events.csv");
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[1][1], "impact");
  EXPECT_NEAR(std::stod(events[1][0]), 0.470504556810741, 1e-8);
  const nlohmann::json s = summary();
  EXPECT_EQ(s.at("verdict"), "ok");
  EXPECT_EQ(s.at("solver"), "ipopt");
  EXPECT_NEAR(s.at("cost").get<double>(), 2.570651595764464, 1e-9);
  EXPECT_EQ(s.at("reference").get<double>(), 2.570651595764464);
  EXPECT_LT(s.at("kkt_residual").get<double>(), 1e-8);
  EXPECT_TRUE(contains(s.at("integrator"), "Kutta"));
  EXPECT_EQ(s.at("phases").size(), 2u);
  EXPECT_TRUE(s.at("versions").contains("saltus"));
  EXPECT_TRUE(contains(file_content(folder / "config.yaml"), "solver: ipopt"));
  EXPECT_FALSE(std::filesystem::exists(folder / "trajectory.png"));
}

TEST_F(LibraryProblems, SettingsChangeGridIntegratorAndSolver) {
  ASSERT_EQ(run({"phase_transition", "--solver", "riccati", "--intervals=6", "--integrator=rk8",
                 "--pictures=false", "--samples", "2"}),
            0)
      << complaint;
  EXPECT_EQ(summary().at("solver"), "riccati");
  EXPECT_EQ(summary().at("verdict"), "MISSED");  // another grid, other costs at its nodes
  EXPECT_EQ(table_of(folder / "trajectory.csv").size(), 1u + 2u * 6u * 3u);
  EXPECT_EQ(run({"c02", "--integrator=zoh", "--solvr=ipopt"}), 2);
  EXPECT_EQ(complaint, "saltus: unknown flag '--solvr'; did you mean '--solver'?\n");
  EXPECT_EQ(run({"a01", "--integrator=zoh", "--pictures=false"}), 2);  // not linear
  EXPECT_EQ(std::count(complaint.begin(), complaint.end(), '\n'), 1) << complaint;
  EXPECT_EQ(run({"a01_tree_modes"}), 2);
  EXPECT_TRUE(contains(complaint, "did you mean 'a01_three_modes'?"));
}

// Our own solvers find a cheaper optimum of the nodal program of B01 that rises above the ceiling
// between the nodes.
TEST_F(LibraryProblems, PrintIterationsNothingOrTheSummary) {
  ASSERT_EQ(run({"B22", "--monitor", "--pictures=false"}), 0) << complaint;
  EXPECT_EQ(printed.find(header_of_iterations()), 0u) << printed;
  ASSERT_EQ(run({"B22", "--quiet", "--pictures=false"}), 0) << complaint;
  EXPECT_EQ(printed, "");
  ASSERT_EQ(run({"B22", "--json", "--pictures=false"}), 0) << complaint;
  EXPECT_EQ(nlohmann::json::parse(printed), summary());
}

TEST_F(LibraryProblems, AnExplanationIsInTheSummary) {
  ASSERT_EQ(run({"B22", "--explain", "--pictures=false"}), 0) << complaint;
  EXPECT_NE(printed.find("the constraints can be met"), std::string::npos) << printed;
  EXPECT_TRUE(summary()["explanation"]["missing"].empty());
  EXPECT_EQ(summary()["interrupted"], false);
  ASSERT_EQ(run({"B22", "--pictures=false"}), 0) << complaint;
  EXPECT_FALSE(summary().contains("explanation"));
}

TEST_F(LibraryProblems, RefinesAPlanThatViolatesAConstraintBetweenNodes) {
  ASSERT_EQ(run({"B01", "--solver=sparse", "--pictures=false"}), 0) << complaint;
  EXPECT_EQ(summary().at("verdict"), "ok");
  EXPECT_NEAR(summary().at("cost").get<double>(), 4.0, 1e-7);
  EXPECT_GE(summary().at("refinements").get<int>(), 1);
  EXPECT_TRUE(contains(printed, "refined")) << printed;
  ASSERT_EQ(run({"B01", "--solver=sparse", "--refine=false", "--pictures=false"}), 3) << complaint;
  EXPECT_NE(summary().at("verdict"), "ok");
  EXPECT_EQ(summary().at("refinements"), 0);
  EXPECT_TRUE(contains(printed, "between two nodes 'ceiling'")) << printed;
}

TEST_F(LibraryProblems, SimulationWritesItsEvents) {
  ASSERT_EQ(run({"D07", "--pictures=false"}), 0) << complaint;
  const auto events = table_of(folder / "events.csv");
  ASSERT_GE(events.size(), 7u);
  const double first = std::sqrt(2.0 / 9.81);
  EXPECT_NEAR(std::stod(events[1][0]), first, 1e-9);
  EXPECT_NEAR(std::stod(events[2][0]), first * (1.0 + 2.0 * 0.8), 1e-9);
  EXPECT_EQ(events[1][2], "jumps");
  ASSERT_EQ(run({"spring_leg_stance", "--integrator", "rk4", "--pictures=false"}), 0) << complaint;
  const auto trajectory = table_of(folder / "trajectory.csv");
  EXPECT_EQ(trajectory[1][1], "flight");
  EXPECT_EQ(run({"D06", "--integrator", "zoh", "--pictures=false"}), 2);
}

TEST_F(LibraryProblems, CaseWithSeveralMotionsWritesATableForEach) {
  ASSERT_EQ(run({"filippov_cases", "--pictures=false"}), 0) << complaint;
  const nlohmann::json s = summary();
  EXPECT_EQ(s.at("tables"), (nlohmann::json{"trajectory_crossing.csv", "trajectory_entering.csv",
                                            "trajectory_leaving.csv"}));
  const auto sliding = table_of(folder / "events_entering.csv");
  ASSERT_EQ(sliding.size(), 2u);
  EXPECT_EQ(sliding[1][2], "slides");
  EXPECT_NEAR(std::stod(sliding[1][0]), 0.5, 1e-9);
}

TEST_F(LibraryProblems, LoopWritesTicksAndFigures) {
  ASSERT_EQ(run({"A20", "--loop", "--loop.period=0.1", "--loop.disturbance=0.01", "--loop.seed=3",
                 "--pictures=false"}),
            0)
      << complaint;
  const nlohmann::json s = summary();
  EXPECT_EQ(s.at("horizon"), "shrinking");
  EXPECT_TRUE(s.at("completed").get<bool>()) << s.at("message");
  const auto ticks = table_of(folder / "ticks.csv");
  EXPECT_EQ(ticks.size(), s.at("ticks").get<std::size_t>() + 1);
  int counted = 0;
  for (const auto& [name, count] : s.at("provenance").items()) counted += count.get<int>();
  EXPECT_EQ(counted, s.at("ticks").get<int>());
  EXPECT_EQ(s.at("fallbacks"), 0);
  EXPECT_GT(s.at("worst_tick").at("seconds").get<double>(), 0.0);
  EXPECT_NEAR(s.at("cost_of_plan_by_solver").get<double>(), 2.570651595764464, 1e-8);
  // A zero-order hold of 0.1 s turns ramps of the input into stairs.
  EXPECT_NEAR(s.at("cost_of_plan").get<double>(), 2.57, 0.05);
  EXPECT_GT(s.at("cost").get<double>(), 0.0);
  const auto events = table_of(folder / "events.csv");
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[1][1], "impact");
  EXPECT_EQ(events[2][1], "end");
  EXPECT_NEAR(std::stod(events[2][0]), 1.0, 1e-6);
  EXPECT_TRUE(std::filesystem::exists(folder / "plans.csv"));
  EXPECT_TRUE(contains(printed, "in closed loop"));
  const std::string trajectory = file_content(folder / "trajectory.csv");
  ASSERT_EQ(run({"A20", "--loop", "--loop.period=0.1", "--loop.disturbance=0.01", "--loop.seed=3",
                 "--pictures=false"}),
            0);
  EXPECT_EQ(file_content(folder / "trajectory.csv"), trajectory);  // same seed, same result
}

TEST_F(LibraryProblems, RegulatorRecedesAndStepsOnRequest) {
  ASSERT_EQ(run({"C03", "--solver=riccati", "--loop", "--loop.method=step", "--loop.period=0.05",
                 "--loop.duration=0.2", "--pictures=false"}),
            0)
      << complaint;
  EXPECT_EQ(summary().at("horizon"), "receding");
  const nlohmann::json counted = summary().at("provenance");
  int made = 0;  // plans computed in their own tick; the program decides whether a step is optimal
  for (const char* name : {"optimal", "feasible", "step"}) made += counted.at(name).get<int>();
  EXPECT_EQ(made, 4);
  const auto ticks = table_of(folder / "ticks.csv");
  ASSERT_EQ(ticks[0][8], "check time [s]");
  for (std::size_t k = 1; k < ticks.size(); ++k) EXPECT_GT(std::stod(ticks[k][8]), 0.0) << k;
  EXPECT_GT(summary().at("check_s").at("median").get<double>(), 0.0);
}

TEST_F(LibraryProblems, RejectLoopsWithoutInputs) {
  for (const char* name : {"D07", "A17", "C01"}) {
    EXPECT_EQ(run({name, "--loop"}), static_cast<int>(ExitStatus::not_applicable)) << name;
    EXPECT_EQ(std::count(complaint.begin(), complaint.end(), '\n'), 1) << complaint;
    EXPECT_TRUE(contains(complaint, "cannot run in closed loop")) << complaint;
  }
  int loops = 0;
  for (const ProblemEntry& entry : problems) loops += contains(entry.kind, "--loop") ? 1 : 0;
  EXPECT_EQ(loops, static_cast<int>(reference_cases().size()) - 7);  // all but A17, E01 to E06
}

}  // namespace
}  // namespace saltus
