// By how much must the sides of a program give so that it can be met? What is asked for is relaxed,
// group by group; what is not negotiable stays as it is.
//
//     min sum_g (s_g + t_g) + rho/2 |D (w - w0)|^2
//     subject to   lower <= w + n_g (s_g - t_g) <= upper        for bounds in a group g,
//                  row_lower <= g(w) + n_g (s_g - t_g) <= row_upper   for rows in a group g,
//                  all other rows and bounds as they stand,   s, t >= 0
//
// One s and one t per group: all nodes of a term give by the same amount, so that n_g s_g is what
// has to be taken from its lower sides and n_g t_g what has to be added to the upper ones. n_g is
// the group's nominal value. D = 1 / max(1, |w0|); rho is small, so that of many points with the
// least relaxation one is the solution, and s and t are those of an l1 penalty to about rho.
#pragma once

#include <string>
#include <vector>

#include "saltus/solver/slack_program.hpp"

namespace saltus {

/// Rows and bounds that give together.
struct ElasticGroup {
  std::string name;            ///< for messages
  std::vector<int> rows;       ///< of the program
  std::vector<int> variables;  ///< whose bounds give
  double nominal = 1.0;        ///< in their units, positive
};

/// The relaxed program, for any solver.
class ElasticProgram final : public SlackProgram {
 public:
  /// `program` must outlive it, and its data must not change meanwhile. Its variables come first,
  /// then s and t of every group; its rows, then those of bounds in groups.
  ElasticProgram(NonlinearProgram& program, std::vector<ElasticGroup> groups, const VectorXd& w0);

  static constexpr double rho = 1e-6;  ///< weight of the square

  /// As given.
  const std::vector<ElasticGroup>& groups() const { return groups_; }
  /// The variable s_g: so far lower sides give.
  int below(int group) const { return n_ + 2 * group; }
  /// The variable t_g: so far upper sides do.
  int above(int group) const { return n_ + 2 * group + 1; }
  /// Rows of the group here: its rows, then its bounds.
  std::vector<int> rows_of(int group) const;
  /// sum_g (s_g + t_g)
  double relaxation(const VectorXd& w) const;
  /// A start: w, and what each group lacks there.
  NlpPoint start(const VectorXd& w) const;

  int rows() const override { return static_cast<int>(row_lower_.size()); }
  const VectorXd& row_lower() const override { return row_lower_; }
  const VectorXd& row_upper() const override { return row_upper_; }

  bool constraints(const double* w, double* g) override;

  std::string describe_variable(int i) const override;
  std::string describe_row(int i) const override;

 private:
  std::vector<ElasticGroup> groups_;
  std::vector<int> group_of_row_;  // of all rows here, -1: none
  std::vector<int> bounded_;       // variable of each row beyond those of the program
  VectorXd row_lower_, row_upper_;
};

}  // namespace saltus
