// The units of a program, from what it tells of the size of its values and derivatives.
#pragma once

#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// What the cost, each row and each variable are multiplied by.
struct ProgramScale {
  double cost = 1.0;        ///< of the cost
  VectorXd rows;            ///< of each row
  VectorXd variables = {};  ///< empty: all 1

  /// Whether nothing is changed.
  bool is_one() const {
    return cost == 1.0 && (rows.array() == 1.0).all() && (variables.array() == 1.0).all();
  }
};

/// Variables that have one unit: a component of the state along all phases, say.
using Quantities = std::vector<std::vector<int>>;

/// Sizes of quantities, those of size 0 estimated: what moves a row as far as quantities of known
/// size do. 0 where no row tells. `jacobian` in the order of the program's pattern; `quantity_of`
/// each variable, -1: none, of size 1.
VectorXd sizes_through_rows(const NonlinearProgram& program, const VectorXd& jacobian,
                            const std::vector<int>& quantity_of, VectorXd sizes);

/// How large the values of quantities and the derivatives of cost and rows are, at the points that
/// were looked at. Variables of no quantity have the size 1.
class ProgramSize {
 public:
  /// The program must outlive it, and its data must not change meanwhile.
  ProgramSize(NonlinearProgram& program, Quantities quantities);

  /// Counts the point too; second derivatives are looked at at the first one only. False where
  /// cost or rows cannot be evaluated: then it does not count.
  bool look_at(const VectorXd& w);

  /// True if all sizes that values tell, times the scale, are between 1e-2 and 1e2, and a change of
  /// the variables by their size changes the cost by at least 1e-3: where it changes less, a
  /// tolerance is met anywhere.
  bool is_usual_where_known(const ProgramScale& scale) const;
  /// Whether any size, of what is estimated and of derivatives too, is below 1e-4 or above 1e6.
  bool is_far_from_usual(const ProgramScale& scale) const;

  /// Cost and rows times powers of two, so that nothing is rounded, where the size of their
  /// derivatives is not usual; all else as it is stated.
  ProgramScale usual() const;
  /// Everything divided by its size: in other units the scaled program is the same, up to
  /// rounding. The size of a quantity is the largest of its values. Where they are zero it is
  /// estimated: what moves a row as far as quantities of known size do. Bounds and penalty weights
  /// are no sizes: many only stand for "no bound" and "exactly".
  ProgramScale to_one() const;

 private:
  void look_at_curvature(const VectorXd& w);
  VectorXd known_sizes() const;  // of quantities; 0: unknown
  VectorXd sizes() const;

  NonlinearProgram& program_;
  Quantities quantities_;
  std::vector<int> quantity_of_;  // each variable, -1: none
  VectorXd values_;               // of quantities
  // Largest magnitudes of entries.
  VectorXd gradient_, jacobian_, hessian_;
  bool has_hessian_ = false;
};

}  // namespace saltus
