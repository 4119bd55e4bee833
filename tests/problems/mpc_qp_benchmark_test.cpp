// Case C01: quadratic programs of walking robots (qpsolvers/mpc_qpbenchmark), solved to the digits
// of independently computed optima. The environment variable SALTUS_REFERENCE_DATA names the folder
// of the files.
#include <gtest/gtest.h>

#include <cmath>

#include "problems/library/c01_mpc_qps.hpp"
#include "saltus/qp/sparse_qp.hpp"

namespace saltus {
namespace {

TEST(MpcQpBenchmark, OptimaMatchAllKnownDigits) {
  const char* folder = library::reference_data_folder();
  if (folder == nullptr) GTEST_SKIP() << "SALTUS_REFERENCE_DATA does not name the reference data";
  for (const library::MpcQp& known : library::read_mpc_qps(folder)) {
    const qp::SparseQp& qp = known.qp;
    const auto solver =
        qp::make_sparse_qp_solver(qp.hessian_pattern, qp.row_pattern, {.tolerance = 1e-13});
    PrimalDualPoint point{VectorXd::Zero(qp.variables()), VectorXd(), VectorXd()};
    const qp::QpResult result = solver->solve(qp, point, false);
    EXPECT_EQ(result.status, qp::QpStatus::optimal) << known.name;
    EXPECT_LT(result.residual, 1e-10) << known.name;
    // Thirteen digits are given.
    EXPECT_NEAR(result.objective, known.cost, 5e-13 * (1.0 + std::abs(known.cost))) << known.name;
    for (std::size_t i = 0; i < known.x.size(); ++i)
      EXPECT_NEAR(point.w[i], known.x[i], 1e-9) << known.name << ", x[" << i << "]";
  }
}

}  // namespace
}  // namespace saltus
