#include "saltus/solver/slack_program.hpp"

#include <algorithm>
#include <utility>

#include "saltus/core/bounds.hpp"

namespace saltus {

SlackProgram::SlackProgram(NonlinearProgram& program, int slacks, double weight)
    : program_(program),
      n_(program.variables()),
      m_(program.rows()),
      lower_(VectorXd::Zero(n_ + slacks)),
      upper_(VectorXd::Constant(n_ + slacks, infinity)),
      slacks_(slacks),
      weight_(weight) {}

void SlackProgram::set_pattern(int rows, const std::vector<Constant>& constants) {
  std::vector<std::pair<int, int>> jacobian, hessian;
  program_.jacobian_pattern().for_each([&](int r, int c, int) { jacobian.emplace_back(r, c); });
  for (const Constant& c : constants) jacobian.emplace_back(c.row, c.column);
  program_.hessian_pattern().for_each([&](int r, int c, int) { hessian.emplace_back(r, c); });
  for (int i = 0; i < n_; ++i) hessian.emplace_back(i, i);
  jacobian_pattern_ = SparsityPattern::from_pairs(rows, variables(), std::move(jacobian));
  hessian_pattern_ = SparsityPattern::from_pairs(variables(), variables(), std::move(hessian));
  program_.jacobian_pattern().for_each(
      [&](int r, int c, int) { jacobian_position_.push_back(jacobian_pattern_.find(r, c)); });
  program_.hessian_pattern().for_each(
      [&](int r, int c, int) { hessian_position_.push_back(hessian_pattern_.find(r, c)); });
  for (int i = 0; i < n_; ++i) diagonal_position_.push_back(hessian_pattern_.find(i, i));
  for (const Constant& c : constants)
    constants_.push_back({jacobian_pattern_.find(c.row, c.column), c.value});
  jacobian_entries_.resize(jacobian_position_.size());
  hessian_entries_.resize(hessian_position_.size());
}

void SlackProgram::start_from(const VectorXd& w0, double zeta) {
  lower_.head(n_) = program_.lower();
  upper_.head(n_) = program_.upper();
  w0_ = w0;
  d_ = w0.cwiseAbs().cwiseMax(1.0).cwiseInverse();
  zeta_ = zeta;
}

bool SlackProgram::objective(const double* w, double& f) {
  f = 0.0;
  for (int i = n_; i < variables(); ++i) f += w[i];
  f *= weight_;
  for (int i = 0; i < n_; ++i) {
    const double away = d_[i] * (w[i] - w0_[i]);
    f += 0.5 * zeta_ * away * away;
  }
  return true;
}

bool SlackProgram::gradient(const double* w, double* gradient) {
  for (int i = 0; i < n_; ++i) gradient[i] = zeta_ * d_[i] * d_[i] * (w[i] - w0_[i]);
  std::fill(gradient + n_, gradient + variables(), weight_);
  return true;
}

bool SlackProgram::jacobian(const double* w, double* entries) {
  if (!program_.jacobian(w, jacobian_entries_.data())) return false;
  for (std::size_t e = 0; e < jacobian_position_.size(); ++e)
    entries[jacobian_position_[e]] = jacobian_entries_[e];
  for (const Entry& c : constants_) entries[c.position] = c.value;
  return true;
}

bool SlackProgram::hessian(const double* w, double sigma, const double* lambda, double* entries,
                           Curvature curvature) {
  if (!program_.hessian(w, 0.0, lambda, hessian_entries_.data(), curvature)) return false;
  std::fill(entries, entries + hessian_pattern_.entries(), 0.0);
  for (std::size_t e = 0; e < hessian_position_.size(); ++e)
    entries[hessian_position_[e]] = hessian_entries_[e];
  for (int i = 0; i < n_; ++i) entries[diagonal_position_[i]] += sigma * zeta_ * d_[i] * d_[i];
  return true;
}

}  // namespace saltus
