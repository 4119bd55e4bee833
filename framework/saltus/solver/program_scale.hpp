// Scaling of a program, from the sizes of its values and derivatives.
#pragma once

#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Scale factors of the cost, rows and variables.
struct ProgramScale {
  double cost = 1.0;        ///< factor of the cost
  VectorXd rows;            ///< factor of each row
  VectorXd variables = {};  ///< empty: all 1

  /// True if all factors are 1.
  bool is_one() const;
};

/// Groups of variables with one unit, such as a component of the state along all phases.
using Quantities = std::vector<std::vector<int>>;

/// Sizes of quantities. A size of 0 is estimated from the rows: the change that moves a row as far
/// as quantities of known size do. It stays 0 if no row gives an estimate. `jacobian` is in the
/// order of the program's pattern. `quantity_of` maps each variable to its quantity; -1: none, of
/// size 1.
VectorXd sizes_through_rows(const NonlinearProgram& program, const VectorXd& jacobian,
                            const std::vector<int>& quantity_of, VectorXd sizes);

/// Sizes of the values of quantities and of the derivatives of cost and rows at the sampled points.
/// Variables without a quantity have the size 1.
class ProgramSize {
 public:
  /// The program must outlive this object, and its data must not change meanwhile.
  ProgramSize(NonlinearProgram& program, Quantities quantities);

  /// Adds a sample point. Second derivatives are evaluated at the first point only. Returns false,
  /// without adding the point, if cost or rows cannot be evaluated.
  bool look_at(const VectorXd& w);

  /// True if all sizes of values, times the scale, are between 1e-2 and 1e2, and a change of the
  /// variables by their size changes the cost by at least 1e-3. With a smaller change, any point
  /// would meet the tolerance.
  bool is_usual_where_known(const ProgramScale& scale) const;
  /// True if any size, also of estimates and derivatives, is below 1e-4 or above 1e6.
  bool is_far_from_usual(const ProgramScale& scale) const;

  /// Scales cost and rows by powers of two (exact in floating point) if their derivatives are badly
  /// scaled. All else is as stated.
  ProgramScale usual() const;
  /// Divides everything by its size. A change of units leaves the scaled program the same up to
  /// rounding. The size of a quantity is its largest value. If all values are zero, it is
  /// estimated: the change that moves a row as far as quantities of known size do. Bounds and
  /// penalty weights do not count: many only express "no bound" or "exactly".
  ProgramScale to_one() const;

 private:
  void look_at_curvature(const VectorXd& w);
  VectorXd known_sizes() const;  // per quantity; 0: unknown
  VectorXd sizes() const;

  NonlinearProgram& program_;
  Quantities quantities_;
  std::vector<int> quantity_of_;  // per variable; -1: none
  VectorXd values_;               // per quantity
  // Largest magnitudes of the entries.
  VectorXd gradient_, jacobian_, hessian_;
  bool has_hessian_ = false;
};

}  // namespace saltus
