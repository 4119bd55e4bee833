// What every simulation refuses: start, inputs or parameters of other sizes, times that decrease.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// The number of intervals between the times. Throws DefinitionError unless x0 has nx entries,
/// `coefficients` nc rows and a column per interval, `parameters` np entries, and no time lies
/// before its predecessor; `simulation` names the caller in the message.
int checked_intervals(const char* simulation, const IntervalArguments& index, const VectorRef& x0,
                      const VectorRef& times, const Eigen::Ref<const MatrixXd>& coefficients,
                      const VectorRef& parameters);

}  // namespace saltus
