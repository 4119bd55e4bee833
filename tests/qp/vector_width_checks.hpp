// What is checked in every vector width. Plain numbers, so that the test that looks at them needs
// no code of that width before it knows that the machine has it.
#pragma once

namespace saltus::testing {

struct WidthReport {
  int lanes = 0;
  int programs = 0, failed = 0, first_failed = 0;  ///< first_failed: its seed
  double worst_cost = 0.0;                         ///< relative to the known one
  double worst_residual = 0.0;                     ///< in units of the multipliers
};
/// Random programs with known optima, with sizes known at run time and to the compiler.
WidthReport solve_random_programs(int programs, bool fixed_sizes);

/// Random programs whose states hold the previous inputs, sizes from 1 on.
WidthReport solve_with_previous_inputs(int programs);

/// Largest deviation from entry-wise sums of products of the kernels with `lanes` at a time.
double worst_product_error();

}  // namespace saltus::testing
