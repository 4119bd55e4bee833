#include "tests/support/dense_algebra.hpp"

#include <Eigen/LU>
#include <Eigen/QR>

namespace saltus::testing {
namespace {

// Matrix of a linear map, column by column. This compiles faster than Eigen's solve with a matrix.
MatrixXd columns(const std::function<VectorXd(const VectorXd&)>& map, Eigen::Index rows,
                 Eigen::Index cols) {
  MatrixXd matrix(rows, cols);
  for (Eigen::Index c = 0; c < cols; ++c) matrix.col(c) = map(VectorXd::Unit(cols, c));
  return matrix;
}

}  // namespace

std::function<VectorXd(const VectorXd&)> solver_of(const MatrixXd& A) {
  return [lu = Eigen::PartialPivLU<MatrixXd>(A)](const VectorXd& b) -> VectorXd {
    return lu.solve(b);
  };
}

std::function<VectorXd(const VectorXd&)> least_squares_of(const MatrixXd& A) {
  return [factors = Eigen::CompleteOrthogonalDecomposition<MatrixXd>(A)](
             const VectorXd& b) -> VectorXd { return factors.solve(b); };
}

MatrixXd inverse(const MatrixXd& A) { return columns(solver_of(A), A.rows(), A.cols()); }

MatrixXd pseudo_inverse(const MatrixXd& A) {
  return columns(least_squares_of(A), A.cols(), A.rows());
}

}  // namespace saltus::testing
