// Messages about the folder of a run.
#include <gtest/gtest.h>

#include <chrono>

#include "problems/biped/report/scripts.hpp"
#include "tests/app/support.hpp"

namespace saltus::robots::walking {
namespace {

TEST(ResultsText, ListsFilesOfThisRunOnly) {
  const TemporaryFolder folder;
  const auto begin = std::filesystem::file_time_type::clock::now();
  const auto leave = [&](const char* name, std::chrono::seconds after) {
    std::filesystem::last_write_time(folder.file(name, ""), begin + after);
  };
  leave("com.png", std::chrono::seconds(0));
  leave("forces.png", std::chrono::seconds(-1));  // from an earlier run
  leave("report.html", std::chrono::seconds(1));
  const std::string alone = results_text(folder.path(), begin);
  EXPECT_TRUE(contains(alone, "results in " + folder.path().string() + "\n"));
  EXPECT_TRUE(contains(alone, "  com.png\n"));
  EXPECT_FALSE(contains(alone, "forces.png"));
  EXPECT_FALSE(contains(alone, "feet.png"));
  EXPECT_TRUE(contains(alone, "  trajectory.csv, ticks.csv "));
  EXPECT_TRUE(contains(alone, "report on one page"));
  EXPECT_TRUE(contains(alone, "needs no network: xdg-open " + (folder / "report.html").string()));
  EXPECT_FALSE(contains(alone, "view"));

  leave("estimate.png", std::chrono::seconds(1));
  EXPECT_TRUE(contains(results_text(folder.path(), begin), "  com.png, estimate.png\n"));

  leave("body.csv", std::chrono::seconds(1));
  leave("view.html", std::chrono::seconds(1));
  const std::string both = results_text(folder.path(), begin);
  EXPECT_TRUE(contains(both, "  trajectory, body, ticks (.csv) "));
  EXPECT_TRUE(contains(both, "  view.html "));
  EXPECT_TRUE(contains(both, "needs no network and links to view.html: xdg-open "));
}

TEST(ResultsText, OmitsAMissingReport) {
  const TemporaryFolder folder;
  const std::string text =
      results_text(folder.path(), std::filesystem::file_time_type::clock::now());
  EXPECT_TRUE(contains(text, "summary.json, config.yaml"));
  EXPECT_FALSE(contains(text, "report.html"));
  EXPECT_FALSE(contains(text, "xdg-open"));
  EXPECT_FALSE(contains(text, ".png"));
}

}  // namespace
}  // namespace saltus::robots::walking
