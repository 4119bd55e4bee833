#include "saltus/solver/restoration_program.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus {

RestorationProgram::RestorationProgram(NonlinearProgram& program)
    : program_(program), n_(program.variables()), m_(program.rows()) {
  std::vector<std::pair<int, int>> rows, hessian;
  program.jacobian_pattern().for_each([&](int r, int c, int) { rows.emplace_back(r, c); });
  for (int i = 0; i < m_; ++i) {
    rows.emplace_back(i, n_ + i);
    rows.emplace_back(i, n_ + m_ + i);
  }
  program.hessian_pattern().for_each([&](int r, int c, int) { hessian.emplace_back(r, c); });
  for (int i = 0; i < n_; ++i) hessian.emplace_back(i, i);
  const int all = variables();
  jacobian_pattern_ = SparsityPattern::from_pairs(m_, all, std::move(rows));
  hessian_pattern_ = SparsityPattern::from_pairs(all, all, std::move(hessian));
  program.jacobian_pattern().for_each(
      [&](int r, int c, int) { jacobian_position_.push_back(jacobian_pattern_.find(r, c)); });
  program.hessian_pattern().for_each(
      [&](int r, int c, int) { hessian_position_.push_back(hessian_pattern_.find(r, c)); });
  for (int i = 0; i < n_; ++i) diagonal_position_.push_back(hessian_pattern_.find(i, i));
  jacobian_entries_.resize(jacobian_position_.size());
  hessian_entries_.resize(hessian_position_.size());
  lower_ = VectorXd::Zero(all);
  upper_ = VectorXd::Constant(all, infinity);
}

void RestorationProgram::restart(const VectorXd& w0, double zeta) {
  lower_.head(n_) = program_.lower();
  upper_.head(n_) = program_.upper();
  w0_ = w0;
  d_ = w0.cwiseAbs().cwiseMax(1.0).cwiseInverse();
  zeta_ = zeta;
}

bool RestorationProgram::objective(const double* w, double& f) {
  f = 0.0;
  for (int i = n_; i < variables(); ++i) f += w[i];
  f *= weight;
  for (int i = 0; i < n_; ++i) {
    const double away = d_[i] * (w[i] - w0_[i]);
    f += 0.5 * zeta_ * away * away;
  }
  return true;
}

bool RestorationProgram::gradient(const double* w, double* gradient) {
  for (int i = 0; i < n_; ++i) gradient[i] = zeta_ * d_[i] * d_[i] * (w[i] - w0_[i]);
  std::fill(gradient + n_, gradient + variables(), weight);
  return true;
}

bool RestorationProgram::constraints(const double* w, double* g) {
  if (!program_.constraints(w, g)) return false;
  for (int i = 0; i < m_; ++i) g[i] += w[n_ + m_ + i] - w[n_ + i];
  return true;
}

bool RestorationProgram::jacobian(const double* w, double* entries) {
  if (!program_.jacobian(w, jacobian_entries_.data())) return false;
  for (std::size_t e = 0; e < jacobian_position_.size(); ++e)
    entries[jacobian_position_[e]] = jacobian_entries_[e];
  for (int i = 0; i < m_; ++i) {  // the last two of a row
    entries[jacobian_pattern_.row_end(i) - 2] = -1.0;
    entries[jacobian_pattern_.row_end(i) - 1] = 1.0;
  }
  return true;
}

bool RestorationProgram::hessian(const double* w, double sigma, const double* lambda,
                                 double* entries, Curvature curvature) {
  if (!program_.hessian(w, 0.0, lambda, hessian_entries_.data(), curvature)) return false;
  std::fill(entries, entries + hessian_pattern_.entries(), 0.0);
  for (std::size_t e = 0; e < hessian_position_.size(); ++e)
    entries[hessian_position_[e]] = hessian_entries_[e];
  for (int i = 0; i < n_; ++i) entries[diagonal_position_[i]] += sigma * zeta_ * d_[i] * d_[i];
  return true;
}

std::string RestorationProgram::describe_variable(int i) const {
  return i < n_ ? program_.describe_variable(i)
                : "violation of " + program_.describe_row((i - n_) % m_);
}

}  // namespace saltus
