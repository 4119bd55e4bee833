// Tests the parser of the command line and the program that acts on it.
#include "saltus/app/program.hpp"

#include <gtest/gtest.h>

#include <new>
#include <stdexcept>

#include "saltus/app/option_parser.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "tests/app/support.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

// Control characters in arguments, such as colours or a cleared screen, do not reach the terminal.
TEST(Text, EscapesControlCharacters) {
  EXPECT_EQ(printable("a\tb\nc \x1b[2J\x7f"), "a\\tb\\nc \\x1b[2J\\x7f");
  EXPECT_EQ(printable("Grad \xc2\xb0"), "Grad \xc2\xb0");
}

using Words = std::vector<std::string>;

std::string complaint_about(const Words& words) {
  return error_of<InputError>([&] { parse_run_request(words); }, "no complaint");
}

TEST(RunRequest, AcceptsAllFormsOfFlags) {
  const RunRequest request =
      parse_run_request(Words{"--plant", "dart", "push_recovery", "--config=a.yaml", "--set",
                              "push.impulse=-8", "--set=stepping=false", "--push.start=-1",
                              "--step.duration", "-2", "--brisk", "--out", "dir"});
  EXPECT_EQ(request.problem, "push_recovery");
  EXPECT_EQ(request.config_file, "a.yaml");
  EXPECT_EQ(request.out, "dir");
  EXPECT_FALSE(request.help);
  ASSERT_EQ(request.assignments.size(), 6u);
  const Words keys{"plant", "push.impulse", "stepping", "push.start", "step.duration", "brisk"};
  const Words values{"dart", "-8", "false", "-1", "-2"};
  for (std::size_t i = 0; i < keys.size(); ++i) {
    EXPECT_EQ(request.assignments[i].key, keys[i]);
    if (i < values.size()) {
      EXPECT_EQ(request.assignments[i].items, Words{values[i]});
    }
  }
  EXPECT_EQ(request.assignments[5].form, Assignment::Form::none);
}

TEST(RunRequest, KeepsFlagsWithTheirValues) {
  // The word after an unknown flag is its value. A flag after an unknown flag is not.
  const RunRequest request =
      parse_run_request(Words{"--brisk", "--out", "dir", "hopper", "--height=-0.5", "--list",
                              "[1, 2]", "--set", "a=b=c", "--name"});
  EXPECT_EQ(request.problem, "hopper");
  ASSERT_EQ(request.assignments.size(), 5u);
  EXPECT_EQ(request.assignments[0].form, Assignment::Form::none);
  EXPECT_EQ(request.assignments[1].items, Words{"-0.5"});
  EXPECT_EQ(request.assignments[2].items, (Words{"1", "2"}));
  EXPECT_EQ(request.assignments[3].items, Words{"b=c"});
}

TEST(RunRequest, HasDefaults) {
  const RunRequest request = parse_run_request(Words{"hopper"});
  EXPECT_EQ(request.out, "results/hopper");
  EXPECT_FALSE(request.config_file);
  EXPECT_TRUE(parse_run_request(Words{"--help"}).help);
}

TEST(RunRequest, RejectsMistakes) {
  EXPECT_TRUE(contains(complaint_about({}), "needs the name of a problem"));
  EXPECT_TRUE(contains(complaint_about({"a", "b"}), "one problem at a time: 'a' or 'b'?"));
  EXPECT_TRUE(contains(complaint_about({"a", "--out"}), "--out needs a value"));
  EXPECT_TRUE(contains(complaint_about({"a", "--out="}), "--out needs a value"));
  EXPECT_TRUE(contains(complaint_about({"a", "--config", "--out", "b"}), "--config needs a value"));
  EXPECT_TRUE(contains(complaint_about({"a", "--set"}), "--set needs a value"));
  EXPECT_TRUE(contains(complaint_about({"a", "--set", "b"}), "expected KEY=VALUE"));
  EXPECT_TRUE(contains(complaint_about({"a", "--out", "b", "--out", "c"}), "given twice"));
  EXPECT_TRUE(contains(complaint_about({"a", "-x"}), "unknown flag '-x'"));
}

TEST(OptionParser, HelpNamesEveryOption) {
  std::string file;
  bool all = false;
  OptionParser parser("sort", "sorts things");
  parser.option("--json", "FILE", "where to", file).flag("--all", "not only some", all);
  for (const char* part : {"sorts things", "--json FILE", "where to", "--all", "--help"})
    EXPECT_TRUE(contains(parser.help(), part));
  parser.parse(Words{"--all", "--json", "a.json"});
  EXPECT_TRUE(all);
  EXPECT_EQ(file, "a.json");
  EXPECT_FALSE(parser.help_wanted());
}

TEST(OptionParser, RejectsMistakes) {
  const auto complaint = [](const Words& words) {
    return complaint_of([&] {
      std::string file;
      bool all = false;
      OptionParser("sort", "sorts")
          .option("--json", "FILE", "where to", file)
          .flag("--all", "not only some", all)
          .parse(words);
    });
  };
  EXPECT_EQ(complaint({"--jsn", "a"}), "unknown flag '--jsn'; did you mean '--json'?");
  EXPECT_EQ(complaint({"--all=yes"}), "--all takes no value, but 'yes' follows");
  EXPECT_EQ(complaint({"--json", "--all"}), "--json needs a value: --json FILE");
  EXPECT_EQ(complaint({"--json=a", "--json=b"}), "--json is given twice");
  EXPECT_EQ(complaint({"x"}), "'x' is not understood; usage: sort [--json FILE] [--all]");
  EXPECT_EQ(complaint({"--all", "x"}), "'x' is not understood; usage: sort [--json FILE] [--all]");
  EXPECT_EQ(complaint({"-h"}), "no complaint");
}

struct HopConfig {
  double height = 0.3;
  bool fail = false;
  bool broken = false;
};

void declare_settings(Settings& settings, HopConfig& config) {
  settings.number("height", config.height, "m", "height of the hop", above(0.0));
  settings.flag("fail", config.fail, "let the solver fail");
  settings.flag("broken", config.broken, "define the problem wrongly");
}

ExitStatus hop(const HopConfig& config, const RunContext& context) {
  if (config.broken) throw DefinitionError("phase 'flight': expected 2 states, given 3");
  context.output.write("height.txt", std::to_string(config.height));
  context.output.write("config.yaml", context.effective_config);
  return config.fail ? ExitStatus::solver_failed : ExitStatus::ok;
}

struct ProgramTest : testing::Test {
  int run(std::vector<const char*> words) {
    words.insert(words.begin(), "saltus");
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int status = saltus_main(static_cast<int>(words.size()), words.data(), problems, verbs);
    printed = testing::internal::GetCapturedStdout();
    complaint = testing::internal::GetCapturedStderr();
    return status;
  }

  std::vector<ProblemEntry> problems{
      problem_entry<HopConfig>("hopper", "a hopping mass", declare_settings, hop),
      {"crash", "throws",
       [](const RunRequest&) -> ExitStatus { throw std::out_of_range("no such entry"); }},
      {"huge", "needs memory", [](const RunRequest&) -> ExitStatus { throw std::bad_alloc(); }}};
  std::vector<Verb> verbs{{"count", "counts its arguments", [](std::span<const std::string> words) {
                             std::printf("%zu", words.size());
                             return ExitStatus::ok;
                           }}};
  TemporaryFolder folder;
  std::string printed;
  std::string complaint;
};

TEST_F(ProgramTest, PrintsListAndHelp) {
  EXPECT_EQ(run({"list"}), 0);
  EXPECT_EQ(printed, "  hopper  a hopping mass\n  crash   throws\n  huge    needs memory\n");
  EXPECT_EQ(run({"help"}), 0);
  EXPECT_TRUE(contains(printed, "counts its arguments"));
  EXPECT_EQ(run({"run", "hopper", "--help"}), 0);
  EXPECT_TRUE(contains(printed, "height=0.3 m"));
  EXPECT_EQ(run({"count", "a", "b"}), 0);
  EXPECT_EQ(printed, "2");
}

TEST_F(ProgramTest, RunsAndWrites) {
  const std::string out = folder / "deep/out";
  EXPECT_EQ(run({"run", "hopper", "--height", "0.5", "--out", out.c_str()}), 0) << complaint;
  EXPECT_EQ(file_content(folder / "deep/out/config.yaml"),
            "height: 0.5  # m\nfail: false\nbroken: false\nlog:\n  formats: \"csv\"\n");
  EXPECT_EQ(run({"run", "hopper", "--fail", "--out", out.c_str()}), 3);
  EXPECT_EQ(complaint, "");
}

TEST_F(ProgramTest, MistakesAreOneSentenceAndStatusTwo) {
  const std::string out = folder / "out";
  const auto expect_refused = [&](std::vector<const char*> words, const std::string& sentence) {
    EXPECT_EQ(run(words), 2);
    EXPECT_EQ(complaint, "saltus: " + sentence + "\n");
    EXPECT_FALSE(std::filesystem::exists(out));
  };
  expect_refused({}, "a verb is missing");
  expect_refused({"rum"}, "unknown verb 'rum'; did you mean 'run'?");
  expect_refused({"list", "x"}, "list takes no arguments, but 'x' follows");
  expect_refused({"rum", "list"}, "unknown verb 'rum'; did you mean 'run'?");
  expect_refused({"run", "list"}, "unknown problem 'list'; 'saltus list' shows them");
  expect_refused({"run", "hoper"}, "unknown problem 'hoper'; did you mean 'hopper'?");
  expect_refused({"run", "zzz"}, "unknown problem 'zzz'; 'saltus list' shows them");
  expect_refused({"run", "hopper", "--hieght", "1", "--out", out.c_str()},
                 "unknown flag '--hieght'; did you mean '--height'?");
  expect_refused({"run", "hopper", "--set", "height=0", "--out", out.c_str()},
                 "--set height=0: 'height' must be above 0 m, not '0'");
  expect_refused({"run", "hopper", "--broken", "--out", out.c_str()},
                 "phase 'flight': expected 2 states, given 3");
  EXPECT_EQ(run({"run", "hopper", "--log.formats", "csv,xls", "--out", out.c_str()}), 2);
  EXPECT_TRUE(contains(complaint, "log.formats must name csv, mat or mcap")) << complaint;
  EXPECT_EQ(run({"run", "hopper", "--out", "/proc/hop"}), 2);
  EXPECT_TRUE(contains(complaint, "output folder '/proc/hop'"));
  EXPECT_EQ(run({"run", "crash"}), 1);
  EXPECT_TRUE(contains(complaint, "internal error"));
  expect_refused({"run", "huge"}, "not enough memory; a smaller problem needs less");
}

}  // namespace
}  // namespace saltus
