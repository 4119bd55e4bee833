// The derivative of an optimum the long way: solve again at theta +- h, and extrapolate.
#pragma once

#include <functional>
#include <string>

#include "saltus/transcription/optimum_derivatives.hpp"

namespace saltus::testing_support {

struct Resolved {
  double cost = 0.0;
  VectorXd first_input;
};

/// `set(d)` brings the problem to theta + d and may make a new one; it returns what to solve.
/// Central differences with h and h/2, extrapolated: of fourth order.
Resolved resolve(const std::function<MultipleShooting&(double)>& set, double h,
                 const NlpPoint* start = nullptr);

/// Cost to 1e-6 relative, first input to 1e-5: what differences of solves to 1e-11 can confirm.
void expect_agreement(const OptimumDerivative& ours, const Resolved& resolved,
                      const std::string& what);

}  // namespace saltus::testing_support
