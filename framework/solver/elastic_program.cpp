#include "saltus/solver/elastic_program.hpp"

#include <algorithm>
#include <utility>

#include "saltus/core/bounds.hpp"

namespace saltus {

ElasticProgram::ElasticProgram(NonlinearProgram& program, std::vector<ElasticGroup> groups,
                               const VectorXd& w0)
    : program_(program),
      groups_(std::move(groups)),
      n_(program.variables()),
      m_(program.rows()),
      group_of_row_(m_, -1),
      lower_(VectorXd::Zero(variables())),
      upper_(VectorXd::Constant(variables(), infinity)),
      w0_(w0),
      d_(w0.cwiseAbs().cwiseMax(1.0).cwiseInverse()) {
  lower_.head(n_) = program.lower();
  upper_.head(n_) = program.upper();
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    for (const int r : groups_[g].rows) group_of_row_[r] = static_cast<int>(g);
    for (const int i : groups_[g].variables) {
      bounded_.push_back(i);
      group_of_row_.push_back(static_cast<int>(g));
    }
  }
  const int all_rows = m_ + static_cast<int>(bounded_.size());
  row_lower_.resize(all_rows);
  row_upper_.resize(all_rows);
  row_lower_.head(m_) = program.row_lower();
  row_upper_.head(m_) = program.row_upper();
  for (std::size_t k = 0; k < bounded_.size(); ++k) {
    const int r = m_ + static_cast<int>(k);
    row_lower_[r] = std::exchange(lower_[bounded_[k]], -infinity);
    row_upper_[r] = std::exchange(upper_[bounded_[k]], infinity);
  }

  std::vector<std::pair<int, int>> rows, hessian;
  program.jacobian_pattern().for_each([&](int r, int c, int) { rows.emplace_back(r, c); });
  program.hessian_pattern().for_each([&](int r, int c, int) { hessian.emplace_back(r, c); });
  for (std::size_t k = 0; k < bounded_.size(); ++k)
    rows.emplace_back(m_ + static_cast<int>(k), bounded_[k]);
  for (int r = 0; r < all_rows; ++r)
    if (const int g = group_of_row_[r]; g >= 0) {
      rows.emplace_back(r, below(g));
      rows.emplace_back(r, above(g));
    }
  for (int i = 0; i < n_; ++i) hessian.emplace_back(i, i);
  jacobian_pattern_ = SparsityPattern::from_pairs(all_rows, variables(), std::move(rows));
  hessian_pattern_ = SparsityPattern::from_pairs(variables(), variables(), std::move(hessian));
  program.jacobian_pattern().for_each(
      [&](int r, int c, int) { jacobian_position_.push_back(jacobian_pattern_.find(r, c)); });
  program.hessian_pattern().for_each(
      [&](int r, int c, int) { hessian_position_.push_back(hessian_pattern_.find(r, c)); });
  for (int i = 0; i < n_; ++i) diagonal_position_.push_back(hessian_pattern_.find(i, i));
  for (int r = 0; r < all_rows; ++r) {
    if (r >= m_) constants_.push_back({jacobian_pattern_.find(r, bounded_[r - m_]), 1.0});
    if (const int g = group_of_row_[r]; g >= 0) {
      constants_.push_back({jacobian_pattern_.find(r, below(g)), groups_[g].nominal});
      constants_.push_back({jacobian_pattern_.find(r, above(g)), -groups_[g].nominal});
    }
  }
  jacobian_entries_.resize(jacobian_position_.size());
  hessian_entries_.resize(hessian_position_.size());
}

std::vector<int> ElasticProgram::rows_of(int group) const {
  std::vector<int> rows;
  for (int r = 0; r < this->rows(); ++r)
    if (group_of_row_[r] == group) rows.push_back(r);
  return rows;
}

double ElasticProgram::relaxation(const VectorXd& w) const {
  return w.tail(variables() - n_).sum();
}

NlpPoint ElasticProgram::start(const VectorXd& w) const {
  NlpPoint point;
  point.w = VectorXd::Zero(variables());
  point.w.head(n_) = w;
  VectorXd g(m_);
  if (!program_.constraints(w.data(), g.data()) || !g.allFinite()) return point;
  for (int r = 0; r < rows(); ++r) {
    const int group = group_of_row_[r];
    if (group < 0) continue;
    const double value = r < m_ ? g[r] : w[bounded_[r - m_]];
    double &s = point.w[below(group)], &t = point.w[above(group)];
    s = std::max(s, (row_lower_[r] - value) / groups_[group].nominal);
    t = std::max(t, (value - row_upper_[r]) / groups_[group].nominal);
  }
  return point;
}

bool ElasticProgram::objective(const double* w, double& f) {
  f = 0.0;
  for (int i = n_; i < variables(); ++i) f += w[i];
  for (int i = 0; i < n_; ++i) {
    const double away = d_[i] * (w[i] - w0_[i]);
    f += 0.5 * rho * away * away;
  }
  return true;
}

bool ElasticProgram::gradient(const double* w, double* gradient) {
  for (int i = 0; i < n_; ++i) gradient[i] = rho * d_[i] * d_[i] * (w[i] - w0_[i]);
  std::fill(gradient + n_, gradient + variables(), 1.0);
  return true;
}

bool ElasticProgram::constraints(const double* w, double* g) {
  if (!program_.constraints(w, g)) return false;
  for (std::size_t k = 0; k < bounded_.size(); ++k) g[m_ + k] = w[bounded_[k]];
  for (int r = 0; r < rows(); ++r)
    if (const int group = group_of_row_[r]; group >= 0)
      g[r] += groups_[group].nominal * (w[below(group)] - w[above(group)]);
  return true;
}

bool ElasticProgram::jacobian(const double* w, double* entries) {
  if (!program_.jacobian(w, jacobian_entries_.data())) return false;
  for (std::size_t e = 0; e < jacobian_position_.size(); ++e)
    entries[jacobian_position_[e]] = jacobian_entries_[e];
  for (const Constant& c : constants_) entries[c.position] = c.value;
  return true;
}

bool ElasticProgram::hessian(const double* w, double sigma, const double* lambda, double* entries,
                             Curvature curvature) {
  if (!program_.hessian(w, 0.0, lambda, hessian_entries_.data(), curvature)) return false;
  std::fill(entries, entries + hessian_pattern_.entries(), 0.0);
  for (std::size_t e = 0; e < hessian_position_.size(); ++e)
    entries[hessian_position_[e]] = hessian_entries_[e];
  for (int i = 0; i < n_; ++i) entries[diagonal_position_[i]] += sigma * rho * d_[i] * d_[i];
  return true;
}

std::string ElasticProgram::describe_variable(int i) const {
  return i < n_ ? program_.describe_variable(i)
                : "what is missing of " + groups_[(i - n_) / 2].name;
}

std::string ElasticProgram::describe_row(int i) const {
  return i < m_ ? program_.describe_row(i)
                : "bounds of " + program_.describe_variable(bounded_[i - m_]);
}

}  // namespace saltus
