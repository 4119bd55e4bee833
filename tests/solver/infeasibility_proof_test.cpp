// Random linear rows and bounds in random units. A feasible program is never proved infeasible, and
// most infeasible programs are proved infeasible.
#include "saltus/solver/infeasibility_proof.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/random.hpp"
#include "tests/solver/small_programs.hpp"

namespace saltus {
namespace {

struct LinearRows final : testing_support::RowsOnly {
  LinearRows(int variables, SparsityPattern rows)
      : RowsOnly(std::move(rows), SparsityPattern(variables, variables)),
        entries_(jacobian_.entries()) {}

  bool is_linear_quadratic() const override { return true; }
  bool constraints(const double* w, double* g) override {
    std::fill_n(g, rows(), 0.0);
    jacobian_.for_each([&](int k, int i, int e) { g[k] += entries_[e] * w[i]; });
    return true;
  }
  bool jacobian(const double*, double* entries) override {
    std::copy(entries_.begin(), entries_.end(), entries);
    return true;
  }

  std::vector<double> entries_;
};

// A feasible program, in which some sides hold with equality. With `gap`, one more row requires
// more of a combination of the others than they allow, by this fraction of its terms.
LinearRows draw(unsigned seed, double decades, double gap) {
  Random random(seed);
  const int n = 3 + static_cast<int>(random.uniform(0.0, 12.0));
  const int m = 2 + static_cast<int>(random.uniform(0.0, 14.0));
  const auto unit = [&] { return std::pow(10.0, random.uniform(-decades, decades)); };
  const auto is_likely = [&](double p) { return random.uniform(0.0, 1.0) < p; };
  MatrixXd rows = MatrixXd::Zero(m + 1, n);
  for (int k = 0; k < m; ++k)
    for (int i = 0; i < n; ++i)
      if (is_likely(0.5)) rows(k, i) = random.uniform(-1.0, 1.0);
  VectorXd point(n), multipliers = VectorXd::Zero(m);
  for (double& value : point) value = random.uniform(-1.0, 1.0);
  for (double& value : multipliers)
    if (is_likely(0.6)) value = random.uniform(-1.0, 1.0);
  if (gap > 0.0) rows.row(m) = multipliers.transpose() * rows.topRows(m);
  std::vector<std::pair<int, int>> pairs;
  for (int k = 0; k <= m; ++k)
    for (int i = 0; i < n; ++i) pairs.emplace_back(k, i);
  LinearRows p(n, SparsityPattern::from_pairs(m + 1, n, std::move(pairs)));
  VectorXd of_row(m + 1), of_variable(n);
  for (double& value : of_row) value = unit();
  for (double& value : of_variable) value = unit();
  const VectorXd value = rows * point;
  double most = 0.0, size = 0.0;  // maximum of the combination, and size of its terms
  for (int k = 0; k < m; ++k) {
    double low = value[k], high = value[k];
    if (is_likely(0.5)) {
      low -= is_likely(0.5) ? random.uniform(0.0, 1.0) : 0.0;
      high += is_likely(0.5) ? random.uniform(0.0, 1.0) : 0.0;
      // A side that the combination does not use may be missing.
      if (multipliers[k] > 0.0 && is_likely(0.5)) low = -infinity;
      if (multipliers[k] < 0.0 && is_likely(0.5)) high = infinity;
    }
    if (multipliers[k] != 0.0) {
      most += multipliers[k] * (multipliers[k] > 0.0 ? high : low);
      size += std::abs(multipliers[k] * (multipliers[k] > 0.0 ? high : low));
    }
    p.row_lower_[k] = low * of_row[k];
    p.row_upper_[k] = high * of_row[k];
  }
  if (gap > 0.0) p.row_lower_[m] = (most + gap * std::max(size, 1e-3)) * of_row[m];
  for (int i = 0; i < n; ++i) {
    if (is_likely(0.3)) p.lower_[i] = point[i] - (is_likely(0.5) ? random.uniform(0.0, 2.0) : 0.0);
    if (is_likely(0.3)) p.upper_[i] = point[i] + (is_likely(0.5) ? random.uniform(0.0, 2.0) : 0.0);
    p.lower_[i] *= of_variable[i];
    p.upper_[i] *= of_variable[i];
  }
  p.jacobian_pattern().for_each(
      [&](int k, int i, int e) { p.entries_[e] = of_row[k] * rows(k, i) / of_variable[i]; });
  return p;
}

int proved(double decades, double gap, int count) {
  int proofs = 0;
  for (int seed = 1; seed <= count; ++seed) {
    LinearRows p = draw(static_cast<unsigned>(seed), decades, gap);
    proofs += is_proved_infeasible(p, VectorXd::Zero(p.variables())) ? 1 : 0;
  }
  return proofs;
}

TEST(InfeasibilityProof, IsNeverGivenForFeasiblePrograms) {
  for (const double decades : {0.0, 3.0, 8.0}) EXPECT_EQ(proved(decades, 0.0, 500), 0) << decades;
}

TEST(InfeasibilityProof, IsIndependentOfUnits) {
  for (const double decades : {0.0, 3.0, 6.0})
    for (const double gap : {1.0, 1e-2, 1e-4})
      EXPECT_GE(proved(decades, gap, 100), 98) << decades << " " << gap;
}

}  // namespace
}  // namespace saltus
