// Validation of the arguments of all simulations: sizes of start, inputs and parameters, and order
// of times.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Returns the number of intervals between the times. Throws DefinitionError unless sizes match and
/// times do not decrease. Sizes: x0 has nx entries, `coefficients` has nc rows and one column per
/// interval, `parameters` has np entries. `simulation` names the caller in the message.
int checked_intervals(const char* simulation, const IntervalArguments& index, const VectorRef& x0,
                      const VectorRef& times, const Eigen::Ref<const MatrixXd>& coefficients,
                      const VectorRef& parameters);

}  // namespace saltus
