// Finds the least relaxation of sides that makes a program feasible. Negotiable rows and bounds are
// relaxed in groups; all others stay hard.
//
//     min sum_g (s_g + t_g) + rho/2 |D (w - w0)|^2
//     subject to   lower <= w + n_g (s_g - t_g) <= upper        for bounds in a group g,
//                  row_lower <= g(w) + n_g (s_g - t_g) <= row_upper   for rows in a group g,
//                  all other rows and bounds unchanged,   s, t >= 0
//
// There is one s and one t per group: all nodes of a term are relaxed by the same amount. Lower
// sides decrease by n_g s_g and upper sides increase by n_g t_g, where n_g is the nominal value of
// the group. D = 1 / max(1, |w0|). The small weight rho selects one of many points with the least
// relaxation; s and t equal those of an l1 penalty up to about rho.
#pragma once

#include <string>
#include <vector>

#include "saltus/solver/slack_program.hpp"

namespace saltus {

/// Rows and bounds that are relaxed together.
struct ElasticGroup {
  std::string name;            ///< used in messages
  std::vector<int> rows;       ///< row indices of the program
  std::vector<int> variables;  ///< variables whose bounds are relaxed
  double nominal = 1.0;        ///< nominal value in the units of the rows, positive
};

/// The relaxed program, for any solver.
class ElasticProgram final : public SlackProgram {
 public:
  /// `program` must outlive this object, and its data must not change meanwhile. Its variables come
  /// first, then s and t of every group. Its rows come first, then those of bounds in groups.
  ElasticProgram(NonlinearProgram& program, std::vector<ElasticGroup> groups, const VectorXd& w0);

  static constexpr double rho = 1e-6;  ///< weight of the quadratic term

  /// The groups as given.
  const std::vector<ElasticGroup>& groups() const { return groups_; }
  /// Index of the variable s_g: relaxation of the lower sides.
  int below(int group) const { return n_ + 2 * group; }
  /// Index of the variable t_g: relaxation of the upper sides.
  int above(int group) const { return n_ + 2 * group + 1; }
  /// Rows of the group in this program: its rows, then its bounds.
  std::vector<int> rows_of(int group) const;
  /// sum_g (s_g + t_g)
  double relaxation(const VectorXd& w) const;
  /// A start: w, and the relaxation that each group needs there.
  NlpPoint start(const VectorXd& w) const;

  int rows() const override { return static_cast<int>(row_lower_.size()); }
  const VectorXd& row_lower() const override { return row_lower_; }
  const VectorXd& row_upper() const override { return row_upper_; }

  bool constraints(const double* w, double* g) override;

  std::string describe_variable(int i) const override;
  std::string describe_row(int i) const override;

 private:
  std::vector<ElasticGroup> groups_;
  std::vector<int> group_of_row_;  // group of every row; -1: none
  std::vector<int> bounded_;       // variable of each row after those of the program
  VectorXd row_lower_, row_upper_;
};

}  // namespace saltus
