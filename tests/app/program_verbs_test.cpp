// Tests the commands around a run: print its settings, repeat it, complete words.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "saltus/app/completion.hpp"
#include "saltus/app/logs_verb.hpp"
#include "saltus/app/program.hpp"
#include "saltus/app/rerun.hpp"
#include "tests/app/support.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

struct DropConfig {
  double height = 1.0;
  std::string ground = "hard";
};

void declare_settings(Settings& settings, DropConfig& config) {
  settings.number("drop.height", config.height, "m", "from where it falls", above(0.0));
  settings.choice("ground", config.ground, {"hard", "soft"}, "where it falls");
}

double drift = 0.0;  // makes a run differ from the previous one
int runs = 0;

ExitStatus drop(const DropConfig& config, const RunContext& context) {
  ++runs;
  context.output.write("config.yaml", std::string_view(context.effective_config));
  CsvTable table({"t [s]", "height [m]", "solve time [s]"});
  for (const double t : {0.0, 0.1})
    table.add_row(std::vector<double>{t, config.height - 4.9 * t * t + drift * t, 1e-3 * runs});
  context.output.write("trajectory.csv", table);
  if (config.ground == "soft") context.output.write("marks.csv", table);
  context.output.write("summary.json", nlohmann::ordered_json{{"cost", config.height},
                                                              {"seconds", 1e-3 * runs},
                                                              {"plans", {{"processor_us", runs}}}});
  return ExitStatus::ok;
}

struct VerbsTest : testing::Test {
  VerbsTest() { drift = 0.0; }
  int run(const Words& words) {
    std::vector<const char*> pointers{"saltus"};
    for (const std::string& word : words) pointers.push_back(word.c_str());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int status = saltus_main(static_cast<int>(pointers.size()), pointers.data(), problems);
    printed = testing::internal::GetCapturedStdout();
    complaint = testing::internal::GetCapturedStderr();
    return status;
  }

  std::vector<ProblemEntry> problems{
      problem_entry<DropConfig>("drop", "a falling mass", declare_settings, drop)};
  TemporaryFolder folder;
  std::string printed, complaint;
};

TEST_F(VerbsTest, PrintedSettingsRoundTrip) {
  ASSERT_EQ(run({"run", "drop", "--drop.height=2", "--print-config"}), 0);
  EXPECT_EQ(printed,
            "# drop: a falling mass\n"
            "drop:\n"
            "  # from where it falls [m; above 0; default 1]\n"
            "  height: 2\n"
            "# where it falls [hard or soft; default hard]\n"
            "ground: hard\n"
            "log:\n"
            "  # formats of the tables: csv (always written), mat (run.mat, v7.3 in the layout of "
            "robometry),\n"
            "  # mcap (run.mcap, JSON for Foxglove and PlotJuggler); python3 needs h5py for mat, "
            "and mcap "
            "for\n"
            "  # mcap [default \"csv\"]\n"
            "  formats: \"csv\"\n");
  const std::string file = folder.file("mine.yaml", printed);
  const std::string before = printed;
  ASSERT_EQ(run({"run", "drop", "--config", file, "--print-config"}), 0);
  EXPECT_EQ(printed, before);
  ASSERT_EQ(run({"run", "drop", "--print-schema"}), 0);
  EXPECT_EQ(nlohmann::json::parse(printed).at("title"), "drop");
  EXPECT_FALSE(fs::exists("results/drop"));
}

TEST_F(VerbsTest, RerunReportsEquality) {
  const std::string out = folder / "first";
  ASSERT_EQ(run({"run", "drop", "--drop.height", "0.1", "--out", out}), 0);
  EXPECT_EQ(run({"rerun", out}), 0) << complaint;
  EXPECT_TRUE(
      contains(printed, "trajectory.csv: bit-identical (2 rows, except for computing times"));
  EXPECT_TRUE(contains(printed, "summary.json: bit-identical"));
  EXPECT_FALSE(fs::exists(folder / "first.again"));

  drift = 1e-16;  // one unit in the last digit
  EXPECT_EQ(run({"rerun", out}), 5);
  EXPECT_TRUE(contains(printed, "trajectory.csv: differs first in row 2, column 'height [m]'"));
  EXPECT_TRUE(contains(printed, "different; the new results are in"));
  EXPECT_TRUE(fs::exists(folder / "first.again/trajectory.csv"));
  EXPECT_EQ(run({"rerun", out}), 2);
  EXPECT_TRUE(contains(complaint, "first.again' exists already; give another folder with --out"));
}

// Results of the previous run are neither drawn nor compared. Other files stay.
TEST_F(VerbsTest, RunReplacesThePreviousRun) {
  const fs::path out = folder / "first";
  ASSERT_EQ(run({"run", "drop", "--ground", "soft", "--out", out}), 0);
  EXPECT_TRUE(fs::exists(out / "marks.csv"));
  folder.file("first/mine.csv", "mine");
  fs::last_write_time(out / "mine.csv",
                      fs::last_write_time(out / "run.json") - std::chrono::hours(1));
  ASSERT_EQ(run({"run", "drop", "--drop.height=-1", "--out", out}), 2);
  EXPECT_TRUE(fs::exists(out / "marks.csv")) << "of a run that wrote nothing";
  ASSERT_EQ(run({"run", "drop", "--out", out}), 0);
  EXPECT_FALSE(fs::exists(out / "marks.csv"));
  for (const char* kept : {"mine.csv", "trajectory.csv", "summary.json", "run.json"})
    EXPECT_TRUE(fs::exists(out / kept)) << kept;
  EXPECT_EQ(run({"rerun", out}), 0) << printed << "mine.csv belongs to no run";

  // A foreign run.json removes no file outside the folder, and no file that no run writes.
  const fs::path beside = folder.file("beside.csv", "mine"),
                 tool = folder.file("first/tool.sh", "mine");
  folder.file("first/run.json", R"({"files": ["../beside.csv", "tool.sh", "..", "", 7, {}]})");
  ASSERT_EQ(run({"run", "drop", "--out", out}), 0);
  EXPECT_TRUE(fs::exists(beside) && fs::exists(tool));
}

// Pictures, other formats and a movie of the previous run must not remain next to the new tables.
TEST_F(VerbsTest, FilesAddedByVerbsBelongToTheRun) {
  const fs::path out = folder / "first";
  ASSERT_EQ(run({"run", "drop", "--out", out}), 0);
  folder.file("first/mine.png", "mine");
  // Replaces a python3 that has the required packages.
  fs::create_directories(folder / "python");
  const std::string folder_name = folder.path();
  const fs::path writer = folder.file("writer",
                                      "#!/bin/sh\n"
                                      "for file in run.mat drawn.png movie.mp4 movie.gif tool.sh; "
                                      "do echo written > \"$4/$file\"; done\n");
  fs::permissions(writer, fs::perms::owner_all);
  {
    const Variable data("SALTUS_DATA_DIR", folder_name.c_str());
    const Variable python("SALTUS_PYTHON", writer.c_str());
    ASSERT_EQ(logs_verb().run(Words{out}), ExitStatus::ok);
  }
  ASSERT_TRUE(fs::exists(out / "movie.gif"));
  EXPECT_EQ(run({"rerun", out}), 0) << printed << complaint;
  ASSERT_EQ(run({"run", "drop", "--out", out}), 0);
  for (const char* gone : {"run.mat", "drawn.png", "movie.mp4", "movie.gif"})
    EXPECT_FALSE(fs::exists(out / gone)) << gone;
  for (const char* kept : {"mine.png", "tool.sh", "trajectory.csv", "run.json"})
    EXPECT_TRUE(fs::exists(out / kept)) << kept;
}

// Without run.json, or with one of an older version, the owner of each file is unknown.
TEST_F(VerbsTest, FilesAddedWithoutARunAreIgnored) {
  const auto add = [&](const char* name) {
    const AddedFiles added(folder.path());
    folder.file(name, "written");
    added.note();
  };
  add("one.png");
  EXPECT_FALSE(fs::exists(folder / "run.json"));
  const std::string old = R"({"problem": "drop", "folder": "/"})";
  folder.file("run.json", old);
  add("two.png");
  EXPECT_EQ(file_content(folder / "run.json"), old);
  folder.file("run.json", R"({"problem": "drop", "files": ["run.json"]})");
  add("three.png");
  EXPECT_EQ(nlohmann::json::parse(file_content(folder / "run.json")),
            nlohmann::json::parse(R"({"problem": "drop", "files": ["run.json", "three.png"]})"));
}

TEST_F(VerbsTest, RerunComparesEveryCellAndEveryEntry) {
  const auto is_same = [&](const char* file, const std::string& one, const std::string& other) {
    for (const char* run : {"one", "other"}) fs::create_directories(folder / run);
    folder.file(std::string("one/") + file, one);
    folder.file(std::string("other/") + file, other);
    const std::vector<FileComparison> found = compare_runs(folder / "one", folder / "other");
    for (const char* run : {"one", "other"}) fs::remove_all(folder / run);
    return found.size() == 1 && found.front().is_same;
  };
  const std::string head = "t [s],mode,x,u\n";
  EXPECT_TRUE(is_same("a.csv", head + "0,\"a, b\",1,2\n", head + "0,\"a, b\",1,2\n"));
  EXPECT_FALSE(is_same("a.csv", head + "0,\"a, b\",1,2\n", head + "0,\"a, b\",1,3\n"));
  EXPECT_FALSE(is_same("a.csv", head + "0,a,1,2\n", head + "0,a,1,2,3\n"));
  const auto unmet = [](const char* seconds, const char* cost) {
    return std::string(R"({"unmet": [{"explanation": {"seconds": )") + seconds + R"(, "cost": )" +
           cost + "}}]}";
  };
  EXPECT_TRUE(is_same("summary.json", unmet("0.1", "1"), unmet("0.2", "1")));
  EXPECT_FALSE(is_same("summary.json", unmet("0.1", "1"), unmet("0.1", "2")));
  EXPECT_FALSE(is_same("summary.json", R"({"a": [1]})", R"({"a": [1, 1]})"));
  EXPECT_TRUE(is_same("robot.json", R"({"mass_kg": 33})", R"({"mass_kg": 33})"));
  EXPECT_FALSE(is_same("robot.json", R"({"mass_kg": 33})", R"({"mass_kg": 34})"));
}

TEST_F(VerbsTest, RerunNamesTheEntryThatDiffers) {
  const auto difference = [&](const std::string& one, const std::string& other) {
    for (const char* run : {"one", "other"}) fs::create_directories(folder / run);
    folder.file("one/summary.json", one);
    folder.file("other/summary.json", other);
    return compare_runs(folder / "one", folder / "other").front().text;
  };
  EXPECT_EQ(difference("{}", R"({"key": 1})"), "differs first at key is new");
  EXPECT_EQ(difference(R"({"key": 1})", "{}"), "differs first at key is missing");
  EXPECT_EQ(difference(R"({"a": {}})", R"({"a": {"key": 1}})"), "differs first at a.key is new");
}

// A run that wrote robot.json, compared with a run of another version that did not.
TEST_F(VerbsTest, ComparesRobotsIfBothRunsHaveOne) {
  for (const char* run : {"one", "other"}) fs::create_directories(folder / run);
  folder.file("one/robot.json", "{}");
  EXPECT_TRUE(compare_runs(folder / "one", folder / "other").empty());
}

TEST_F(VerbsTest, RerunRejectsOtherFolders) {
  EXPECT_EQ(run({"rerun"}), 2);
  EXPECT_EQ(run({"rerun", folder / "nothing"}), 2);
  EXPECT_TRUE(contains(complaint, "there is no folder"));
  EXPECT_EQ(run({"rerun", folder.path()}), 2);
  EXPECT_TRUE(contains(complaint, "there is no run.json in"));
  folder.file("config.yaml", "ground: hard\n");
  folder.file("run.json", "{}");
  EXPECT_EQ(run({"rerun", folder.path()}), 2);
  EXPECT_TRUE(contains(complaint, "does not name the problem of the run"));
  folder.file("run.json", R"({"problem": "fly", "folder": "/"})");
  EXPECT_EQ(run({"rerun", folder.path()}), 2);
  EXPECT_TRUE(contains(complaint, "this program has no problem 'fly'"));
}

TEST_F(VerbsTest, LogsRejectsFoldersWithoutTables) {
  const auto complaint_about = [](const Words& words) {
    return complaint_of([&] { (void)logs_verb().run(words); });
  };
  EXPECT_TRUE(contains(complaint_about({}), "logs needs the folder of a run"));
  EXPECT_TRUE(contains(complaint_about({"nowhere"}), "logs: there is no folder 'nowhere'"));
  const std::string empty = folder.path().string();
  EXPECT_TRUE(contains(complaint_about({empty}), "logs: there is no trajectory.csv in"));
  EXPECT_TRUE(contains(complaint_about({empty, "--formats", "mat;mcap"}),
                       "logs: --formats: must name csv, mat or mcap, separated by commas"));
}

TEST_F(VerbsTest, CompletesWordsFromSettings) {
  const Words verbs{"list", "run", "rerun"};
  const auto of = [&](const Words& words) { return completions(words, verbs, problems); };
  EXPECT_EQ(of({"r"}), (Words{"run", "rerun"}));
  EXPECT_EQ(of({"run", ""}), Words{"drop"});
  EXPECT_EQ(of({"run", "drop", "--d"}), Words{"--drop.height"});
  EXPECT_EQ(of({"run", "drop", "--ground", ""}), (Words{"hard", "soft"}));
  EXPECT_EQ(of({"run", "drop", "--set", "gr"}), Words{"ground="});
  EXPECT_EQ(of({"run", "drop", "--config", ""}), Words{});
  EXPECT_EQ(of({"run", "drop", "--pri"}), (Words{"--print-config", "--print-schema"}));
  ASSERT_EQ(run({"completion", "bash"}), 0) << complaint;
  EXPECT_TRUE(contains(printed, completion_verb));
  EXPECT_EQ(run({"completion", "tcsh"}), 2);
}

}  // namespace
}  // namespace saltus
