// Independent optimality check: the KKT residual, computed from the program alone.
#pragma once

#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

struct ProgramScale;

/// First-order optimality residual in the variables of the program. Zero at a KKT point.
struct KktResidual {
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

/// The check with persistent memory, for control loops. It does not allocate after construction if
/// the program does not.
class KktCheck {
 public:
  /// For programs with these sizes and patterns.
  explicit KktCheck(const NonlinearProgram& program);
  /// Evaluates gradient, rows and Jacobian at the point. If an evaluation fails, or entries of the
  /// point are missing or not finite, all residuals are infinite. Bound multipliers of variables
  /// with equal bounds are free and ignored.
  KktResidual operator()(NonlinearProgram& program, const NlpPoint& point) {
    return check(program, point, nullptr);
  }
  /// The same for the scaled program at the scaled point.
  KktResidual operator()(NonlinearProgram& program, const NlpPoint& point,
                         const ProgramScale& scale) {
    return check(program, point, &scale);
  }

 private:
  KktResidual check(NonlinearProgram& program, const NlpPoint& point, const ProgramScale* scale);

  VectorXd stationarity_, rows_;
  std::vector<double> entries_;
};

/// Computes the residual once. Allocates.
KktResidual kkt_residual(NonlinearProgram& program, const NlpPoint& point);

}  // namespace saltus
