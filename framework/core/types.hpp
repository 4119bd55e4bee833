// The vector and matrix types in which users write formulas and the framework stores numbers.
#pragma once

#include <Eigen/Core>

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
