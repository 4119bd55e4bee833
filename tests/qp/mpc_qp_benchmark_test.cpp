// Case C01: quadratic programs of walking robots (qpsolvers/mpc_qpbenchmark), solved to the digits
// of optima that were computed independently. The files are found through the environment variable
// SALTUS_REFERENCE_DATA.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "framework/qp/sparse_solver.hpp"
#include "tests/support/npz.hpp"

namespace saltus {
namespace {

struct Expected {
  std::string file;
  double cost = 0.0;
  std::vector<double> x;  ///< the first entries of the optimum
};

std::vector<Expected> read_expected(const std::string& path) {
  std::vector<Expected> all;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    std::vector<std::string> field;
    for (std::string text; std::getline(fields, text, ',');) field.push_back(text);
    Expected& e = all.emplace_back();
    e.file = field.at(0);
    e.cost = std::stod(field.at(5));
    for (std::size_t i = 7; i < field.size(); ++i) e.x.push_back(std::stod(field[i]));
  }
  return all;
}

// min 1/2 x'Px + q'x subject to G x <= h, A x = b, lb <= x <= ub; what is absent is empty. The
// patterns are those of the non-zero entries.
SparseQp to_sparse_qp(std::map<std::string, MatrixXd> data) {
  const MatrixXd &P = data["P"], &G = data["G"], &A = data["A"];
  const int n = static_cast<int>(P.rows()), inequalities = static_cast<int>(G.rows());
  const int rows = inequalities + static_cast<int>(A.rows());
  MatrixXd J(rows, n);
  J << G, A;
  std::vector<std::pair<int, int>> hessian, jacobian;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j)
      if (P(i, j) != 0.0) hessian.emplace_back(i, j);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < n; ++j)
      if (J(i, j) != 0.0) jacobian.emplace_back(i, j);
  SparseQp qp(SparsityPattern::from_pairs(n, n, hessian),
              SparsityPattern::from_pairs(rows, n, jacobian));
  qp.hessian_pattern.for_each([&](int i, int j, int e) { qp.hessian[e] = P(i, j); });
  qp.row_pattern.for_each([&](int i, int j, int e) { qp.rows[e] = J(i, j); });
  qp.gradient = data["q"];
  qp.row_upper << data["h"], data["b"];
  qp.row_lower.tail(A.rows()) = data["b"];
  if (data["lb"].size() > 0) qp.lower = data["lb"];
  if (data["ub"].size() > 0) qp.upper = data["ub"];
  return qp;
}

TEST(MpcQpBenchmark, OptimaAreReachedToTheDigitsKnown) {
  const char* folder = std::getenv("SALTUS_REFERENCE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "SALTUS_REFERENCE_DATA does not name the reference data";
  const std::string data = std::string(folder) + "/mpc_qp/";
  const std::vector<Expected> cases = read_expected(data + "expected.csv");
  ASSERT_FALSE(cases.empty()) << data + "expected.csv";
  for (const Expected& expected : cases) {
    const SparseQp qp = to_sparse_qp(testing::read_npz(data + expected.file));
    const auto solver =
        make_sparse_qp_solver(qp.hessian_pattern, qp.row_pattern, {.tolerance = 1e-13});
    PrimalDualPoint point{VectorXd::Zero(qp.variables()), VectorXd(), VectorXd()};
    const QpResult result = solver->solve(qp, point, false);
    EXPECT_EQ(result.status, QpStatus::optimal) << expected.file;
    EXPECT_LT(result.residual, 1e-10) << expected.file;
    // Thirteen digits are given.
    EXPECT_NEAR(result.objective, expected.cost, 5e-13 * (1.0 + std::abs(expected.cost)))
        << expected.file;
    // The optimum of this one has ties, and its cost vanishes: what counts was checked above.
    if (expected.file == "QUADCMPC3.npz") continue;
    for (std::size_t i = 0; i < expected.x.size(); ++i)
      EXPECT_NEAR(point.w[i], expected.x[i], 1e-9) << expected.file << ", x[" << i << "]";
  }
}

}  // namespace
}  // namespace saltus
