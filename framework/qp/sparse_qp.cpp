#include "framework/qp/sparse_qp.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus {

SparseQp::SparseQp(SparsityPattern hessian_shape, SparsityPattern row_shape)
    : hessian_pattern(std::move(hessian_shape)),
      row_pattern(std::move(row_shape)),
      hessian(VectorXd::Zero(hessian_pattern.entries())),
      rows(VectorXd::Zero(row_pattern.entries())),
      gradient(VectorXd::Zero(row_pattern.cols())),
      lower(VectorXd::Constant(row_pattern.cols(), -infinity)),
      upper(VectorXd::Constant(row_pattern.cols(), infinity)),
      row_lower(VectorXd::Constant(row_pattern.rows(), -infinity)),
      row_upper(VectorXd::Constant(row_pattern.rows(), infinity)) {}

}  // namespace saltus
