// Checks whether a point is an optimum of the program as stated: how much its cost could still
// decrease, to first and second order, in the units of the cost.
//
// The check uses the KKT matrix [H + Z/G, A'; A, -G/L] of the primal-dual equations. G are the
// distances to the sides, Z and L the multipliers of bounds and inequality rows (Nocedal and
// Wright, Numerical Optimization, 2nd ed., sec. 19.3). The weight of a side is its multiplier
// divided by its distance. The result is therefore independent of units, and small multipliers of a
// barrier method count correctly.
#pragma once

#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

// Independent optimality check: the KKT residual, computed from the program alone.

struct ProgramScale;

/// The check with persistent memory, for control loops. It does not allocate after construction if
/// the program does not.
class KktCheck {
 public:
  /// First-order optimality residual in the variables of the program. Zero at a KKT point.
  struct Residual {
    double stationarity = 0.0;     ///< |grad f + J' lambda + z|, largest entry
    double feasibility = 0.0;      ///< largest violation of a row or bound
    double complementarity = 0.0;  ///< largest |multiplier| x distance to its side, or wrong sign
    /// Divisor of stationarity and complementarity in scaled(): max(100, mean |multiplier|) / 100,
    /// the usual scaling of interior-point methods.
    double multiplier_scale = 1.0;
    int worst_row = -1;       ///< row of the largest violation, or -1 if a bound is worse
    int worst_variable = -1;  ///< variable whose bound is violated most

    /// Residual that solvers compare with their tolerance, relative to the size of the multipliers.
    double scaled() const;
  };

  /// For programs with these sizes and patterns.
  explicit KktCheck(const NonlinearProgram& program);
  /// Evaluates gradient, rows and Jacobian at the point. If an evaluation fails, or entries of the
  /// point are missing or not finite, all residuals are infinite. Bound multipliers of variables
  /// with equal bounds are free and ignored.
  Residual operator()(NonlinearProgram& program, const NlpPoint& point) {
    return check(program, point, nullptr);
  }
  /// The same for the scaled program at the scaled point.
  Residual operator()(NonlinearProgram& program, const NlpPoint& point, const ProgramScale& scale) {
    return check(program, point, &scale);
  }

 private:
  Residual check(NonlinearProgram& program, const NlpPoint& point, const ProgramScale* scale);

  VectorXd stationarity_, rows_;
  std::vector<double> entries_;
};
/// Deprecated name.
using KktResidual [[deprecated("use KktCheck::Residual; removed in 0.4")]] = KktCheck::Residual;

/// Computes the residual once. Allocates.
KktCheck::Residual kkt_residual(NonlinearProgram& program, const NlpPoint& point);

// Scaling of a program, from the sizes of its values and derivatives.

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
VectorXd estimate_sizes_from_rows(const NonlinearProgram& program, const VectorXd& jacobian,
                                  const std::vector<int>& quantity_of, VectorXd sizes);

/// Sizes of the values of quantities and of the derivatives of cost and rows at the sampled points.
/// Variables without a quantity have size 1.
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
  bool is_well_scaled_where_known(const ProgramScale& scale) const;
  /// True if any size, also of estimates and derivatives, is below 1e-4 or above 1e6.
  bool is_badly_scaled(const ProgramScale& scale) const;
  /// Deprecated name.
  [[deprecated("use is_badly_scaled; removed in 0.4")]] bool is_far_from_usual(
      const ProgramScale& scale) const {
    return is_badly_scaled(scale);
  }

  /// Scales cost and rows by powers of two (exact in floating point) if their derivatives are badly
  /// scaled. All else is as stated.
  ProgramScale usual() const;
  /// Divides everything by its size. A change of units leaves the scaled program the same up to
  /// rounding. The size of a quantity is its largest value. If all values are zero, it is
  /// estimated: the change that moves a row as far as quantities of known size do. Without such an
  /// estimate, it is the largest value that its bounds allow. Penalty weights and bounds above 1e8
  /// do not count: many only express "exactly" or "no bound".
  ProgramScale to_one() const;

 private:
  void look_at_curvature(const VectorXd& w);
  VectorXd known_sizes() const;  // per quantity; 0: unknown
  VectorXd sizes() const;
  VectorXd sizes_with_bounds(VectorXd size) const;

  NonlinearProgram& program_;
  Quantities quantities_;
  std::vector<int> quantity_of_;  // per variable; -1: none
  VectorXd values_;               // per quantity
  // Largest magnitudes of the entries.
  VectorXd gradient_, jacobian_, hessian_;
  bool has_hessian_ = false;
};

/// Result of a first- and second-order optimality check.
struct OptimumCheck {
  /// Second-order classification of the point.
  enum class Curvature {
    minimum,       ///< the cost rises along every feasible direction
    inconclusive,  ///< second derivatives vanish along some direction; higher ones decide
    descent,       ///< the cost decreases along `direction` and along its negative
    unknown        ///< no second derivatives, or the matrix could not be judged
  };
  Curvature curvature = Curvature::unknown;  ///< second-order result
  VectorXd direction;    ///< direction of least curvature, largest entry 1; may be empty
  int variable = -1;     ///< variable with the largest entry of the direction
  double descent = 0.0;  ///< predicted decrease of the cost along it, within all sides; not
                         ///< negative

  /// Sum of |multiplier| x distance to its side: bound on the suboptimality in a convex program.
  /// Infinite if the point could not be evaluated.
  double gap = infinity;
  /// Predicted decrease of the cost by a Newton step from the residual of stationarity.
  double gain = 0.0;
  /// Reference for gap and gain: |cost| or, if larger, the change of the cost when a variable moves
  /// by its size, at most 1.
  double magnitude = 1.0;

  /// Possible decrease of the cost by the first-order conditions, relative to its size.
  double relative_gain() const { return (gap + gain) / magnitude; }
};

/// Checks a point with its multipliers. `quantities` group variables of one size. Allocates and
/// factors one matrix of the size of the program; for analysis, not for control loops.
OptimumCheck check_optimum(NonlinearProgram& program, const NlpPoint& point,
                           const Quantities& quantities = {});

}  // namespace saltus
