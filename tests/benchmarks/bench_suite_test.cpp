// Does the benchmark suite hand the same program to everybody, and say what is wrong with a
// request?
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "benchmarks/step_recovery_kernels.hpp"
#include "benchmarks/step_recovery_qp.hpp"
#include "benchmarks/suite/answer.hpp"
#include "benchmarks/suite/flat_qp.hpp"
#include "benchmarks/suite/qp_file.hpp"
#include "saltus/core/error.hpp"

namespace saltus::bench {
namespace {

constexpr double rounding = 1e-11;

void expect_same_program(const StageQp& qp, StagePoint point) {
  const auto solver = make_riccati_solver(qp);
  ASSERT_EQ(solver->solve(qp, point, /*warm=*/false).status, QpStatus::optimal);
  const SparseQp flat = flatten(qp);
  // Off the optimum, where every residual has something to say.
  for (const double off : {0.0, 0.1}) {
    for (StagePoint::AtStage& stage : point.stages) stage.u.array() += off;
    const PrimalDualPoint flat_point = flatten(qp, point);
    const StageQpResidual there = kkt_residual(qp, point);
    const SparseQpResidual here = kkt_residual(flat, flat_point);
    EXPECT_NEAR(objective(flat, flat_point.w), objective(qp, point),
                rounding * (1.0 + std::abs(objective(qp, point))));
    EXPECT_NEAR(here.stationarity, there.stationarity, rounding * (1.0 + there.stationarity));
    EXPECT_NEAR(here.feasibility, there.feasibility, rounding * (1.0 + there.feasibility));
    EXPECT_NEAR(here.complementarity, there.complementarity,
                rounding * (1.0 + there.complementarity));
  }
}

TEST(FlatQp, HasTheCostAndTheResidualsOfTheStages) {
  for (const int landing : {0, 7, 100}) {
    const StageQp qp = step_recovery_qp({15, landing}, random_start(3));
    expect_same_program(qp, standing_guess(qp));
  }
}

TEST(FlatQp, FindsTheStagesAgain) {
  const StageQp qp = step_recovery_qp({15, 7}, random_start(3));
  const SparseQp flat = flatten(qp);
  const SparseQp again = flatten(in_stages(flat, stage_sizes(qp)));
  EXPECT_EQ(again.hessian_pattern, flat.hessian_pattern);
  EXPECT_EQ(again.row_pattern, flat.row_pattern);
  EXPECT_EQ(again.hessian, flat.hessian);
  EXPECT_EQ(again.rows, flat.rows);
  EXPECT_EQ(again.gradient, flat.gradient);
  EXPECT_EQ(again.constant, flat.constant);
  EXPECT_EQ(again.lower, flat.lower);
  EXPECT_EQ(again.upper, flat.upper);
  EXPECT_EQ(again.row_lower, flat.row_lower);
  EXPECT_EQ(again.row_upper, flat.row_upper);
  std::vector<StageSizes> sizes = stage_sizes(qp);
  std::swap(sizes[6], sizes[7]);
  EXPECT_THROW(in_stages(flat, sizes), DefinitionError);
}

TEST(FlatQp, RefusesSoftRows) {
  StageQp qp = step_recovery_qp({3, 0}, nominal_start());
  qp.stages[1].groups[0].soft = true;
  EXPECT_THROW(flatten(qp), DefinitionError);
}

TEST(QpFile, IsReadAsItWasWritten) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("saltus_qp_" + std::to_string(::getpid()) + ".json");
  Answerer answerer;
  const auto written = answerer.answer(
      {{"do", "export"}, {"problem", "recipe/kI=7"}, {"instance", 2}, {"file", file.string()}});
  ASSERT_TRUE(written.contains("written")) << written.dump();
  const SparseQp there = flatten(step_recovery_qp({15, 7}, random_start(2)));
  const SparseQp here = read_program(file).flat;
  EXPECT_EQ(here.hessian_pattern, there.hessian_pattern);
  EXPECT_EQ(here.row_pattern, there.row_pattern);
  EXPECT_EQ(here.hessian, there.hessian);
  EXPECT_EQ(here.rows, there.rows);
  EXPECT_EQ(here.row_upper, there.row_upper);
  EXPECT_EQ(here.lower, there.lower);
  nlohmann::json request{{"do", "solve"},
                         {"file", file.string()},
                         {"solver", "sparse"},
                         {"start", "cold"},
                         {"tolerance", 1e-8}};
  EXPECT_TRUE(answerer.answer(request).at("solved"));
  request["solver"] = "riccati";
  EXPECT_TRUE(answerer.answer(request).at("solved"));
  for (const char* text : {"", "3", "{}", R"({"format": "saltus-qp 2"})",
                           R"({"format": "saltus-qp 1", "variables": 1, "rows": 0})"}) {
    std::ofstream(file) << text;
    EXPECT_THROW(read_program(file), InputError) << text;
  }
  std::filesystem::remove(file);
}

TEST(Answerer, SaysWhatIsWrongWithARequest) {
  Answerer answerer;
  const auto error_of = [&](const nlohmann::json& request) {
    return answerer.answer(request).value("error", std::string());
  };
  EXPECT_NE(error_of({{"do", "solve"}, {"problem", "recipe/kI=77"}, {"instance", 1}})
                .find("did you mean 'recipe/kI=7'"),
            std::string::npos);
  nlohmann::json request{{"do", "solve"},       {"problem", "sequence"}, {"instance", 60},
                         {"solver", "riccati"}, {"start", "warm"},       {"tolerance", 1e-8}};
  EXPECT_NE(error_of(request).find("no instance 60"), std::string::npos);
  request["instance"] = 59;
  EXPECT_EQ(error_of(request), "");
  request["start"] = "hot";
  EXPECT_NE(error_of(request), "");
  for (const nlohmann::json& wrong :
       {nlohmann::json(3), nlohmann::json::object(), nlohmann::json{{"do", "dance"}},
        nlohmann::json{{"do", "solve"}}, nlohmann::json(nlohmann::json::value_t::discarded)})
    EXPECT_NE(error_of(wrong), "");
}

}  // namespace
}  // namespace saltus::bench
