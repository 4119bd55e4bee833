// Search for the model of iCub. The first run in CI tests the download, which needs the
// network.
#include "saltus/robots/icub/icub.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "saltus/core/error.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

namespace fs = std::filesystem;

class IcubModel : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"SALTUS_ICUB_URDF", "XDG_CACHE_HOME"}) {
      const char* value = std::getenv(name);
      before_.emplace_back(name, value == nullptr ? "" : value);
    }
    fs::remove_all(cache_);
    setenv("XDG_CACHE_HOME", cache_.c_str(), 1);
    unsetenv("SALTUS_ICUB_URDF");
  }
  void TearDown() override {
    for (const auto& [name, value] : before_)
      value.empty() ? unsetenv(name.c_str()) : setenv(name.c_str(), value.c_str(), 1);
    fs::remove_all(cache_);
  }

  // Tests run at the same time, each in its own process.
  fs::path cache_ =
      fs::path(testing::TempDir()) / ("saltus_icub_model_" + std::to_string(getpid()));

 private:
  std::vector<std::pair<std::string, std::string>> before_;
};

TEST_F(IcubModel, IsTakenFromTheVariable) {
  fs::create_directories(cache_);
  const fs::path urdf = cache_ / "mine.urdf";
  std::ofstream(urdf) << "<robot/>\n";
  setenv("SALTUS_ICUB_URDF", urdf.c_str(), 1);
  EXPECT_EQ(robots::find_icub_urdf(), urdf);
}

TEST_F(IcubModel, MissingNamedModelIsAnError) {
  setenv("SALTUS_ICUB_URDF", "/nowhere/model.urdf", 1);
  EXPECT_EQ(robots::find_icub_urdf(), std::nullopt);
  EXPECT_THROW(robots::fetch_icub_urdf([](const std::string& line) { ADD_FAILURE() << line; }),
               InputError);
}

TEST_F(IcubModel, IsTakenFromTheCacheSilently) {
  EXPECT_EQ(robots::find_icub_urdf(), std::nullopt);
  const fs::path urdf =
      cache_ / "saltus/icub-models-3.2.0/share/iCub/robots/iCubGazeboV2_5/model.urdf";
  fs::create_directories(urdf.parent_path());
  std::ofstream(urdf) << "<robot/>\n";
  EXPECT_EQ(robots::find_icub_urdf(), urdf);
  EXPECT_EQ(robots::fetch_icub_urdf([](const std::string& line) { ADD_FAILURE() << line; }), urdf);
}

// A failed download gives one sentence with a remedy.
TEST_F(IcubModel, MissingScriptOrNetworkGivesOneSentence) {
  fs::create_directories(cache_ / "robots/icub");
  const fs::path script = cache_ / "robots/icub/fetch_icub_model";
  std::ofstream(script) << "#!/bin/sh\nexit 1\n";
  fs::permissions(script, fs::perms::owner_all);
  setenv("SALTUS_DATA_DIR", cache_.c_str(), 1);
  std::string said;
  const std::string sentence = error_of<InputError>(
      [&] { robots::fetch_icub_urdf([&](const std::string& line) { said += line; }); });
  unsetenv("SALTUS_DATA_DIR");
  EXPECT_NE(said.find("CC BY-SA 4.0"), std::string::npos) << said;
  EXPECT_NE(sentence.find("--robot.urdf"), std::string::npos) << sentence;
}

}  // namespace
}  // namespace saltus
