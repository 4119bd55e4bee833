#include "tests/support/program_derivatives.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace saltus::testing_support {

NlpPoint perturbed(const NonlinearProgram& program, const VectorXd& w, unsigned seed,
                   double radius) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  NlpPoint point{w, VectorXd(program.rows()), {}};
  for (int i = 0; i < w.size(); ++i)
    point.w[i] = std::clamp(w[i] + radius * any(random), program.lower()[i], program.upper()[i]);
  for (double& l : point.lambda) l = any(random);
  return point;
}

DerivativeErrors derivative_errors(NonlinearProgram& program, const NlpPoint& point,
                                   Curvature curvature, double h) {
  const int n = program.variables(), m = program.rows();
  const double sigma = 0.7;  // arbitrary weight of the cost
  const auto dense_jacobian = [&](const VectorXd& w) {
    std::vector<double> entries(program.jacobian_pattern().entries());
    EXPECT_TRUE(program.jacobian(w.data(), entries.data()));
    MatrixXd dense = MatrixXd::Zero(m, n);
    program.jacobian_pattern().for_each([&](int r, int c, int e) { dense(r, c) = entries[e]; });
    return dense;
  };
  const auto gradient = [&](const VectorXd& w) {
    VectorXd result(n);
    EXPECT_TRUE(program.gradient(w.data(), result.data()));
    return result;
  };
  MatrixXd hessian = MatrixXd::Zero(n, n);
  const bool has_hessian = program.supports(curvature);  // otherwise the error stays zero
  if (has_hessian) {
    std::vector<double> entries(program.hessian_pattern().entries());
    EXPECT_TRUE(
        program.hessian(point.w.data(), sigma, point.lambda.data(), entries.data(), curvature));
    program.hessian_pattern().for_each(
        [&](int r, int c, int e) { hessian(r, c) = hessian(c, r) = entries[e]; });
  }
  const MatrixXd jacobian = dense_jacobian(point.w);
  const VectorXd slope = gradient(point.w);

  DerivativeErrors worst;
  const auto compare = [](double& error, double exact, double difference) {
    error = std::max(error, std::abs(exact - difference) / (1.0 + std::abs(exact)));
  };
  VectorXd w = point.w, above(m), below(m);
  for (int i = 0; i < n; ++i) {
    double f_above = 0.0, f_below = 0.0;
    w[i] = point.w[i] + h;
    EXPECT_TRUE(program.objective(w.data(), f_above) &&
                program.constraints(w.data(), above.data()));
    const VectorXd lagrangian_above =
        sigma * gradient(w) + dense_jacobian(w).transpose() * point.lambda;
    w[i] = point.w[i] - h;
    EXPECT_TRUE(program.objective(w.data(), f_below) &&
                program.constraints(w.data(), below.data()));
    const VectorXd lagrangian_below =
        sigma * gradient(w) + dense_jacobian(w).transpose() * point.lambda;
    w[i] = point.w[i];
    compare(worst.gradient, slope[i], (f_above - f_below) / (2.0 * h));
    for (int r = 0; r < m; ++r)
      compare(worst.jacobian, jacobian(r, i), (above[r] - below[r]) / (2.0 * h));
    for (int j = 0; j < n && has_hessian; ++j)
      compare(worst.hessian, hessian(j, i),
              (lagrangian_above[j] - lagrangian_below[j]) / (2.0 * h));
  }
  return worst;
}

}  // namespace saltus::testing_support
