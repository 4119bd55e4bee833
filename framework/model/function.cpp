#include "framework/model/function.hpp"

#include <vector>

namespace saltus {

VectorXd Function::operator()(const VectorRef& z) const {
  const VectorXd argument = z;  // contiguous whatever the caller passed
  VectorXd y(outputs());
  value(argument.data(), y.data());
  return y;
}

MatrixXd Function::dense_jacobian(const VectorRef& z) const {
  const VectorXd argument = z;
  VectorXd y(outputs());
  std::vector<double> entries(jacobian_pattern().entries());
  jacobian(argument.data(), y.data(), entries.data());
  MatrixXd dense = MatrixXd::Zero(outputs(), inputs());
  jacobian_pattern().for_each([&](int r, int c, int e) { dense(r, c) = entries[e]; });
  return dense;
}

MatrixXd Function::dense_hessian(const VectorRef& z, const VectorRef& weights,
                                 Curvature curvature) const {
  const VectorXd argument = z;
  const VectorXd row_weights = weights;
  std::vector<double> entries(hessian_pattern().entries());
  hessian(argument.data(), row_weights.data(), entries.data(), curvature);
  MatrixXd dense = MatrixXd::Zero(inputs(), inputs());
  hessian_pattern().for_each([&](int r, int c, int e) {
    dense(r, c) = entries[e];
    dense(c, r) = entries[e];
  });
  return dense;
}

}  // namespace saltus
