// Eigen's factorisations, compiled once. Each use elsewhere would take seconds to compile for every
// size and kind of expression.
#pragma once

#include <functional>

#include "saltus/core/types.hpp"

namespace saltus::testing {

/// Maps b to the solution x of A x = b, by LU with partial pivoting.
std::function<VectorXd(const VectorXd&)> solver_of(const MatrixXd& A);
/// Maps b to the least-squares solution of A x = b with the smallest norm, by a complete orthogonal
/// decomposition.
std::function<VectorXd(const VectorXd&)> least_squares_of(const MatrixXd& A);

MatrixXd inverse(const MatrixXd& A);
MatrixXd pseudo_inverse(const MatrixXd& A);

}  // namespace saltus::testing
