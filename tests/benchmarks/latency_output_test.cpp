// Tests the error messages and the JSON output of `saltus bench latency`.
#include "benchmarks/latency_output.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "saltus/core/error.hpp"
#include "tests/support/errors.hpp"

namespace saltus::bench {
namespace {

LatencyRequest parse(std::vector<std::string> arguments) {
  return parse_latency_request(arguments);
}
ExitStatus run(std::vector<std::string> arguments) { return verb().run(arguments); }

TEST(LatencyCommandLine, AcceptsBothFormsOfFlags) {
  const LatencyRequest request = parse({"--quick", "--json", "a.json", "--only=box"});
  EXPECT_EQ(request.selection.solves, 100);
  EXPECT_EQ(request.selection.only, "box");
  EXPECT_EQ(request.json, std::filesystem::path("a.json"));
  EXPECT_GE(parse({}).selection.solves, 1000);
}

TEST(LatencyCommandLine, RejectsUnknownArguments) {
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"--quik"},
                                                {"--json"},
                                                {"--only"},
                                                {"--json", "--quick"},
                                                {"file"},
                                                {"--quick", "--quick"},
                                                {"--quick=yes"},
                                                {"--json="}})
    EXPECT_THROW(parse(wrong), InputError) << wrong.front();
  EXPECT_THROW(run({}), InputError);
  EXPECT_THROW(run({"latencies"}), InputError);
  EXPECT_THROW(run({"latency", "--json", "/"}), InputError);
  EXPECT_THROW(run({"latency", "--json", "/proc/no/such.json"}), InputError);
  expect_error<InputError>([] { parse({"--quik"}); }, {"--quick"});
}

TEST(LatencyCommandLine, WritesJsonWithEveryField) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("saltus_latency_" + std::to_string(::getpid()));
  const std::filesystem::path file = folder / "latency.json";
  EXPECT_EQ(run({"latency", "--quick", "--only", "recipe/no-impact", "--json", file.string()}),
            ExitStatus::ok);
  std::ifstream stream(file);
  const nlohmann::json json = nlohmann::json::parse(stream);
  std::filesystem::remove_all(folder);
  EXPECT_FALSE(json.at("machine").at("cpu").get<std::string>().empty());
  EXPECT_GE(json.at("machine").at("lanes").get<int>(), 2);
  for (const char* key : {"compiler", "march", "type", "version"})
    EXPECT_TRUE(json.at("build").at(key).is_string()) << key;
  EXPECT_GT(json.at("calibration_us").get<double>(), 0.0);
  ASSERT_EQ(json.at("cases").size(), 1u);
  const nlohmann::json& result = json.at("cases")[0];
  EXPECT_EQ(result.at("name"), "recipe/no-impact");
  EXPECT_EQ(result.at("n"), 100);
  EXPECT_EQ(result.at("failures"), 0);
  for (const char* key : {"median_us", "p99_us", "max_us", "iterations_mean", "iterations_max",
                          "kkt_max", "relative_to_calibration"})
    EXPECT_GT(result.at(key).get<double>(), 0.0) << key;
}

TEST(LatencyOutput, FailuresNameTheirSeed) {
  LatencyReport report;
  report.calibration_us = 1.0;
  report.cases.emplace_back().name = "case";
  report.cases[0].failures.push_back({42, qp::QpStatus::iteration_limit, 0.5});
  EXPECT_NE(closing_text(report).find("case seed 42"), std::string::npos);
  EXPECT_EQ(to_json(report).at("cases")[0].at("failed")[0].at("seed"), 42);
}

}  // namespace
}  // namespace saltus::bench
