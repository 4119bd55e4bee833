// Tests that a function made from recorded steps equals the function that was recorded.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>
#include <vector>

#include "saltus/core/random.hpp"
#include "saltus/model/derivative_check.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/model/steps_of.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

// Rounding error of a few operations in another order.
constexpr double rounding = 1e-12;

void expect_same(const Function& given, const Function& made, const VectorXd& z) {
  ASSERT_EQ(made.inputs(), given.inputs());
  ASSERT_EQ(made.outputs(), given.outputs());
  EXPECT_EQ(made.jacobian_pattern(), given.jacobian_pattern());
  EXPECT_EQ(made.hessian_pattern(), given.hessian_pattern());
  VectorXd weights(given.outputs());
  for (int i = 0; i < given.outputs(); ++i) weights[i] = 1.0 + 0.3 * i;
  EXPECT_LE((made(z) - given(z)).cwiseAbs().maxCoeff(), rounding);
  EXPECT_LE((made.dense_jacobian(z) - given.dense_jacobian(z)).cwiseAbs().maxCoeff(), rounding);
  EXPECT_LE(
      (made.dense_hessian(z, weights) - given.dense_hessian(z, weights)).cwiseAbs().maxCoeff(),
      rounding);
}

// Every operation that can be differentiated as a graph.
struct Smooth {
  template <class S>
  Vec<S, 3> operator()(const S& t, const Vec<S, 3>& x, const Vec<S, 1>& u) const {
    return {sin(x[0]) * cos(x[1]) / (2.0 + u[0] * u[0]) - tan(t) + sinh(x[2]) * cosh(u[0]),
            exp(-x[0] * x[1]) + log(2.0 + x[2]) * sqrt(3.0 + x[0]) + tanh(u[0]) - atan(x[1]) +
                asin(0.1 * x[0]) + acos(0.1 * x[2]),
            atan2(x[0], x[1]) + hypot(x[1], u[0]) + pow(2.0 + x[2], 1.5) + abs(x[0])};
  }
};

// Operations with branches.
struct Branches {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 1>& u) const {
    return {min(x[0] * x[1], u[0]) + max(x[2] * x[2], x[0]),
            select(x[0], x[1] * u[0], sin(x[2])) + pow(2.0 + x[0] * x[0], x[1])};
  }
};

TEST(StepsFunction, EqualsTheRecordedFormula) {
  const Function smooth = make_function<3, 1, 0>(Smooth{}),
                 branches = make_function<3, 1, 0>(Branches{});
  Random random(7);
  for (int k = 0; k < 5; ++k) {
    VectorXd z(5);
    for (double& entry : z) entry = random.uniform(-0.9, 0.9);
    expect_same(smooth, function_of(*smooth.steps()), z);
    expect_same(branches, function_of(*branches.steps()), z);
  }
}

TEST(StepsFunction, HasConstantAndAffineRows) {
  const auto rows = [](auto t, auto x) { return decltype(x){decltype(t)(3.0), 2.0 * x[0] - t}; };
  const Function given = make_function<2, 0, 0>(rows);
  expect_same(given, function_of(*given.steps()), VectorXd{{0.1, 0.2, 0.3}});
}

TEST(StepsFunction, SeparateCopiesDoNotAllocate) {
  for (const Function& given :
       {make_function<3, 1, 0>(Smooth{}), make_function<3, 1, 0>(Branches{})}) {
    const Function made = function_of(*given.steps()).separate();
    const VectorXd z{{0.1, 0.2, 0.3, 0.4, 0.5}}, weights = VectorXd::Ones(made.outputs());
    VectorXd y(made.outputs()), jacobian(made.jacobian_pattern().entries()),
        hessian(made.hessian_pattern().entries());
    const saltus::testing::AllocationCount count;
    made.value(z.data(), y.data());
    made.derivatives(z.data(), weights.data(), y.data(), jacobian.data(), hessian.data(),
                     Curvature::exact);
    EXPECT_EQ(count.made(), 0);
  }
}

TEST(StepsFunction, ThreadsShareOneFunction) {
  const Function given = make_function<3, 1, 0>(Branches{}), made = function_of(*given.steps());
  constexpr int count = 6;
  std::vector<std::thread> threads;
  threads.reserve(count);
  for (int k = 0; k < count; ++k)
    threads.emplace_back([&, k] {
      const VectorXd z{{0.1 * k, 0.2, 0.3, 0.4, 0.5}};
      for (int i = 0; i < 200; ++i) EXPECT_EQ(made.dense_jacobian(z), given.dense_jacobian(z));
    });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace saltus
