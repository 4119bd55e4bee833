#include "problems/library/c01_mpc_qps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

#include "problems/library/npz.hpp"
#include "problems/library/quadratic_program.hpp"
#include "saltus/core/csv_table.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus::library {
namespace {

// Relative to 1 + |cost|; three orders smaller than the tolerance of costs with eight digits.
constexpr double cost_tolerance = 1e-9;
// The curvature is small along some directions, so the optimum is less accurate than its cost.
constexpr double entry_tolerance = 1e-6;
constexpr int max_iterations = 500;
constexpr int digits = 13;

// The patterns are those of the non-zero entries. Absent matrices are empty.
qp::SparseQp to_sparse_qp(std::map<std::string, MatrixXd> data, const std::string& file) {
  const MatrixXd &P = data["P"], &G = data["G"], &A = data["A"];
  const int n = static_cast<int>(P.rows()), inequalities = static_cast<int>(G.rows());
  const int rows = inequalities + static_cast<int>(A.rows());
  const auto is_of = [&](const char* name, Eigen::Index rows_of_it, Eigen::Index cols) {
    const MatrixXd& m = data[name];
    return m.rows() == rows_of_it && m.cols() == cols;
  };
  const auto is_absent_or = [&](const char* name, Eigen::Index rows_of_it, Eigen::Index cols) {
    return data[name].rows() == 0 || is_of(name, rows_of_it, cols);
  };
  if (n == 0 || !is_of("P", n, n) || !is_of("q", n, 1) || !is_absent_or("G", G.rows(), n) ||
      !is_absent_or("A", A.rows(), n) || data["h"].size() != G.rows() ||
      data["b"].size() != A.rows() || !is_absent_or("lb", n, 1) || !is_absent_or("ub", n, 1))
    throw InputError(fmt::format("'{}': P, q, G, h, A, b, lb and ub do not fit together", file));
  MatrixXd J(rows, n);
  if (G.size() > 0) J.topRows(G.rows()) = G;
  if (A.size() > 0) J.bottomRows(A.rows()) = A;
  std::vector<std::pair<int, int>> hessian, jacobian;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j)
      if (P(i, j) != 0.0) hessian.emplace_back(i, j);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < n; ++j)
      if (J(i, j) != 0.0) jacobian.emplace_back(i, j);
  qp::SparseQp qp(SparsityPattern::from_pairs(n, n, hessian),
                  SparsityPattern::from_pairs(rows, n, jacobian));
  qp.hessian_pattern.for_each([&](int i, int j, int e) { qp.hessian[e] = P(i, j); });
  qp.row_pattern.for_each([&](int i, int j, int e) { qp.rows[e] = J(i, j); });
  qp.gradient = data["q"];
  if (G.size() > 0) qp.row_upper.head(G.rows()) = data["h"];
  if (A.size() > 0) qp.row_lower.tail(A.rows()) = qp.row_upper.tail(A.rows()) = data["b"];
  if (data["lb"].size() > 0) qp.lower = data["lb"];
  if (data["ub"].size() > 0) qp.upper = data["ub"];
  return qp;
}

// "file,n,inequalities,equalities,has bounds,cost,active,x[0],x[1],..."
MpcQp read_line(const std::string& line, const std::filesystem::path& data) {
  const std::vector<std::string> field = csv_cells(line);
  if (field.size() < 8)
    throw InputError(fmt::format("'{}' has a line that is too short: '{}'",
                                 (data / "expected.csv").string(), line));
  MpcQp program;
  program.name = field[0].substr(0, field[0].rfind(".npz"));
  const std::filesystem::path file = data / std::filesystem::path(field[0]).filename();
  program.qp = to_sparse_qp(read_npz(file.string()), file.string());
  const auto number = [&](const std::string& text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      throw InputError(fmt::format("'{}' has '{}' instead of a number",
                                   (data / "expected.csv").string(), shortened(text)));
    return value;
  };
  if (field.size() > 7 + static_cast<std::size_t>(program.qp.gradient.size()))
    throw InputError(fmt::format("'{}' has more values of x than '{}' has variables",
                                 (data / "expected.csv").string(), program.name));
  program.cost = number(field[5]);
  // With zero cost and singular P the optimum of the quadruped is not unique.
  const bool is_unique = std::abs(program.cost) > 1e-12;
  for (std::size_t i = 7; is_unique && i < field.size(); ++i) program.x.push_back(number(field[i]));
  return program;
}

void check(const MpcQp& program, const NlpResult& result, std::vector<CheckedValue>& checked) {
  const bool ok = is_success(result.status);
  checked.push_back({program.name + " cost", ok ? result.objective : std::nan(""),
                     std::abs(program.cost) > 1e-12 ? program.cost : 0.0,
                     cost_tolerance * (1.0 + std::abs(program.cost)), digits});
  checked.push_back(residual_of(program.name + " KKT residual",
                                ok ? result.kkt.scaled() : std::nan(""), library_kkt_limit));
  for (std::size_t i = 0; ok && i < program.x.size(); ++i)
    checked.push_back({fmt::format("{} x[{}]", program.name, i), result.point.w[i], program.x[i],
                       entry_tolerance * (1.0 + std::abs(program.x[i])), digits});
}

// The cost with the largest error comes first; the table shows it.
void bring_worst_cost_to_front(std::vector<CheckedValue>& checked) {
  const auto costs_end =
      std::stable_partition(checked.begin(), checked.end(),
                            [](const CheckedValue& v) { return v.name.ends_with("cost"); });
  const auto worst = std::max_element(
      checked.begin(), costs_end, [](const CheckedValue& a, const CheckedValue& b) {
        return a.fraction_of_tolerance() < b.fraction_of_tolerance();
      });
  std::iter_swap(checked.begin(), worst);
}

}  // namespace

const char* reference_data_folder() {
  const char* folder = std::getenv(reference_data_variable);
  return folder == nullptr || *folder == '\0' ? nullptr : folder;
}

std::vector<MpcQp> read_mpc_qps(const std::filesystem::path& folder) {
  const std::filesystem::path data = folder / "mpc_qp";
  std::ifstream stream(data / "expected.csv");
  if (!stream)
    throw InputError(fmt::format("'{}' cannot be opened; {} must name the folder above mpc_qp",
                                 (data / "expected.csv").string(), reference_data_variable));
  std::vector<MpcQp> programs;
  for (std::string line; std::getline(stream, line);)
    if (!line.empty() && line[0] != '#') programs.push_back(read_line(line, data));
  if (programs.empty())
    throw InputError(fmt::format("'{}' lists no program", (data / "expected.csv").string()));
  return programs;
}

CaseOutcome run_mpc_qps(SolverChoice choice) {
  CaseOutcome outcome;
  outcome.id = mpc_qps_id;
  outcome.name = mpc_qps_name;
  outcome.exercises = "quadratic programs of walking robots, including dense and degenerate ones";
  outcome.source = "qpsolvers, mpc_qpbenchmark; optima computed independently";
  if (choice == SolverChoice::riccati) {
    outcome.verdict = Verdict::not_applicable;
    outcome.status = "these programs have no stages";
    return outcome;
  }
  const char* folder = reference_data_folder();
  if (folder == nullptr) {
    outcome.verdict = Verdict::skipped;
    outcome.status =
        fmt::format("set {} to the folder with mpc_qp/expected.csv", reference_data_variable);
    return outcome;
  }
  const auto solver = make_case_solver(choice, max_iterations);
  for (const MpcQp& known : read_mpc_qps(folder)) {
    QuadraticProgram program(known.qp);
    const NlpPoint start{VectorXd::Zero(program.variables()), VectorXd(), VectorXd()};
    const NlpResult result = solver->solve(program, start, false);
    check(known, result, outcome.checked);
    outcome.iterations += result.iterations;
    outcome.seconds += result.seconds;
    outcome.status = describe(result.status);
    if (is_success(result.status)) continue;
    outcome.status = fmt::format("{}: {}", known.name, outcome.status);
    bring_worst_cost_to_front(outcome.checked);
    return outcome;  // did not converge
  }
  bring_worst_cost_to_front(outcome.checked);
  outcome.verdict = judge(outcome.checked);
  return outcome;
}

}  // namespace saltus::library
