#include "tests/support/resolved_derivatives.hpp"

#include <gtest/gtest.h>

#include "saltus/solver/ipopt.hpp"

namespace saltus::testing_support {

Resolved resolve(const std::function<MultipleShooting&(double)>& set, double h,
                 const NlpPoint* start) {
  const auto at = [&](double d) {
    MultipleShooting& shooting = set(d);
    const auto solver = make_ipopt({.tolerance = 1e-11});
    const Solution s =
        start != nullptr ? solve(shooting, *solver, {start->w, {}, {}}) : solve(shooting, *solver);
    EXPECT_TRUE(s.ok()) << s.message;
    EXPECT_LT(s.kkt.scaled(), 1e-9);
    const double first = s.trajectory.pieces().front().start;
    return Resolved{s.cost, s.trajectory.input(first)};
  };
  const auto central = [&](double step) {
    const Resolved above = at(step), below = at(-step);
    return Resolved{(above.cost - below.cost) / (2.0 * step),
                    (above.first_input - below.first_input) / (2.0 * step)};
  };
  const Resolved coarse = central(h), fine = central(0.5 * h);
  set(0.0);
  return {fine.cost + (fine.cost - coarse.cost) / 3.0,
          fine.first_input + (fine.first_input - coarse.first_input) / 3.0};
}

void expect_agreement(const OptimumDerivatives::Derivative& ours, const Resolved& resolved,
                      const std::string& what) {
  EXPECT_TRUE(ours.reliable) << what << ": " << ours.message;
  EXPECT_LT(ours.difference_error, 1e-9) << what;
  EXPECT_NEAR(ours.cost, resolved.cost, 1e-6 * (1e-2 + std::abs(resolved.cost))) << what;
  ASSERT_EQ(ours.first_input.size(), resolved.first_input.size()) << what;
  for (int i = 0; i < ours.first_input.size(); ++i)
    EXPECT_NEAR(ours.first_input[i], resolved.first_input[i],
                1e-5 * (1e-1 + resolved.first_input.cwiseAbs().maxCoeff()))
        << what << ", input " << i;
}

}  // namespace saltus::testing_support
