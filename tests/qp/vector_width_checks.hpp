// Checks for every vector width. They return plain numbers, so that the test runs no code of a
// width before it has checked that the machine supports it.
#pragma once

namespace saltus::testing {

struct WidthReport {
  int lanes = 0;
  int programs = 0, failed = 0, first_failed = 0;  ///< first_failed: seed of the first failure
  double worst_cost = 0.0;                         ///< relative to the known optimum
  double worst_residual = 0.0;                     ///< in units of the multipliers
};
/// Random programs with known optima, with sizes known at run time and to the compiler.
WidthReport solve_random_programs(int programs, bool fixed_sizes);

/// Random programs with the previous inputs as states, with sizes from 1 on.
WidthReport solve_with_previous_inputs(int programs);

/// Largest deviation of the kernels with `lanes` numbers at a time from entry-wise sums of
/// products.
double worst_product_error();

}  // namespace saltus::testing
