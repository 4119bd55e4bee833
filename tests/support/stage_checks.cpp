#include "tests/support/stage_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/dense_qp_solver.hpp"
#include "tests/support/stage_conversion.hpp"

namespace saltus::testing_support {

double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

qp::StagePoint random_trajectory(const qp::StageQp& qp, std::mt19937& random) {
  qp::StagePoint point(qp);
  const auto between = [&](double lower, double upper) {
    const double low = std::max(lower, upper < infinity ? upper - 2.0 : -1.0);
    return uniform(random, low, std::min(upper, low + 2.0));
  };
  for (int k = 0; k <= qp.intervals(); ++k) {
    const qp::Stage& s = qp.stages[k];
    qp::StagePoint::AtStage& p = point.stages[k];
    for (int i = 0; i < s.nu; ++i) p.u[i] = between(s.u_lower[i], s.u_upper[i]);
    if (k == 0)
      for (int i = 0; i < s.nx; ++i)
        p.x[i] = qp.fixed_start ? qp.start[i] : between(s.x_lower[i], s.x_upper[i]);
    if (k == qp.intervals()) break;
    const int next = qp.stages[k + 1].nx;
    point.stages[k + 1].x.head(next) = s.A.topLeftCorner(next, s.nx) * p.x.head(s.nx) +
                                       s.B.topLeftCorner(next, s.nu) * p.u.head(s.nu) +
                                       s.b.head(next);
  }
  return point;
}

void expect_equivalent(const qp::SparseQp& qp, qp::StageMap& map, std::mt19937& random) {
  for (int trial = 0; trial < 3; ++trial) {
    const qp::StagePoint trajectory = random_trajectory(map.stages(), random);
    PrimalDualPoint sparse;
    map.convert(qp, trajectory, sparse);
    const double cost = objective(qp, sparse.w);
    EXPECT_NEAR(objective(map.stages(), trajectory), cost, 1e-10 * (1.0 + std::abs(cost)));
    const double violation = kkt_residual(qp, sparse).feasibility;
    EXPECT_NEAR(kkt_residual(map.stages(), trajectory).feasibility, violation,
                1e-10 * (1.0 + violation));
    qp::StagePoint back(map.stages());
    map.convert(qp, sparse, back);
    for (int k = 0; k <= map.stages().intervals(); ++k) {
      const qp::Stage& s = map.stages().stages[k];
      for (int i = 0; i < s.nx; ++i)
        EXPECT_NEAR(back.stages[k].x[i], trajectory.stages[k].x[i],
                    1e-10 * (1.0 + std::abs(back.stages[k].x[i])));
      for (int i = 0; i < s.nu; ++i) EXPECT_EQ(back.stages[k].u[i], trajectory.stages[k].u[i]);
    }
  }
}

void expect_same_optimum(const qp::SparseQp& qp, qp::StageMap& map) {
  const StageConversion conversion(map.stages());
  const qp::SparseQp& staged = conversion.sparse();
  const qp::QpOptions options{.tolerance = 1e-10, .max_iterations = 200};
  PrimalDualPoint solution{VectorXd::Zero(staged.variables()),
                           VectorXd::Zero(staged.row_pattern.rows()),
                           VectorXd::Zero(staged.variables())};
  const qp::QpResult result =
      make_dense_qp_solver(staged.hessian_pattern, staged.row_pattern, options)
          ->solve(staged, solution, false);
  qp::StagePoint point(map.stages());
  conversion.convert(solution, point);
  const double reached = kkt_residual(map.stages(), point).largest();
  // The dense solver may stop one digit above the requested tolerance.
  ASSERT_LE(reached, 2e-9) << describe(result.status);

  PrimalDualPoint sparse;
  map.convert(qp, point, sparse);
  const qp::SparseQp::Residual residual = kkt_residual(qp, sparse);
  EXPECT_LE(residual.stationarity, 1e-8);
  EXPECT_LE(residual.feasibility, 1e-8);
  EXPECT_LE(residual.complementarity, 1e-8);
  EXPECT_NEAR(objective(qp, sparse.w), objective(map.stages(), point),
              1e-8 * (1.0 + std::abs(result.objective)));

  qp::StagePoint back(map.stages());
  map.convert(qp, sparse, back);
  EXPECT_LE(kkt_residual(map.stages(), back).largest(), 1e-8);
}

void expect_equal(const qp::StageQp& a, const qp::StageQp& b) {
  ASSERT_EQ(a.stages.size(), b.stages.size());
  EXPECT_EQ(a.fixed_start, b.fixed_start);
  for (std::size_t k = 0; k < a.stages.size(); ++k) {
    const qp::Stage &s = a.stages[k], &t = b.stages[k];
    ASSERT_EQ(s.nx, t.nx);
    ASSERT_EQ(s.nu, t.nu);
    EXPECT_EQ(s.resultant_size, t.resultant_size);
    const int nx = s.nx, nu = s.nu, next = k + 1 < a.stages.size() ? a.stages[k + 1].nx : 0;
    EXPECT_EQ(s.A.topLeftCorner(next, nx), t.A.topLeftCorner(next, nx));
    EXPECT_EQ(s.B.topLeftCorner(next, nu), t.B.topLeftCorner(next, nu));
    EXPECT_EQ(s.b.head(next), t.b.head(next));
    EXPECT_EQ(s.Q.topLeftCorner(nx, nx), t.Q.topLeftCorner(nx, nx));
    EXPECT_EQ(s.S.topLeftCorner(nu, nx), t.S.topLeftCorner(nu, nx));
    EXPECT_EQ(s.R.topLeftCorner(nu, nu), t.R.topLeftCorner(nu, nu));
    EXPECT_EQ(s.q.head(nx), t.q.head(nx));
    EXPECT_EQ(s.r.head(nu), t.r.head(nu));
    EXPECT_EQ(s.constant, t.constant);
    EXPECT_EQ(s.x_lower.head(nx), t.x_lower.head(nx));
    EXPECT_EQ(s.x_upper.head(nx), t.x_upper.head(nx));
    EXPECT_EQ(s.u_lower.head(nu), t.u_lower.head(nu));
    EXPECT_EQ(s.u_upper.head(nu), t.u_upper.head(nu));
    for (std::size_t g = 0; g < s.groups.size(); ++g) {
      const qp::RowGroup &m = s.groups[g], &n = t.groups[g];
      ASSERT_EQ(m.rows, n.rows);
      ASSERT_EQ(m.columns, n.columns);
      const int columns = static_cast<int>(m.columns.size());
      EXPECT_EQ(m.M.topLeftCorner(m.rows, columns), n.M.topLeftCorner(m.rows, columns));
      EXPECT_EQ(m.lower.head(m.rows), n.lower.head(m.rows));
      EXPECT_EQ(m.upper.head(m.rows), n.upper.head(m.rows));
      if (!m.soft) continue;
      EXPECT_EQ(m.l1.head(m.rows), n.l1.head(m.rows));
      EXPECT_EQ(m.l2.head(m.rows), n.l2.head(m.rows));
    }
  }
}

}  // namespace saltus::testing_support
