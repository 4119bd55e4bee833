// Projects from templates are created completely or not at all, and their names are valid in CMake.
// The test packaging.new checks that they build and run.
#include "saltus/app/new_project.hpp"

#include <gtest/gtest.h>

#include "tests/app/support.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;

TEST(NewProject, IsCompleteWithoutPlaceholders) {
  const TemporaryFolder folder;
  for (const ProjectKind& kind : project_kinds()) {
    const fs::path project = folder / kind.name;
    make_project(project, kind);
    for (const char* file : {"CMakeLists.txt", "README.md", ".clang-format", "main.cpp", "plot.py",
                             "problem.cpp", "problem.hpp", "scene.json", "test.cpp"}) {
      const std::string text = file_content(project / file);
      EXPECT_FALSE(text.empty()) << file;
      for (const char* mark : {"@NAME@", "@VERSION@", "@SUMMARY@"})
        EXPECT_EQ(text.find(mark), std::string::npos) << file << " of " << kind.name;
    }
    EXPECT_TRUE(contains(file_content(project / "CMakeLists.txt"), "project(" + kind.name));
    EXPECT_TRUE(contains(file_content(project / "README.md"), kind.summary));
  }
  std::size_t entries = 0;  // no partial files next to them
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder.path())) ++entries;
  EXPECT_EQ(entries, project_kinds().size());
}

TEST(NewProject, RejectsInvalidNamesAndExistingFolders) {
  const TemporaryFolder folder;
  const ProjectKind& kind = project_kinds().front();
  const auto complaint = [&](const std::string& name) {
    const fs::path project = folder / name;
    return complaint_of([&] { make_project(project, kind); });
  };
  for (const char* name : {"2fast", "a b", "über", "a.b", "-x", "_x"})
    EXPECT_TRUE(contains(complaint(name), "is not a valid project name: expected a letter"));
  EXPECT_TRUE(contains(complaint("test"), "'test' is not a valid project name: CMake"));
  EXPECT_TRUE(contains(complaint(std::string(65, 'a')), "at most 64 characters"));
  EXPECT_TRUE(
      contains(complaint("no/such/folder"), "cannot be created: No such file or directory"));
  EXPECT_EQ(complaint("cart/"), "no complaint");
  EXPECT_TRUE(contains(complaint("cart"), "exists already; nothing was changed"));
  folder.file("taken", "mine");
  EXPECT_TRUE(contains(complaint("taken"), "exists already; nothing was changed"));
  EXPECT_EQ(file_content(folder / "taken"), "mine");
}

TEST(NewProject, UnknownKindListsTheKinds) {
  const TemporaryFolder folder;
  const std::vector<std::string> words{(folder / "cart").string(), "--kind", "switchd"};
  const std::string complaint = complaint_of([&] { (void)new_verb().run(words); });
  EXPECT_TRUE(
      contains(complaint, "'kind' must be trajectory, controller or switched, not 'switchd'"))
      << complaint;
  EXPECT_TRUE(contains(complaint, "did you mean 'switched'?")) << complaint;
  EXPECT_FALSE(fs::exists(folder / "cart"));
}

}  // namespace
}  // namespace saltus
