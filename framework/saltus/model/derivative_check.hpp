// Are the derivatives of a function right? Compares Jacobian and Hessian with differences and says
// which entry is off, in words that name the input and the output.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

/// Where derivatives are looked at, and how closely.
struct DerivativeCheckOptions {
  /// Difference step relative to max(magnitude, |z_j|): near eps^(1/5), where the truncation (h^4)
  /// and the rounding (eps / h) of extrapolated central differences balance.
  double step = 5e-4;
  /// Largest accepted |exact - difference| / max(1, |exact|), beyond the rounding of differences.
  double tolerance = 1e-7;
  /// Of each input m_j; empty: ones. Where they are given, entries are those of a function whose
  /// inputs are divided by them and whose outputs by sum_j |J_ij| m_j.
  VectorXd magnitudes = {};
  /// Weights of the outputs in the Hessian; empty: distinct numbers near 1.
  VectorXd weights = {};
  /// For the report; may be empty.
  std::vector<std::string> input_names = {}, output_names = {};
};

/// One entry of a derivative. Of a Hessian, row >= col are both inputs.
struct DerivativeEntry {
  int row = -1;             ///< output, or row of the Hessian
  int col = -1;             ///< input
  double exact = 0.0;       ///< what the function says; 0 outside its pattern
  double difference = 0.0;  ///< what differences say
  double error = 0.0;       ///< scaled as the tolerance is; infinite if either is not finite
  bool in_pattern = true;   ///< whether the declared pattern has this entry
  int point = 0;            ///< at which of the points
};

/// What a check of derivatives found.
struct DerivativeReport {
  bool ok = true;                                 ///< nothing was found
  int points = 1;                                 ///< how many were looked at
  std::optional<std::uint32_t> seed;              ///< if the points were random
  double tolerance = 0.0;                         ///< of the relative error
  DerivativeEntry worst_jacobian, worst_hessian;  ///< where the error is largest
  /// All entries beyond the tolerance, worst first.
  std::vector<DerivativeEntry> jacobian_failures, hessian_failures;
  std::vector<std::string> input_names, output_names;  ///< as given
};

/// Checks at z. Entries outside the patterns must have zero differences. At a kink (abs at 0) no
/// difference is right: choose another point.
DerivativeReport check_derivatives(const Function& function, const VectorRef& z,
                                   const DerivativeCheckOptions& options = {});

/// Checks at `points` points drawn uniformly between lower and upper (each of `inputs` entries).
DerivativeReport check_derivatives(const Function& function, const VectorRef& lower,
                                   const VectorRef& upper, int points, std::uint32_t seed,
                                   const DerivativeCheckOptions& options = {});

/// One line if all is well, else a table of the worst entries.
std::string to_string(const DerivativeReport& report);
/// So that a test may write EXPECT_TRUE(report.ok) << report.
std::ostream& operator<<(std::ostream& out, const DerivativeReport& report);

}  // namespace saltus
