// The vector and matrix types in which users write formulas and the framework stores numbers.
#pragma once

#include <Eigen/Core>

// Eigen's own default follows -march, and with it the layout of its types.
static_assert(EIGEN_MAX_ALIGN_BYTES == 16,
              "Saltus is built with EIGEN_MAX_ALIGN_BYTES=16, and so must be what uses it: link to "
              "saltus::core in CMake, or pass -DEIGEN_MAX_ALIGN_BYTES=16");
#ifdef SALTUS_EIGEN_ALIGN_BYTES  // of an installed library
static_assert(EIGEN_DEFAULT_ALIGN_BYTES == SALTUS_EIGEN_ALIGN_BYTES,
              "this installation of Saltus was built for vectors of another width, where Eigen "
              "allocates in another way: leave -march to saltus::core, or build Saltus with "
              "-D SALTUS_MARCH=... for your processor");
#endif

namespace saltus {

/// Column vector of n entries of scalar type S (double, a dual number, a sparsity tracer).
template <class S, int n>
using Vec = Eigen::Matrix<S, n, 1>;

/// Matrix of fixed size with entries of scalar type S.
template <class S, int rows, int cols>
using Mat = Eigen::Matrix<S, rows, cols>;

/// A column of numbers whose length is known at run time.
using VectorXd = Eigen::VectorXd;
/// A matrix of numbers whose size is known at run time.
using MatrixXd = Eigen::MatrixXd;
/// A vector that is read, without a copy.
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
/// A vector that is written in place.
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

}  // namespace saltus
