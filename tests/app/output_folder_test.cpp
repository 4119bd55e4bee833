// Tests that results on disk are refused early, complete or absent, and exact.
#include "saltus/app/program.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/temporary_file.hpp"
#include "tests/app/support.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;

std::string complaint_about(const fs::path& path) {
  return error_of<InputError>([&] { OutputFolder{path}; }, "no complaint");
}

TEST(OutputFolder, IsCreatedWithTheFirstFile) {
  const TemporaryFolder folder;
  const OutputFolder output(folder / "a/b/");
  EXPECT_TRUE(fs::is_empty(folder.path()));
  output.write("x.txt", std::string_view("one"));
  output.write("x.txt", std::string_view("two"));
  output.write("sub/y.txt", std::string_view("three"));
  EXPECT_EQ(file_content(folder / "a/b/x.txt"), "two");
  EXPECT_EQ(file_content(folder / "a/b/sub/y.txt"), "three");
  const auto files = fs::recursive_directory_iterator(folder / "a/b");
  EXPECT_EQ(std::distance(begin(files), end(files)), 3) << "temporary files are left behind";
}

// A temporary file has an unpredictable name, is accessible to this user only, and follows no link.
TEST(OutputFolder, IncompleteFilesArePrivate) {
  const TemporaryFolder folder;
  const fs::path file = folder / "x.txt", one = temporary_path(file), two = temporary_path(file);
  EXPECT_NE(one, two);
  EXPECT_TRUE(one.filename().string().starts_with(".x.txt."));
  ASSERT_TRUE(make_private_file(one));
  EXPECT_FALSE(make_private_file(one)) << "is there already";
  const fs::perms others = fs::perms::group_all | fs::perms::others_all;
  EXPECT_EQ(fs::status(one).permissions() & others, fs::perms::none);
  const fs::path mine = folder.file("mine", "mine");
  fs::create_symlink(mine, two);
  EXPECT_FALSE(make_private_file(two)) << "a link";
  std::error_code error;
  write_atomically(file, "all of it", error);
  EXPECT_FALSE(error);
  EXPECT_EQ(file_content(file), "all of it");
  write_atomically(folder / "none/x.txt", "", error);
  EXPECT_EQ(error, std::errc::no_such_file_or_directory);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  EXPECT_EQ(fs::status(file).permissions(), static_cast<fs::perms>(0666U & ~mask));
}

// On a shared disk, the owner can be a process on another machine, with no process number here.
TEST(OutputFolder, RemovesIncompleteFilesOfEndedProcesses) {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  const std::string mine = temporary_path(folder / "x.txt").filename();
  const std::string process = std::to_string(::getpid()) + ".part",
                    over = std::to_string(child) + ".part";
  ASSERT_TRUE(mine.ends_with("." + process));
  const std::string of_the_child = mine.substr(0, mine.size() - process.size()) + over;
  folder.file(mine, "");
  folder.file(of_the_child, "");
  folder.file(".x.txt.01234567.elsewhere." + over, "");
  folder.file(".x.txt.01234567." + over, "");
  remove_orphans(folder.path());
  EXPECT_TRUE(fs::exists(folder / mine));
  EXPECT_FALSE(fs::exists(folder / of_the_child));
  EXPECT_TRUE(fs::exists(folder / (".x.txt.01234567.elsewhere." + over)));
  EXPECT_TRUE(fs::exists(folder / (".x.txt.01234567." + over)));
}

TEST(OutputFolder, WritesLongNames) {
  const TemporaryFolder folder;
  std::error_code error;
  write_atomically(folder / std::string(255, 'x'), "all", error);
  EXPECT_FALSE(error) << error.message();
}

TEST(OutputFolder, RejectsUnusableFolders) {
  const TemporaryFolder folder;
  const fs::path file = folder.file("file", "content");
  EXPECT_TRUE(contains(complaint_about(file), "is not a folder"));
  EXPECT_TRUE(contains(complaint_about(file / "below"), "is not a folder"));
  EXPECT_TRUE(contains(complaint_about(""), "is empty"));
  EXPECT_TRUE(contains(complaint_about("/proc/saltus"), "output folder '/proc/saltus' is not"));
  EXPECT_TRUE(contains(complaint_about(folder / std::string(300, 'x')), "at most 255 bytes"));
  fs::path deep = folder.path();
  for (int i = 0; i < 20; ++i) deep /= std::string(220, 'x');
  EXPECT_TRUE(contains(complaint_about(deep), "less than 4096 bytes"));
  EXPECT_EQ(file_content(file), "content");
  if (::geteuid() != 0) {  // root may write everywhere
    fs::permissions(folder.path(), fs::perms::owner_read | fs::perms::owner_exec);
    EXPECT_TRUE(contains(complaint_about(folder / "new"), "is not writable"));
    fs::permissions(folder.path(), fs::perms::owner_all);
  }
}

TEST(OutputFolder, NamesAndKeepsAFileThatCannotBeReplaced) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "taken/by_a_folder");
  const OutputFolder output(folder.path());
  expect_error<InputError>([&] { output.write("taken", std::string_view("text")); },
                           {(folder / "taken").string()});
  EXPECT_TRUE(fs::exists(folder / "taken/by_a_folder"));
  const auto files = fs::directory_iterator(folder.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST(OutputFolder, JsonWritesInfinityAsNull) {
  const TemporaryFolder folder;
  const OutputFolder output(folder.path());
  nlohmann::ordered_json summary;
  summary["recovered"] = true;
  summary["error_m"] = std::nan("");
  summary["bound"] = infinity;
  summary["name"] = "not \xff UTF-8";
  summary["third"] = 1.0 / 3.0;
  output.write("summary.json", summary);
  const auto read = nlohmann::ordered_json::parse(file_content(folder / "summary.json"));
  EXPECT_TRUE(read["error_m"].is_null());
  EXPECT_TRUE(read["bound"].is_null());
  EXPECT_EQ(read["third"].get<double>(), 1.0 / 3.0);
  EXPECT_EQ(read.begin().key(), "recovered") << "the order of the keys is kept";
}

TEST(CsvTable, NumbersReadBackExactly) {
  CsvTable table({"t", "x"});
  const std::array<double, 4> numbers{0.1, 1.0 / 3.0, 5e-324, std::numeric_limits<double>::max()};
  for (const double number : numbers) table.add_row(std::array{1.0, number});
  EXPECT_EQ(table.rows(), 4u);
  EXPECT_EQ(table.columns(), 2u);
  std::istringstream lines(table.text());
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "t,x");
  for (const double number : numbers) {
    std::getline(lines, line);
    double read = 0.0;
    const std::size_t comma = line.find(',');
    std::from_chars(line.data() + comma + 1, line.data() + line.size(), read);
    EXPECT_EQ(read, number);
  }
}

TEST(CsvTable, RejectsInvalidDefinitions) {
  EXPECT_THROW(CsvTable({}), DefinitionError);
  EXPECT_THROW(CsvTable({"a", ""}), DefinitionError);
  EXPECT_EQ(CsvTable({"a,b"}).text(), "\"a,b\"\n");
  CsvTable table({"a", "b"});
  EXPECT_THROW(table.add_row(std::array{1.0}), DefinitionError);
}

}  // namespace
}  // namespace saltus
