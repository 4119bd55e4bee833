// The vector and matrix types in which users write formulas and the framework stores numbers.
#pragma once

#include <Eigen/Core>

// Eigen's own default follows -march, and with it the layout of its types.
static_assert(EIGEN_MAX_ALIGN_BYTES == 16,
              "Saltus is built with EIGEN_MAX_ALIGN_BYTES=16, and so must be what uses it: link to "
              "saltus::core in CMake, or pass -DEIGEN_MAX_ALIGN_BYTES=16");

namespace saltus {

/// Column vector of n entries of scalar type S (double, a dual number, a sparsity tracer).
template <class S, int n>
using Vec = Eigen::Matrix<S, n, 1>;

/// Matrix of fixed size with entries of scalar type S.
template <class S, int rows, int cols>
using Mat = Eigen::Matrix<S, rows, cols>;

using VectorXd = Eigen::VectorXd;
using MatrixXd = Eigen::MatrixXd;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

}  // namespace saltus
