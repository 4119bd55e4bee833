#include "saltus/model/function.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

void check(const Function& function, const VectorRef& z) {
  if (!function) throw DefinitionError("a function is evaluated, but it is empty or moved from");
  if (z.size() < function.inputs())
    throw DefinitionError(fmt::format("a function is evaluated at {} values, but it has {} inputs",
                                      z.size(), function.inputs()));
}

}  // namespace

Function::Function(const Function& other) = default;
Function::Function(Function&& other) noexcept = default;
Function& Function::operator=(const Function& other) = default;
Function& Function::operator=(Function&& other) noexcept = default;
Function::~Function() = default;
Function::Function(std::unique_ptr<const FunctionBody> body) : body_(std::move(body)) {}

// Uses only the patterns: without second derivatives, the function is affine.
int FunctionBody::degree(int output, const std::vector<char>& variable) const {
  bool affine = true;
  hessian_pattern_.for_each([&](int i, int j, int) {
    if (variable[i] && variable[j]) affine = false;
  });
  if (!affine) return 3;
  for (int e = jacobian_pattern_.row_begin(output); e < jacobian_pattern_.row_end(output); ++e)
    if (variable[jacobian_pattern_.col(e)]) return 1;
  return 0;
}

bool FunctionBody::reads(int input) const {
  for (int e = 0; e < jacobian_pattern_.entries(); ++e)
    if (jacobian_pattern_.col(e) == input) return true;
  return false;
}

void FunctionBody::derivatives(const double* z, const double* weights, double* y,
                               double* jacobian_entries, double* hessian_entries,
                               Curvature curvature) const {
  jacobian(z, y, jacobian_entries);
  hessian(z, weights, hessian_entries, curvature);
}

Function Function::separate() const {
  if (!body_) return {};
  if (std::shared_ptr<const FunctionBody> own = body_->separate()) return Function(std::move(own));
  return body_->is_reentrant() ? *this : Function();
}

VectorXd Function::operator()(const VectorRef& z) const {
  check(*this, z);
  const VectorXd argument = z;  // contiguous for any argument
  VectorXd y(outputs());
  value(argument.data(), y.data());
  return y;
}

MatrixXd Function::dense_jacobian(const VectorRef& z) const {
  check(*this, z);
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
  check(*this, z);
  if (weights.size() < outputs())
    throw DefinitionError(
        fmt::format("a Hessian needs one weight per output: {} weights, but {} outputs",
                    weights.size(), outputs()));
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
