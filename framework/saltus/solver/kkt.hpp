// Our own check of an optimum: the KKT residual, computed from the problem and nothing else.
#pragma once

#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

struct ProgramScale;

/// First-order optimality, in the variables of the program. Zero at a KKT point.
struct KktResidual {
  double stationarity = 0.0;     ///< |grad f + J' lambda + z|, largest entry
  double feasibility = 0.0;      ///< largest violation of a row or bound
  double complementarity = 0.0;  ///< largest |multiplier| x distance to its side, or wrong sign
  /// Size of the multipliers by which stationarity and complementarity are divided in scaled():
  /// max(100, mean |multiplier|) / 100, the scaling customary for interior-point methods.
  double multiplier_scale = 1.0;
  int worst_row = -1;       ///< row of the largest violation, or -1 if a bound is worse
  int worst_variable = -1;  ///< variable whose bound is violated most

  /// As solvers compare it with their tolerance: relative to the size of multipliers.
  double scaled() const;
};

/// The check with its memory kept, for control loops: nothing allocates after construction, if the
/// program does not.
class KktCheck {
 public:
  /// For programs of these sizes and patterns.
  explicit KktCheck(const NonlinearProgram& program);
  /// Evaluates gradient, rows and Jacobian at the point; where that cannot be done, or
  /// entries of the point are missing or no numbers, every residual is infinite. Bound multipliers
  /// of variables with equal bounds are free and ignored.
  KktResidual operator()(NonlinearProgram& program, const NlpPoint& point) {
    return check(program, point, nullptr);
  }
  /// The same of the program times the scale, whose point is the point times it.
  KktResidual operator()(NonlinearProgram& program, const NlpPoint& point,
                         const ProgramScale& scale) {
    return check(program, point, &scale);
  }

 private:
  KktResidual check(NonlinearProgram& program, const NlpPoint& point, const ProgramScale* scale);

  VectorXd stationarity_, rows_;
  std::vector<double> entries_;
};

/// The same, once. Allocates.
KktResidual kkt_residual(NonlinearProgram& program, const NlpPoint& point);

}  // namespace saltus
