// Compares the Jacobian and Hessian of a function with finite differences. The report names the
// input and the output of each wrong entry.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

/// Options of check_derivatives().
struct DerivativeCheckOptions {
  /// Difference step relative to max(magnitude, |z_j|). The default is near eps^(1/5), where
  /// truncation (h^4) and rounding (eps / h) of extrapolated central differences balance.
  double step = 5e-4;
  /// Largest accepted |exact - difference| / max(1, |exact|), in addition to the rounding error of
  /// the differences.
  double tolerance = 1e-7;
  /// Magnitude m_j of each input. Default: ones. If given, the check divides inputs by m_j and
  /// outputs by sum_j |J_ij| m_j.
  VectorXd magnitudes = {};
  /// Weights of the outputs in the Hessian. Default: distinct numbers near 1.
  VectorXd weights = {};
  /// Names for the report. May be empty.
  std::vector<std::string> input_names = {}, output_names = {};
};

/// Result of check_derivatives().
struct DerivativeReport {
  /// One entry of a derivative. For a Hessian, row >= col are both inputs.
  struct Entry {
    int row = -1;             ///< output, or row of the Hessian
    int col = -1;             ///< input
    double exact = 0.0;       ///< value from the function; 0 outside its pattern
    double difference = 0.0;  ///< value from finite differences
    double error = 0.0;       ///< scaled like the tolerance; infinite if a value is not finite
    bool in_pattern = true;   ///< true if the declared pattern contains the entry
    int point = 0;            ///< index of the test point
  };

  bool ok = true;                       ///< all entries are within the tolerance
  int points = 1;                       ///< number of test points
  std::optional<std::uint32_t> seed;    ///< seed of random points
  double tolerance = 0.0;               ///< accepted relative error
  Entry worst_jacobian, worst_hessian;  ///< entries with the largest error
  /// All entries outside the tolerance, worst first.
  std::vector<Entry> jacobian_failures, hessian_failures;
  std::vector<std::string> input_names, output_names;  ///< names given in the options
};
/// Deprecated name.
using DerivativeEntry [[deprecated("use DerivativeReport::Entry; removed in 0.4")]] =
    DerivativeReport::Entry;

/// Checks the derivatives at z. Entries outside the patterns must have zero differences. At a kink,
/// such as abs at 0, differences are invalid: choose another point.
DerivativeReport check_derivatives(const Function& function, const VectorRef& z,
                                   const DerivativeCheckOptions& options = {});

/// Checks at `points` random points, uniform between lower and upper. Both have one entry per
/// input.
DerivativeReport check_derivatives(const Function& function, const VectorRef& lower,
                                   const VectorRef& upper, int points, std::uint32_t seed,
                                   const DerivativeCheckOptions& options = {});

/// One line if all entries are correct, otherwise a table of the worst entries.
std::string to_string(const DerivativeReport& report);
/// Lets a test write EXPECT_TRUE(report.ok) << report.
std::ostream& operator<<(std::ostream& out, const DerivativeReport& report);

}  // namespace saltus
