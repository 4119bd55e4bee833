#include "saltus/integrators/simulation_arguments.hpp"

#include <fmt/format.h>

#include "saltus/core/error.hpp"

namespace saltus {

int checked_intervals(const char* simulation, const IntervalArguments& index, const VectorRef& x0,
                      const VectorRef& times, const Eigen::Ref<const MatrixXd>& coefficients,
                      const VectorRef& parameters) {
  const auto expect_size = [&](const char* what, Eigen::Index given, Eigen::Index expected) {
    if (given != expected)
      throw DefinitionError(fmt::format("a {} needs {} of size {}, but was given {}.", simulation,
                                        what, expected, given));
  };
  if (times.size() < 1)
    throw DefinitionError(fmt::format("a {} needs at least one time.", simulation));
  const int intervals = static_cast<int>(times.size()) - 1;
  expect_size("a start state", x0.size(), index.nx);
  expect_size("parameters", parameters.size(), index.np);
  expect_size("input coefficients per interval", coefficients.rows(), index.nc);
  expect_size("one column of input coefficients per interval", coefficients.cols(), intervals);
  for (int k = 0; k < intervals; ++k)
    if (!(times[k] <= times[k + 1]))
      throw DefinitionError(
          fmt::format("the times of a {} must not decrease, but time {} is {} after {}.",
                      simulation, k + 1, times[k + 1], times[k]));
  return intervals;
}

}  // namespace saltus
