// The derivative of an optimum by differences: solve again at theta +- h and extrapolate.
#pragma once

#include <functional>
#include <string>

#include "saltus/transcription/optimum_derivatives.hpp"

namespace saltus::testing_support {

struct Resolved {
  double cost = 0.0;
  VectorXd first_input;
};

/// `set(d)` changes the problem to theta + d and returns the program to solve, which may be a new
/// one. Central differences with h and h/2 are extrapolated to fourth order.
Resolved resolve(const std::function<MultipleShooting&(double)>& set, double h,
                 const NlpPoint* start = nullptr);

/// Compares the cost to 1e-6 relative and the first input to 1e-5. Differences of solves with
/// tolerance 1e-11 are that accurate.
void expect_agreement(const OptimumDerivatives::Derivative& ours, const Resolved& resolved,
                      const std::string& what);

}  // namespace saltus::testing_support
