// Tests that derivatives from recorded steps equal those of dual numbers, and that make_function()
// uses them where they take fewer operations.
#include "saltus/model/recorded_derivatives.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "saltus/core/random.hpp"
#include "saltus/model/derivative_check.hpp"
#include "saltus/model/make_function.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

using detail::RecordedDerivatives;

// Rounding error of a few hundred operations in another order.
constexpr double rounding = 1e-12;

// Compares values and derivatives with those of a function that is too small to be recorded.
void expect_same(const Function& f, const VectorXd& z) {
  ASSERT_TRUE(f.separate().is(f)) << "the function must evaluate dual numbers";
  const RecordedDerivatives recorded(*f.steps(), f.jacobian_pattern(), f.hessian_pattern(), {});
  ASSERT_TRUE(recorded.is_complete());
  RecordedDerivatives::Workspace w = recorded.workspace();
  VectorXd weights(f.outputs());
  for (int i = 0; i < f.outputs(); ++i) weights[i] = 1.0 + 0.3 * i;
  VectorXd y(f.outputs()), jacobian(f.jacobian_pattern().entries());
  VectorXd hessian(f.hessian_pattern().entries());
  const auto derivatives = [&](bool together) {
    // An entry that is not written remains NaN.
    for (VectorXd* v : {&y, &jacobian, &hessian}) v->setConstant(std::nan(""));
    if (together) {
      recorded.derivatives(z.data(), weights.data(), y.data(), jacobian.data(), hessian.data(), w);
    } else {
      recorded.jacobian(z.data(), y.data(), jacobian.data(), w);
      recorded.hessian(z.data(), weights.data(), hessian.data(), w);
    }
  };
  const VectorXd value = f(z);
  const MatrixXd first = f.dense_jacobian(z), second = f.dense_hessian(z, weights);
  for (const bool together : {false, true}) {
    derivatives(together);
    const auto expect_near = [&](double found, double expected) {
      EXPECT_NEAR(found, expected, rounding * (1.0 + std::abs(expected)));
    };
    for (int i = 0; i < f.outputs(); ++i) expect_near(y[i], value[i]);
    f.jacobian_pattern().for_each([&](int r, int c, int e) {
      SCOPED_TRACE(::testing::Message() << "Jacobian " << r << ", " << c);
      expect_near(jacobian[e], first(r, c));
    });
    f.hessian_pattern().for_each([&](int r, int c, int e) {
      SCOPED_TRACE(::testing::Message() << "Hessian " << r << ", " << c);
      expect_near(hessian[e], second(r, c));
    });
  }
}

// Every function that can be recorded, applied to a sum, which has second derivatives in all pairs.
template <class F>
void expect_same_of(const F& f, double lower, double upper) {
  const Function function =
      make_function<2, 0, 0>([f](const auto& t, const auto& x) { return f(x[0] + 0.5 * t, x[1]); });
  Random random(1);
  for (int k = 0; k < 10; ++k) {
    VectorXd z(3);
    for (int i = 0; i < 3; ++i) z[i] = random.uniform(lower, upper);
    expect_same(function, z);
  }
}

TEST(RecordedDerivatives, OfElementaryFunctions) {
  expect_same_of([](const auto& a, const auto& b) { return a / b - 3.0 / a + b / 4.0; }, 0.3, 2.0);
  expect_same_of([](const auto& a, const auto& b) { return sin(a) * cos(b) - cos(a * b); }, -2, 2);
  expect_same_of([](const auto& a, const auto& b) { return tan(a) * b; }, -0.7, 0.7);
  expect_same_of([](const auto& a, const auto& b) { return asin(a) * acos(b); }, -0.6, 0.6);
  expect_same_of([](const auto& a, const auto& b) { return atan(a) - atan(a * b); }, -2.0, 2.0);
  expect_same_of([](const auto& a, const auto& b) { return sinh(a) * cosh(b); }, -2.0, 2.0);
  expect_same_of([](const auto& a, const auto& b) { return tanh(a) * b; }, -2.0, 2.0);
  expect_same_of([](const auto& a, const auto& b) { return exp(a) * b; }, -2.0, 2.0);
  expect_same_of([](const auto& a, const auto& b) { return log(a) * b; }, 0.3, 2.0);
  expect_same_of([](const auto& a, const auto& b) { return sqrt(a) * b; }, 0.3, 2.0);
  expect_same_of([](const auto& a, const auto& b) { return abs(a) * b; }, -2.0, 2.0);
  expect_same_of([](const auto& a, const auto& b) { return atan2(a, b) + atan2(b, b * b); }, -2, 2);
  expect_same_of([](const auto& a, const auto& b) { return hypot(a, b) + hypot(a, a); }, -2.0, 2.0);
  expect_same_of(
      [](const auto& a, const auto& b) {
        return pow(a, 3) + pow(a, 2) * b + pow(b, 2.5) + pow(a, 0.5) + pow(b, -1.5) + pow(b, 1);
      },
      0.3, 2.0);
}

// Dual numbers replace infinite derivatives by zero.
TEST(RecordedDerivatives, AreFiniteWhereThoseOfDualNumbersAre) {
  const Function f = make_function<2, 0, 0>([](const auto& t, const auto& x) {
    using S = std::decay_t<decltype(t)>;
    return Vec<S, 8>(sqrt(x[0]), norm(x), hypot(x[0], x[1]), atan2(x[0], x[1]), abs(x[0]),
                     pow(x[0], 0.5) + pow(x[1], 1.5), asin(1.0 + x[0]), acos(x[1] - 1.0));
  });
  expect_same(f, VectorXd::Zero(3));
}

TEST(RecordedDerivatives, OfTallWideAndSharedOutputs) {
  expect_same(make_function<1, 0, 0>([](const auto& t, const auto& x) {
                using S = std::decay_t<decltype(t)>;
                Vec<S, 20> y;
                for (int i = 0; i < 20; ++i) y[i] = sin(x[0] * (1.0 + i)) * t;
                return y;
              }),
              VectorXd::LinSpaced(2, 0.3, 0.8));
  expect_same(make_function<9, 0, 0>([](const auto& t, const auto& x) {
                return sin(x.head(3).sum() * x[8]) + x.squaredNorm() * t;
              }),
              VectorXd::LinSpaced(10, -0.9, 1.3));
  // Equal outputs, an output that is an input, multiples, constants, and an input without effect.
  expect_same(make_function<4, 1, 0>([](const auto& t, const auto& x, const auto& u) {
                using S = std::decay_t<decltype(t)>;
                const S product = x[0] * x[1];
                return Vec<S, 9>(product, product, x[2], x[2], -x[2], 2.0 * product, S(0.5),
                                 u[0] * u[0] - 3.0, (product + x[0]) - product);
              }),
              VectorXd::LinSpaced(6, -0.9, 1.3));
}

// A branch that is not taken may be NaN, and zero times NaN is NaN.
TEST(RecordedDerivatives, ExcludeFormulasWithBranches) {
  const auto is_complete = [](const Function& f) {
    return RecordedDerivatives(*f.steps(), f.jacobian_pattern(), f.hessian_pattern(), {})
        .is_complete();
  };
  const auto made = [](auto f) {
    return make_function<2, 0, 0>([f](const auto&, const auto& x) { return f(x[0], x[1]); });
  };
  EXPECT_TRUE(is_complete(made([](const auto& a, const auto& b) { return a * b; })));
  EXPECT_FALSE(is_complete(made([](const auto& a, const auto& b) { return min(a, b); })));
  EXPECT_FALSE(is_complete(made([](const auto& a, const auto& b) { return max(a, b); })));
  EXPECT_FALSE(is_complete(made([](const auto& a, const auto& b) { return pow(a, b); })));
  EXPECT_FALSE(
      is_complete(made([](const auto& a, const auto& b) { return select(a, sqrt(b), a); })));
}

// A chain of links: positions of all joints depend on all angles before them.
struct Chain {
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 12>& x) const {
    Vec<S, 3> end = Vec<S, 3>::Zero();
    S angle(0.0);
    for (int i = 0; i < 12; ++i) {
      angle += x[i];
      end[0] += 0.1 * cos(angle);
      end[1] += 0.1 * sin(angle);
      end[2] += end[0] * end[1] * x[i];
    }
    return end;
  }
};

TEST(RecordedDerivatives, ReplaceManyPassesOfDualNumbers) {
  const Function f = make_function<12, 0, 0>(Chain{});
  EXPECT_FALSE(f.separate().is(f)) << "a recorded function has a workspace";
  const DerivativeReport report =
      check_derivatives(f, VectorXd::Constant(13, -1.0), VectorXd::Constant(13, 1.0), 5, 1);
  EXPECT_TRUE(report.ok) << report;
  // A small formula keeps its dual numbers.
  const Function small =
      make_function<2, 0, 0>([](const auto&, const auto& x) { return sin(x[0]) * x[1] * x[1]; });
  EXPECT_TRUE(small.separate().is(small));
}

TEST(RecordedDerivatives, DoNotAllocate) {
  const Function f = make_function<12, 0, 0>(Chain{});
  const Function own = f.separate();
  EXPECT_TRUE(f.is_reentrant());
  EXPECT_FALSE(own.is_reentrant());
  const VectorXd z = VectorXd::LinSpaced(13, -0.5, 0.9), w = VectorXd::Ones(3);
  VectorXd y(3), jacobian(f.jacobian_pattern().entries()), hessian(f.hessian_pattern().entries());
  testing::AllocationCount count;
  for (const Function* function : {&f, &own}) {
    function->jacobian(z.data(), y.data(), jacobian.data());
    function->hessian(z.data(), w.data(), hessian.data());
    function->derivatives(z.data(), w.data(), y.data(), jacobian.data(), hessian.data(),
                          Curvature::exact);
  }
  EXPECT_EQ(count.made(), 0);
}

TEST(RecordedDerivatives, AreEqualInAllThreads) {
  const Function f = make_function<12, 0, 0>(Chain{});
  const VectorXd w = VectorXd::Ones(3);
  const auto z = [](int k) { return VectorXd::LinSpaced(13, -0.5, 0.1 * k).eval(); };
  constexpr int points = 20;
  std::vector<MatrixXd> expected(points);
  for (int k = 0; k < points; ++k) expected[k] = f.dense_hessian(z(k), w);
  std::vector<int> differences(6, 0);  // more threads than kept workspaces
  std::vector<std::thread> threads;
  threads.reserve(differences.size());
  for (int& different : differences)
    threads.emplace_back([&] {
      for (int k = 0; k < points; ++k)
        if (f.dense_hessian(z(k), w) != expected[k]) ++different;
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(differences, std::vector<int>(6, 0));
}

}  // namespace
}  // namespace saltus
