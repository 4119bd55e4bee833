// Factorisations by Eigen, compiled once: each takes seconds to compile wherever it is used, for
// every size and kind of expression anew.
#pragma once

#include <functional>

#include "saltus/core/types.hpp"

namespace saltus::testing {

/// b to x with A x = b, by LU with partial pivoting.
std::function<VectorXd(const VectorXd&)> solver_of(const MatrixXd& A);
/// b to the shortest x of those that come closest to A x = b, by a complete orthogonal
/// decomposition.
std::function<VectorXd(const VectorXd&)> least_squares_of(const MatrixXd& A);

MatrixXd inverse(const MatrixXd& A);
MatrixXd pseudo_inverse(const MatrixXd& A);

}  // namespace saltus::testing
