// Tests that the benchmark suite gives every solver the same program and explains invalid requests.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/step_recovery_kernels.hpp"
#include "benchmarks/step_recovery_qp.hpp"
#include "benchmarks/suite/answer.hpp"
#include "benchmarks/suite/flat_qp.hpp"
#include "benchmarks/suite/nonlinear_file.hpp"
#include "benchmarks/suite/nonlinear_problems.hpp"
#include "benchmarks/suite/qp_file.hpp"
#include "benchmarks/suite/qp_problems.hpp"
#include "benchmarks/suite/shooting_steps.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "tests/support/errors.hpp"

namespace saltus::bench {
namespace {

constexpr double rounding = 1e-11;

void expect_same_program(const qp::StageQp& qp, qp::StagePoint point) {
  const auto solver = qp::make_riccati_solver(qp);
  ASSERT_EQ(solver->solve(qp, point, /*warm=*/false).status, qp::QpStatus::optimal);
  const qp::SparseQp flat = flatten(qp);
  // A point away from the optimum, so that every residual is nonzero.
  for (const double off : {0.0, 0.1}) {
    for (qp::StagePoint::AtStage& stage : point.stages) stage.u.array() += off;
    const PrimalDualPoint flat_point = flatten(qp, point);
    const qp::StageQp::Residual there = kkt_residual(qp, point);
    const qp::SparseQp::Residual here = kkt_residual(flat, flat_point);
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
    const qp::StageQp qp = step_recovery_qp({15, landing}, random_start(3));
    expect_same_program(qp, standing_guess(qp));
  }
}

TEST(FlatQp, RecoversTheStages) {
  const qp::StageQp qp = step_recovery_qp({15, 7}, random_start(3));
  const qp::SparseQp flat = flatten(qp);
  const qp::SparseQp again = flatten(in_stages(flat, stage_sizes(qp)));
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

TEST(FlatQp, PointsRoundTripAndRollOut) {
  const std::vector<QpProblem> problems = qp_problems();
  for (const char* name : {"sequence", "steps/chain", "steps/car"}) {
    const QpInstance instance = find_problem(problems, name).instance(5);
    const qp::StageQp& qp = *instance.stages;
    const PrimalDualPoint again = flatten(qp, in_stages(qp, *instance.warm));
    EXPECT_EQ(again.w, instance.warm->w) << name;
    EXPECT_EQ(again.lambda, instance.warm->lambda) << name;
    EXPECT_EQ(again.z, instance.warm->z) << name;
    const VectorXd w = rolled_out(qp, instance.warm->w);
    VectorXd rows = VectorXd::Zero(instance.flat.row_pattern.rows());
    instance.flat.row_pattern.for_each(
        [&](int i, int j, int e) { rows[i] += instance.flat.rows[e] * w[j]; });
    for (int i = 0; i < rows.size(); ++i) {
      if (instance.flat.row_lower[i] != instance.flat.row_upper[i]) continue;
      EXPECT_NEAR(rows[i], instance.flat.row_lower[i], rounding * (1.0 + rows.norm())) << name;
    }
  }
}

// The starts in a file are used, and they save iterations.
TEST(Answerer, OffersTheStartsOfAFile) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("saltus_starts_" + std::to_string(::getpid()) + ".json");
  Answerer answerer;
  answerer.answer(
      {{"do", "export"}, {"problem", "sequence"}, {"instance", 5}, {"file", file.string()}});
  for (const char* solver : {"riccati-generic", "sparse"}) {
    const auto iterations = [&](const char* start) {
      const auto answer = answerer.answer({{"do", "solve"},
                                           {"file", file.string()},
                                           {"solver", solver},
                                           {"start", start},
                                           {"tolerance", 1e-8}});
      EXPECT_TRUE(answer.value("solved", false)) << answer.dump();
      for (const char* time : {"setup_us", "first_us", "wall_us", "cpu_us"})
        EXPECT_GT(answer.at("times").at(time).get<double>(), 0.0) << time;
      return answer.at("iterations").get<int>();
    };
    EXPECT_LT(iterations("warm"), iterations("own start")) << solver;
    EXPECT_GT(iterations("guess"), 0);
    EXPECT_GT(iterations("guess rolled out"), 0);
  }
  std::filesystem::remove(file);
}

TEST(FlatQp, RejectsSoftRows) {
  qp::StageQp qp = step_recovery_qp({3, 0}, nominal_start());
  qp.stages[1].groups[0].soft = true;
  EXPECT_THROW(flatten(qp), DefinitionError);
}

// Bounds are active (for the chain only at first), and the plan of the previous tick is a warm
// start that saves iterations.
TEST(ClosedLoops, AreSolvedColdAndWarm) {
  for (const auto& [name, late] : {std::pair("steps/chain", 30), std::pair("steps/car", 80)}) {
    const std::vector<QpProblem> problems = qp_problems();
    const QpProblem& problem = find_problem(problems, name);
    int cold = 0, warm = 0;
    for (const int number : {1, late / 2, late}) {
      const QpInstance instance = problem.instance(number);
      const qp::StageQp& qp = *instance.stages;
      const auto solver = qp::make_riccati_solver(qp, {}, problem.kernels);
      qp::StagePoint point(qp), from_warm = in_stages(qp, *instance.warm);
      const qp::QpResult result = solver->solve(qp, point, /*warm=*/false);
      cold += result.iterations;
      warm += solver->solve(qp, from_warm, /*warm=*/true).iterations;
      EXPECT_LE(kkt_residual(qp, point).largest(), 1e-8) << name << number;
      EXPECT_LE(kkt_residual(qp, from_warm).largest(), 1e-8) << name << number;
      double pushed = 0.0;
      for (const qp::StagePoint::AtStage& stage : point.stages)
        if (stage.u_bound.size() > 0)
          pushed = std::max(pushed, stage.u_bound.cwiseAbs().maxCoeff());
      EXPECT_EQ(pushed > 1e-4, number == 1 || name == std::string("steps/car")) << name << number;
    }
    EXPECT_LT(warm, cold) << name;
  }
}

TEST(QpFile, RoundTripsAndRejectsInvalidFiles) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("saltus_qp_" + std::to_string(::getpid()) + ".json");
  Answerer answerer;
  const auto written = answerer.answer(
      {{"do", "export"}, {"problem", "recipe/kI=7"}, {"instance", 2}, {"file", file.string()}});
  ASSERT_TRUE(written.contains("written")) << written.dump();
  const qp::SparseQp there = flatten(step_recovery_qp({15, 7}, random_start(2)));
  const qp::SparseQp here = read_program(file).flat;
  EXPECT_EQ(here.hessian_pattern, there.hessian_pattern);
  EXPECT_EQ(here.row_pattern, there.row_pattern);
  EXPECT_EQ(here.hessian, there.hessian);
  EXPECT_EQ(here.rows, there.rows);
  EXPECT_EQ(here.row_upper, there.row_upper);
  EXPECT_EQ(here.lower, there.lower);
  nlohmann::json request{{"do", "solve"},
                         {"file", file.string()},
                         {"solver", "sparse"},
                         {"start", "own start"},
                         {"tolerance", 1e-8}};
  EXPECT_TRUE(answerer.answer(request).at("solved"));
  request["solver"] = "riccati-generic";
  EXPECT_TRUE(answerer.answer(request).at("solved"));
  // No kernels are compiled for the sizes of a file.
  request["solver"] = "riccati";
  EXPECT_TRUE(answerer.answer(request).contains("not_applicable"));
  for (const char* text : {"", "3", "{}", R"({"format": "saltus-qp 2"})",
                           R"({"format": "saltus-qp 1", "variables": 1, "rows": 0})"}) {
    std::ofstream(file) << text;
    EXPECT_THROW(read_program(file), InputError) << text;
  }
  std::filesystem::remove(file);
}

// Derivatives of recorded steps, and of steps that are not recorded (max), against differences.
TEST(NonlinearFile, FunctionsHaveTheDerivativesOfTheirSteps) {
  for (const Operation last : {Operation::multiply, Operation::max, Operation::pow}) {
    FormulaSteps steps;
    steps.inputs = 2;
    const int x = steps.add_input(0), y = steps.add_input(1);
    const int sine = steps.add(Operation::sin, x), product = steps.add(Operation::multiply, x, y);
    steps.outputs = {steps.add(last, product, y), steps.add(Operation::divide, sine, y)};
    const Function f = function_of(steps);
    const Eigen::Vector2d z(1.3, 0.7), weights(0.4, -1.1);
    const MatrixXd jacobian = f.dense_jacobian(z), hessian = f.dense_hessian(z, weights);
    constexpr double h = 1e-6;  // exact to h^2 and 1e-16 / h
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d step = h * Eigen::Vector2d::Unit(i), up = z + step, down = z - step;
      EXPECT_LE((jacobian.col(i) - (f(up) - f(down)) / (2.0 * h)).norm(), 1e-8) << name_of(last);
      const VectorXd change = (f.dense_jacobian(up) - f.dense_jacobian(down)).transpose() * weights;
      EXPECT_LE((hessian.col(i) - change / (2.0 * h)).norm(), 1e-8) << name_of(last);
    }
  }
}

TEST(Answerer, RejectsInvalidRequests) {
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

// A problem with free durations, path constraints, two phases, a jump and an input cost.
constexpr std::array shooting_cases{"library/bryson_denham", "library/juggled_ball",
                                    "library/three_modes", "library/turbo_car",
                                    "library/low_ceiling_arcs"};

TEST(ShootingFile, StepsMatchTheProgram) {
  for (const char* name : shooting_cases) {
    NonlinearProblem problem(nonlinear_case(name));
    ShootingProgram& program = problem.shooting().editable_program();
    const VectorXd start = problem.shooting().initial_guess().w;
    const ShootingSteps steps =
        shooting_steps(program, *problem.reference().options.integrator, start);
    Random random(7);
    const VectorXd w = start + 0.02 * random.vector(program.variables());
    double expected = 0.0, objective = 0.0;
    VectorXd expected_rows(program.rows()), rows = VectorXd::Zero(program.rows());
    ASSERT_TRUE(program.objective(w.data(), expected));
    ASSERT_TRUE(program.constraints(w.data(), expected_rows.data()));
    program.for_each_linear([&](int row, int v, double c) { rows[row] += c * w[v]; });
    for (int v = 0; v < program.variables(); ++v) objective += program.variable_cost(v, w[v]);
    for (std::size_t b = 0; b < program.blocks().size(); ++b) {
      if (steps.function_of[b] < 0) continue;
      const Block& block = program.blocks()[b];
      std::vector<double> z(block.constants.begin(), block.constants.end());
      for (std::size_t i = 0; i < z.size(); ++i)
        for (const VariableCoefficient& c : block.coefficients[i]) z[i] += c.factor * w[c.variable];
      const std::vector<double> y = steps.functions[steps.function_of[b]].evaluate(z);
      for (std::size_t o = 0; o < y.size(); ++o)
        (block.outputs[o].row < 0 ? objective : rows[block.outputs[o].row]) +=
            block.outputs[o].factor * y[o];
    }
    EXPECT_NEAR(objective, expected, rounding * (1.0 + std::abs(expected))) << name;
    EXPECT_LT((rows - expected_rows).cwiseAbs().maxCoeff(), rounding) << name;
  }
}

TEST(ShootingFile, ReportsProgramsWithoutSteps) {
  for (const auto& [name, why] : {std::pair("library/switch_of_speed", "events"),
                                  std::pair("library/calcium_oscillation", "no fixed explicit")}) {
    NonlinearProblem problem(nonlinear_case(name));
    expect_error<DefinitionError>([&] { problem.file(); }, {why});
  }
}

TEST(Answerer, JudgesNonlinearPoints) {
  Answerer answerer;
  const std::string name = "library/brachistochrone";
  NonlinearProblem problem(nonlinear_case(name));
  NlpPoint point = problem.solve(SolverChoice::sparse, 1e-10).result.point;
  const auto residual = [&] {
    nlohmann::json request{{"do", "judge"}, {"problem", name}};
    request["w"] = std::vector<double>(point.w.begin(), point.w.end());
    request["lambda"] = std::vector<double>(point.lambda.begin(), point.lambda.end());
    request["z"] = std::vector<double>(point.z.begin(), point.z.end());
    double worst = 0.0;
    const auto answer = answerer.answer(request);
    for (const auto& [key, value] : answer.at("kkt").items())
      worst = std::max(worst, value.is_null() ? infinity : value.get<double>());
    return worst;
  };
  EXPECT_LT(residual(), 1e-9);
  point.w[3] += 1e-3;
  EXPECT_GT(residual(), 1e-5);
  point.w.conservativeResize(4);
  EXPECT_EQ(residual(), infinity);
}

}  // namespace
}  // namespace saltus::bench
