// Interval bounds of formulas along a piece of time contain all values of the formula there.
#include "saltus/verify/formula_bounds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/random.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/model/steps_of.hpp"

namespace saltus {
namespace {

struct EveryOperation {
  template <class S>
  Vec<S, 18> operator()(const S& t, const Vec<S, 2>& x) const {
    const S a = x[0], b = x[1];
    return {a + b * t,
            a * b - a / (b + 4.0),
            sin(a) * cos(b),
            tan(0.3 * a),
            asin(0.3 * a) + acos(0.3 * b),
            atan(a * b),
            sinh(a) - cosh(b),
            tanh(2.0 * a),
            exp(-a * a / 0.01),
            log(4.0 + a),
            sqrt(4.0 + b),
            abs(a),
            min(a, b),
            max(a * a, b),
            atan2(a, b),
            hypot(a, b),
            pow(a, 3.0) + pow(4.0 + b, 1.5),
            -a};
  }
};

// x follows parabolas, and the box contains one piece of them.
TEST(FormulaBounds, ContainValuesAndDerivatives) {
  const Function f = make_function<2, 0, 0>(EveryOperation{});
  FormulaBounds bounds(steps_of(f));
  Random random(7);
  int unbounded = 0;
  for (int round = 0; round < 2000; ++round) {
    const double r = std::pow(10.0, random.uniform(-4.0, 0.0));
    double c[2][3];
    for (auto& row : c)
      for (double& v : row) v = random.uniform(-1.0, 1.0);
    const auto jet_at = [&](double d) {
      std::vector<TimeJet<double>> z(3);
      z[0] = {d, 1.0, 0.0};
      for (int i = 0; i < 2; ++i)
        z[1 + i] = {c[i][0] + d * (c[i][1] + d * c[i][2]), c[i][1] + 2.0 * d * c[i][2],
                    2.0 * c[i][2]};
      return z;
    };
    std::vector<TimeJet<Interval>> box(3);
    box[0] = {{-r, r}, 1.0, 0.0};
    for (int i = 0; i < 2; ++i) {
      const double a = std::abs(c[i][1]) * r;
      const Interval square{std::min(0.0, c[i][2] * r * r), std::max(0.0, c[i][2] * r * r)};
      box[1 + i].value = {c[i][0] - a + square.lower, c[i][0] + a + square.upper};
      box[1 + i].first = {c[i][1] - 2.0 * std::abs(c[i][2]) * r,
                          c[i][1] + 2.0 * std::abs(c[i][2]) * r};
      box[1 + i].second = 2.0 * c[i][2];
    }
    bounds.evaluate(box);
    for (int k = 0; k < 9; ++k) {
      const double d = random.uniform(-r, r);
      const auto z = jet_at(d);
      bounds.evaluate(z);
      const VectorXd value = f(VectorXd{{z[0].value, z[1].value, z[2].value}});
      // Differences of the first derivative match the second derivative.
      for (int o = 0; o < bounds.outputs(); ++o) {
        const auto& b = bounds.bounds(o);
        const auto& at = bounds.at(o);
        const double slack = 1e-9 * (1.0 + std::abs(at.value));
        EXPECT_NEAR(at.value, value[o], slack) << o;
        EXPECT_GE(at.value, b.value.lower - slack) << o;
        EXPECT_LE(at.value, b.value.upper + slack) << o;
        const double slope = 1e-9 * (1.0 + std::abs(at.first));
        EXPECT_GE(at.first, b.first.lower - slope) << o;
        EXPECT_LE(at.first, b.first.upper + slope) << o;
        const double curvature = 1e-9 * (1.0 + std::abs(at.second));
        EXPECT_GE(at.second, b.second.lower - curvature) << o;
        EXPECT_LE(at.second, b.second.upper + curvature) << o;
        if (!std::isfinite(b.value.upper)) ++unbounded;
      }
    }
  }
  EXPECT_EQ(unbounded, 0);
}

TEST(FormulaBounds, DerivativesMatchDifferences) {
  const Function f = make_function<2, 0, 0>(EveryOperation{});
  FormulaBounds bounds(steps_of(f));
  const auto along = [&](double d) {
    std::vector<TimeJet<double>> z(3);
    z[0] = {d, 1.0, 0.0};
    z[1] = {0.3 + 0.5 * d - 0.2 * d * d, 0.5 - 0.4 * d, -0.4};
    z[2] = {-0.4 + 0.7 * d + 0.6 * d * d, 0.7 + 1.2 * d, 1.2};
    bounds.evaluate(z);
    std::vector<TimeJet<double>> y;
    for (int o = 0; o < bounds.outputs(); ++o) y.push_back(bounds.at(o));
    return y;
  };
  constexpr double h = 1e-5;
  const auto before = along(-h), here = along(0.0), after = along(h);
  for (int o = 0; o < bounds.outputs(); ++o) {
    EXPECT_NEAR((after[o].value - before[o].value) / (2.0 * h), here[o].first,
                1e-6 * (1.0 + std::abs(here[o].first)))
        << o;
    EXPECT_NEAR((after[o].first - before[o].first) / (2.0 * h), here[o].second,
                1e-5 * (1.0 + std::abs(here[o].second)))
        << o;
  }
}

}  // namespace
}  // namespace saltus
