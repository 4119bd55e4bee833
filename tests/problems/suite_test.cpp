// The suite distinguishes right from wrong results and gives the reason.
#include "problems/suite/suite.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "problems/library/c01_mpc_qps.hpp"
#include "problems/library/catalogue.hpp"
#include "problems/library/quadratic_program.hpp"
#include "problems/suite/suite_output.hpp"
#include "saltus/core/error.hpp"
#include "tests/app/support.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus {
namespace {

SuiteCase made_up(const std::string& id, Verdict verdict, std::vector<CheckedValue> checked) {
  return {id, id + "_name", [=](SolverChoice) {
            CaseOutcome outcome;
            outcome.exercises = "the suite";
            outcome.verdict = verdict == Verdict::met ? judge(checked) : verdict;
            outcome.status = "as made up";
            outcome.checked = checked;
            outcome.iterations = 12;
            outcome.seconds = 0.25;
            return outcome;
          }};
}

const CheckedValue right{"cost", 4.0000004, 4.0, 1e-6, 8};
const CheckedValue wrong{"x(3)[0]", 0.5, 0.25, 1e-3, 2};

std::vector<SuiteCase> one_wrong() {
  return {made_up("X01", Verdict::met, {right}), made_up("X02", Verdict::met, {right, wrong}),
          made_up("X03", Verdict::skipped, {})};
}

SuiteRequest parse(const std::vector<std::string>& arguments) {
  return parse_suite_request(arguments);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(CheckedValues, CountsAgreeingDigits) {
  const auto reached = [](double value, double reference, int digits) {
    return CheckedValue{"", value, reference, 0.0, digits}.digits_reached();
  };
  EXPECT_EQ(reached(3.14159, 3.14159, 6), 6);
  EXPECT_EQ(reached(3.1415926, 3.14159, 6), 6);  // the reference is rounded
  EXPECT_EQ(reached(3.1412, 3.14159, 6), 4);     // 3.141|6
  EXPECT_EQ(reached(3.9997, 4.0, 16), 4);
  EXPECT_EQ(reached(4.1, 3.1, 6), 0);
  EXPECT_EQ(reached(-8.928e-4, -8.92809e-4, 6), 4);
  EXPECT_EQ(reached(std::nan(""), 1.0, 6), 0);
  EXPECT_EQ(reached(1e-9, 0.0, 16), 9);  // decimals
}

TEST(CheckedValues, NanNeverPasses) {
  const CheckedValue v{"x", std::nan(""), 1.0, 1e3, 6};
  EXPECT_FALSE(v.is_met());
  EXPECT_EQ(judge({right, v}), Verdict::missed);
  EXPECT_EQ(judge({}), Verdict::missed);
  std::vector<CheckedValue> values{right, v, wrong};
  bring_worst_to_front(values);
  EXPECT_TRUE(std::isnan(values.front().value));
}

TEST(SuiteCommandLine, AcceptsBothFormsOfFlags) {
  const SuiteRequest request =
      parse({"--only", "bryson", "--set", "solver=sparse", "--json=a.json"});
  EXPECT_EQ(request.only, "bryson");
  EXPECT_EQ(request.solver, SolverChoice::sparse);
  EXPECT_EQ(request.json, std::filesystem::path("a.json"));
  EXPECT_EQ(parse({}).solver, SolverChoice::ipopt);
  EXPECT_EQ(parse({"--set=solver=riccati"}).solver, SolverChoice::riccati);
}

TEST(SuiteCommandLine, ReportsMistakes) {
  const auto complaint = [](std::vector<std::string> words) {
    return complaint_of([&] { parse(words); });
  };
  EXPECT_TRUE(contains(complaint({"--onli", "B"}), "did you mean '--only'"));
  EXPECT_TRUE(contains(complaint({"B01"}), "usage: suite"));
  EXPECT_TRUE(contains(complaint({"--only"}), "--only needs a value"));
  EXPECT_TRUE(contains(complaint({"--only", "a", "--only", "b"}), "given twice"));
  EXPECT_TRUE(contains(complaint({"--set", "solver=ipop"}), "did you mean 'ipopt'"));
  EXPECT_TRUE(contains(complaint({"--set", "solvr=ipopt"}), "did you mean 'solver'"));
  EXPECT_TRUE(contains(complaint({"--set", "solver"}), "KEY=VALUE"));
  EXPECT_TRUE(contains(complaint({"--json", "--only"}), "--json needs a value"));
  EXPECT_TRUE(contains(complaint_of([] {
                         suite_verb(one_wrong).run(std::vector<std::string>{"--json", "/"});
                       }),
                       "--json needs a file"));
}

TEST(Suite, PatternsMatchIdsAndNamesInAnyCase) {
  const auto count = [](const std::string& pattern) {
    return run_suite(one_wrong(), {.only = pattern, .json = {}}).outcomes.size();
  };
  EXPECT_EQ(count(""), 3u);
  EXPECT_EQ(count("x0"), 3u);
  EXPECT_EQ(count("X02_n"), 1u);
  const std::vector<SuiteCase> all = suite_cases();
  EXPECT_TRUE(contains(complaint_of([&] { run_suite(all, {.only = "brison", .json = {}}); }),
                       "did you mean 'bryson'"));
  EXPECT_TRUE(contains(complaint_of([&] { run_suite(all, {.only = "E99", .json = {}}); }), "E99"));
}

TEST(Suite, ReportsACaseOutsideItsTolerance) {
  int seen = 0;
  const SuiteReport report =
      run_suite(one_wrong(), {.only = "", .json = {}}, [&](const CaseOutcome&) { ++seen; });
  EXPECT_EQ(seen, 3);
  EXPECT_EQ(report.exit_status(), ExitStatus::solver_failed);
  const std::string text = closing_text(report);
  EXPECT_TRUE(
      contains(text, "X02 X02_name MISSED: x(3)[0] is 0.5 instead of 0.25: the error is 2.5e-01"))
      << text;
  EXPECT_FALSE(contains(text, "X01")) << text;
  EXPECT_TRUE(contains(text, "1 of 2 within tolerance with solver=ipopt, 1 skipped")) << text;
}

TEST(Suite, SeveralMissesGiveOneSentence) {
  CheckedValue residual = residual_of("KKT residual", 0.5, 1e-8);
  const std::vector<SuiteCase> cases{made_up("X04", Verdict::met, {right, wrong, residual, wrong})};
  const SuiteReport report = run_suite(cases, {.only = "", .json = {}});
  EXPECT_EQ(report.outcomes[0].reasons().size(), 3u);
  const std::string text = closing_text(report);
  EXPECT_TRUE(contains(text, "is allowed; also outside: KKT residual and x(3)[0]\n")) << text;
}

TEST(Suite, SkippedCasesAreNotFailures) {
  const SuiteReport report = run_suite(one_wrong(), {.only = "X03", .json = {}});
  EXPECT_EQ(report.exit_status(), ExitStatus::ok);
  EXPECT_TRUE(contains(closing_text(report), "0 of 0 within tolerance"));
}

TEST(Suite, ThrowingCaseFailsAndOthersContinue) {
  std::vector<SuiteCase> cases = one_wrong();
  cases[0].run = [](SolverChoice) -> CaseOutcome { throw std::runtime_error("no such thing"); };
  const SuiteReport report = run_suite(cases, {.only = "", .json = {}});
  ASSERT_EQ(report.outcomes.size(), 3u);
  EXPECT_EQ(report.outcomes[0].verdict, Verdict::failed);
  EXPECT_TRUE(contains(closing_text(report), "X01 X01_name FAILED: no such thing"));
}

TEST(Suite, LinesAlignWithTheirHeader) {
  const std::string head = table_head();
  const CaseOutcome outcome = run_suite(one_wrong(), {.only = "X01", .json = {}}).outcomes[0];
  const std::string line = table_line(outcome);
  EXPECT_TRUE(contains(line, "X01 X01_name")) << line;
  EXPECT_TRUE(contains(line, "4.0000004")) << line;
  EXPECT_TRUE(contains(line, "1.0e-07")) << line;
  EXPECT_TRUE(contains(line, "7/8")) << line;
  EXPECT_TRUE(contains(line, "0.250")) << line;
  EXPECT_EQ(head.find("exercises"), line.find("the suite")) << head << line;
  EXPECT_EQ(head.find("status"), line.find("ok")) << head << line;
}

TEST(Suite, WritesCompleteJson) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("saltus_suite_" + std::to_string(::getpid()));
  const std::filesystem::path file = folder / "suite.json";
  EXPECT_EQ(suite_verb(one_wrong).run(std::vector<std::string>{"--json", file.string()}),
            ExitStatus::solver_failed);
  std::ifstream stream(file);
  const nlohmann::json json = nlohmann::json::parse(stream);
  std::filesystem::remove_all(folder);
  EXPECT_EQ(json.at("solver"), "ipopt");
  EXPECT_EQ(json.at("within_tolerance"), 1);
  EXPECT_EQ(json.at("missed"), 1);
  EXPECT_EQ(json.at("skipped"), 1);
  ASSERT_EQ(json.at("cases").size(), 3u);
  const nlohmann::json& missed = json.at("cases")[1];
  EXPECT_EQ(missed.at("id"), "X02");
  EXPECT_EQ(missed.at("verdict"), "MISSED");
  EXPECT_EQ(missed.at("iterations"), 12);
  EXPECT_TRUE(missed.at("between_nodes").is_null());
  ASSERT_EQ(missed.at("checked").size(), 2u);
  EXPECT_EQ(missed.at("checked")[0].at("value").get<double>(), 4.0000004);  // every digit
  EXPECT_EQ(missed.at("checked")[0].at("digits_reached"), 7);
  EXPECT_EQ(missed.at("checked")[1].at("met"), false);
  EXPECT_EQ(missed.at("reasons").size(), 1u);
}

// End to end, with a real case whose reference is wrong in the seventh digit.
TEST(Suite, FindsAWrongReference) {
  ReferenceCase c = reference_case("B22");
  c.optimum *= 1.0 + 1e-5;
  const CaseOutcome outcome = run_case(c);
  EXPECT_EQ(outcome.verdict, Verdict::missed);
  ASSERT_EQ(outcome.reasons().size(), 1u);
  EXPECT_TRUE(contains(outcome.reasons()[0], "cost is 0.9205"));
}

TEST(Suite, EveryChoiceOfSolverSolvesALinearQuadraticCase) {
  for (const SolverChoice solver :
       {SolverChoice::ipopt, SolverChoice::sparse, SolverChoice::riccati}) {
    const CaseOutcome outcome = run_case(reference_case("C02"), solver);
    EXPECT_EQ(outcome.verdict, Verdict::met) << name_of(solver);
    for (const std::string& reason : outcome.reasons()) ADD_FAILURE() << reason;
  }
}

// Our own solvers may find a cheaper optimum of the nodal program that rises above the ceiling
// between the nodes. Refining the grid there then gives a valid plan.
TEST(Suite, RefinesAPlanThatViolatesAPathConstraintBetweenNodes) {
  for (const char* id : {"B01", "B02c"})
    for (const SolverChoice solver :
         {SolverChoice::ipopt, SolverChoice::sparse, SolverChoice::riccati}) {
      const CaseOutcome outcome = run_case(reference_case(id), solver);
      EXPECT_EQ(outcome.verdict, Verdict::met) << id << ' ' << name_of(solver);
      for (const std::string& reason : outcome.reasons()) ADD_FAILURE() << reason;
      EXPECT_EQ(contains(table_line(outcome), "refined"), outcome.refinements > 0);
    }
}

// In a plain barrier method, multipliers of nearly dependent rows grow to 1e14.
TEST(Suite, NativeSolversFindTheRocketOrbit) {
  for (const SolverChoice solver : {SolverChoice::sparse, SolverChoice::riccati}) {
    const CaseOutcome outcome = run_case(reference_case("B09"), solver);
    EXPECT_EQ(outcome.verdict, Verdict::met) << name_of(solver);
    for (const std::string& reason : outcome.reasons()) ADD_FAILURE() << reason;
  }
}

// The programs of C01 as general nonlinear programs.
TEST(QuadraticPrograms, DerivativesMatchTheData) {
  qp::SparseQp qp(SparsityPattern::from_pairs(3, 3, {{0, 0}, {1, 0}, {2, 1}, {2, 2}}),
                  SparsityPattern::from_pairs(2, 3, {{0, 0}, {0, 2}, {1, 1}}));
  qp.hessian << 2.0, -0.7, 0.4, 1.5;
  qp.rows << 1.0, -2.0, 3.0;
  qp.gradient << 0.3, -1.0, 0.6;
  library::QuadraticProgram program(qp);
  const NlpPoint point = testing_support::perturbed(program, VectorXd::LinSpaced(3, -0.5, 1.0), 11);
  const auto errors = testing_support::derivative_errors(program, point);
  // Differences of quadratic functions of order one: rounding over the step.
  EXPECT_LT(errors.gradient, 1e-7);
  EXPECT_LT(errors.jacobian, 1e-7);
  EXPECT_LT(errors.hessian, 1e-7);
  double f = 0.0;
  ASSERT_TRUE(program.objective(point.w.data(), f));
  EXPECT_EQ(f, objective(qp, point.w));
}

TEST(QuadraticPrograms, AreSkippedWithoutDataAndForStagedSolvers) {
  const char* variable = library::reference_data_variable;
  const char* set = std::getenv(variable);
  const std::string before = set == nullptr ? "" : set;
  ::unsetenv(variable);
  for (const bool is_empty : {false, true}) {
    if (is_empty) ::setenv(variable, "", 1);
    const CaseOutcome skipped = library::run_mpc_qps(SolverChoice::ipopt);
    EXPECT_EQ(skipped.verdict, Verdict::skipped);
    EXPECT_TRUE(contains(skipped.reasons().at(0), variable));
  }
  EXPECT_EQ(library::run_mpc_qps(SolverChoice::riccati).verdict, Verdict::not_applicable);
  ::setenv(variable, "/no/such/folder", 1);
  EXPECT_TRUE(contains(complaint_of([] { library::run_mpc_qps(SolverChoice::sparse); }),
                       "/no/such/folder/mpc_qp/expected.csv"));
  ::unsetenv(variable);
  if (set != nullptr) ::setenv(variable, before.c_str(), 1);
}

TEST(QuadraticPrograms, ReachTheirOptimaWithEverySparseSolver) {
  if (library::reference_data_folder() == nullptr)
    GTEST_SKIP() << "SALTUS_REFERENCE_DATA does not name the reference data";
  for (const SolverChoice solver : {SolverChoice::ipopt, SolverChoice::sparse}) {
    const CaseOutcome outcome = library::run_mpc_qps(solver);
    EXPECT_EQ(outcome.verdict, Verdict::met) << name_of(solver);
    EXPECT_EQ(outcome.checked.size(), 7u + 7u + 6u * 16u);
  }
}

}  // namespace
}  // namespace saltus
