#include "saltus/core/data_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "saltus/core/error.hpp"
#include "tests/app/support.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;

TEST(DataFile, IsTakenFromTheNamedFolder) {
  const fs::path folder = fs::path(testing::TempDir()) / "saltus_data_file";
  fs::create_directories(folder / "some/scripts");
  std::ofstream(folder / "some/scripts/draw.py") << "\n";
  const std::string name = folder.string();
  const Variable named("SALTUS_DATA_DIR", name.c_str());
  EXPECT_EQ(data_file("some/scripts/draw.py"), folder / "some/scripts/draw.py");
  expect_error<InputError>([] { data_file("some/scripts/absent.py"); },
                           {"some/scripts/absent.py is not in " + name});
}

TEST(DataFile, IsFoundNextToABuiltProgram) {
  const Variable unnamed("SALTUS_DATA_DIR", nullptr);
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path folder = program / "share/saltus/tests_of_data_file";
  fs::create_directories(folder);
  EXPECT_EQ(data_file("tests_of_data_file"), folder);
  fs::remove_all(folder);
  EXPECT_THROW(data_file("tests_of_data_file"), InputError);
}

TEST(CacheFolder, FollowsTheXdgSpecification) {
  const std::string cache = "/cache", home = "/home/user", empty;
  const Variable with_home("HOME", home.c_str());
  {
    const Variable named("XDG_CACHE_HOME", cache.c_str());
    EXPECT_EQ(cache_folder(), "/cache/saltus");
  }
  {
    const Variable set_to_nothing("XDG_CACHE_HOME", empty.c_str());
    EXPECT_EQ(cache_folder(), "/home/user/.cache/saltus");
  }
  const Variable unnamed("XDG_CACHE_HOME", nullptr), homeless("HOME", nullptr);
  EXPECT_THROW(cache_folder(), InputError);
}

}  // namespace
}  // namespace saltus
