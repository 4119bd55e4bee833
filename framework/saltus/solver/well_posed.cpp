#include "saltus/solver/well_posed.hpp"

#include "saltus/core/bounds.hpp"

namespace saltus {
namespace {

bool are_bounds(const VectorXd& lower, const VectorXd& upper) {
  for (Eigen::Index i = 0; i < lower.size(); ++i)
    if (Bounds{lower[i], upper[i]}.is_empty()) return false;
  return true;
}

}  // namespace

bool is_well_posed(const NonlinearProgram& program, const NlpPoint& start) {
  return start.w.size() == program.variables() && are_bounds(program.lower(), program.upper()) &&
         are_bounds(program.row_lower(), program.row_upper());
}

}  // namespace saltus
