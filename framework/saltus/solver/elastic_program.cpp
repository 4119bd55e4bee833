#include "saltus/solver/elastic_program.hpp"

#include <algorithm>
#include <utility>

#include "saltus/core/bounds.hpp"

namespace saltus {

ElasticProgram::ElasticProgram(NonlinearProgram& program, std::vector<ElasticGroup> groups,
                               const VectorXd& w0)
    : SlackProgram(program, 2 * static_cast<int>(groups.size()), 1.0),
      groups_(std::move(groups)),
      group_of_row_(m_, -1) {
  start_from(w0, rho);
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
  std::vector<Constant> constants;
  for (int r = 0; r < all_rows; ++r) {
    if (r >= m_) {
      const int bounded = bounded_[r - m_];
      row_lower_[r] = std::exchange(lower_[bounded], -infinity);
      row_upper_[r] = std::exchange(upper_[bounded], infinity);
      constants.push_back({r, bounded, 1.0});
    }
    if (const int g = group_of_row_[r]; g >= 0) {
      constants.push_back({r, below(g), groups_[g].nominal});
      constants.push_back({r, above(g), -groups_[g].nominal});
    }
  }
  set_pattern(all_rows, constants);
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

bool ElasticProgram::constraints(const double* w, double* g) {
  if (!program_.constraints(w, g)) return false;
  for (std::size_t k = 0; k < bounded_.size(); ++k) g[m_ + k] = w[bounded_[k]];
  for (int r = 0; r < rows(); ++r)
    if (const int group = group_of_row_[r]; group >= 0)
      g[r] += groups_[group].nominal * (w[below(group)] - w[above(group)]);
  return true;
}

std::string ElasticProgram::describe_variable(int i) const {
  return i < n_ ? program_.describe_variable(i) : "relaxation of " + groups_[(i - n_) / 2].name;
}

std::string ElasticProgram::describe_row(int i) const {
  return i < m_ ? program_.describe_row(i)
                : "bounds of " + program_.describe_variable(bounded_[i - m_]);
}

}  // namespace saltus
