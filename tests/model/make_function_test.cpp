// Tests that formulas of every shape become functions with right values, derivatives and exact
// patterns.
#include "saltus/model/make_function.hpp"

#include <gtest/gtest.h>

#include "saltus/model/derivative_check.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

SparsityPattern pattern(int rows, int cols, std::vector<std::pair<int, int>> pairs) {
  return SparsityPattern::from_pairs(rows, cols, std::move(pairs));
}

struct Car {
  double thrust = 6.0;  // m/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], thrust * u[0] - 0.01 * x[1] * x[1]};
  }
};

// z = (t | px, angle | force | length): every argument interacts with another.
struct Everything {
  template <class S>
  Vec<S, 3> operator()(const S& t, const Vec<S, 2>& x, const Vec<S, 1>& u,
                       const Vec<S, 1>& p) const {
    return {sin(x[1]) * p[0] + t, u[0] * u[0] / p[0] + pow(x[0], 3), atan2(x[0], x[1]) * t};
  }
};

TEST(MakeFunction, AcceptsAFunctorOfTimeStateAndInput) {
  const Function f = make_function<2, 1, 0>(Car{});
  EXPECT_EQ(f.inputs(), 4);
  EXPECT_EQ(f.outputs(), 2);
  EXPECT_EQ(f(Eigen::Vector4d(0, 1, 2, 3)), Eigen::Vector2d(2.0, 18.0 - 0.04));
  EXPECT_EQ(f.jacobian_pattern(), pattern(2, 4, {{0, 2}, {1, 2}, {1, 3}}));
  EXPECT_EQ(f.hessian_pattern(), pattern(4, 4, {{2, 2}}));
  static_assert(outputs_of<2, 1, 0, Car> == 2);
}

TEST(MakeFunction, AcceptsAllArguments) {
  const Function f = make_function<2, 1, 1>(Everything{});
  EXPECT_EQ(f.jacobian_pattern(), pattern(3, 5,
                                          {{0, 0},
                                           {0, 2},
                                           {0, 4},  //
                                           {1, 1},
                                           {1, 3},
                                           {1, 4},  //
                                           {2, 0},
                                           {2, 1},
                                           {2, 2}}));
  EXPECT_EQ(
      f.hessian_pattern(),
      pattern(5, 5, {{2, 2}, {4, 2}, {3, 3}, {4, 3}, {4, 4}, {1, 1}, {2, 1}, {1, 0}, {2, 0}}));
  const VectorXd lower = VectorXd::Constant(5, 0.3), upper = VectorXd::Constant(5, 2.0);
  const DerivativeReport report = check_derivatives(f, lower, upper, 20, 1);
  EXPECT_TRUE(report.ok) << report;
}

TEST(MakeFunction, AcceptsLambdasOfEveryArityAndResult) {
  EXPECT_EQ((make_function<2, 0, 0>([](const auto&, const auto& x) { return x[0] * x[1]; })(
                Eigen::Vector3d(0, 2, 3)))[0],
            6.0);
  EXPECT_EQ((make_function<1, 1, 0>([](auto, auto x, auto u) { return x[0] - u[0]; })(
                Eigen::Vector3d(0, 2, 3)))[0],
            -1.0);
  EXPECT_EQ((make_function<1, 0, 1>([](auto t, auto x, auto, auto p) { return t + x[0] * p[0]; })(
                Eigen::Vector3d(1, 2, 3)))[0],
            7.0);
  EXPECT_EQ((make_function<0, 0, 0>([](auto t, auto) { return t; })(VectorXd::Ones(1)))[0], 1.0);
}

TEST(MakeFunction, ConstantsHaveEmptyPatterns) {
  const Function number = make_function<2, 0, 0>([](auto, const auto&) { return 3.5; });
  const Function integer = make_function<2, 0, 0>([](auto, const auto&) { return 2; });
  const Function vector =
      make_function<2, 0, 0>([](auto, const auto&) { return Eigen::Vector3d(1, 2, 3); });
  const Function zero =
      make_function<2, 0, 0>([](auto, const auto&) { return Eigen::Vector3d::Zero(); });
  const Eigen::Vector3d z(0, 1, 2);
  EXPECT_EQ(number(z)[0], 3.5);
  EXPECT_EQ(integer(z)[0], 2.0);
  EXPECT_EQ(vector(z), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(zero(z), Eigen::Vector3d(0, 0, 0));
  for (const Function& f : {number, integer, vector, zero}) {
    EXPECT_EQ(f.jacobian_pattern().entries(), 0);
    EXPECT_EQ(f.hessian_pattern().entries(), 0);
    EXPECT_EQ(f.dense_jacobian(z).norm(), 0.0);
    EXPECT_EQ(f.dense_hessian(z, VectorXd::Ones(f.outputs())).norm(), 0.0);
  }
}

TEST(MakeFunction, ZerosOfAModelMatrixAreZerosOfThePattern) {
  Eigen::Matrix<double, 9, 9> a = Eigen::Matrix<double, 9, 9>::Zero();
  a(0, 8) = 2.0;
  a(5, 3) = -1.0;
  const Function f =
      make_function<9, 0, 0>([a](const auto&, const auto& x) { return (a * x).eval(); });
  EXPECT_EQ(f.jacobian_pattern(), pattern(9, 10, {{0, 9}, {5, 4}}));
  EXPECT_TRUE(is_affine_in(f, 0, 10));
}

// Dense and wide: Jacobian and Hessian need more directions than one pass has lanes.
TEST(MakeFunction, HandlesManyPasses) {
  const Function f = make_function<20, 5, 2>([](const auto& t, const auto& x, const auto& u,
                                                const auto& p) {
    using S = std::decay_t<decltype(t)>;
    const S all = x.sum() + 2.0 * u.sum() * p[0] + t;
    return Vec<S, 3>(sin(all) * p[1], x.squaredNorm() * u[2], exp(0.1 * x[3] * x[19]) + u.norm());
  });
  EXPECT_EQ(f.hessian_pattern().entries(), 28 * 29 / 2 - 1);  // p[1] alone enters linearly
  const VectorXd lower = VectorXd::Constant(28, -0.9), upper = VectorXd::Constant(28, 1.1);
  const DerivativeReport report = check_derivatives(f, lower, upper, 3, 7);
  EXPECT_TRUE(report.ok) << report;
}

TEST(MakeFunction, TheThreeEvaluationsAgreeOnY) {
  const Function f = make_function<2, 1, 1>(Everything{});
  const VectorXd z = VectorXd::LinSpaced(5, 0.3, 1.7);
  VectorXd y(3);
  std::vector<double> entries(f.jacobian_pattern().entries());
  f.jacobian(z.data(), y.data(), entries.data());
  EXPECT_LT((y - f(z)).norm(), 1e-15 * y.norm());  // the compiler may contract differently
}

TEST(MakeFunction, BothCurvaturesAreTheFullHessian) {
  const Function f = make_function<2, 1, 1>(Everything{});
  const VectorXd z = VectorXd::LinSpaced(5, 0.3, 1.7), w = VectorXd::LinSpaced(3, 1.0, 2.0);
  EXPECT_EQ(f.dense_hessian(z, w, Curvature::exact),
            f.dense_hessian(z, w, Curvature::gauss_newton));
}

TEST(MakeFunction, EvaluationDoesNotAllocate) {
  const Function f = make_function<2, 1, 1>(Everything{});
  const VectorXd z = VectorXd::LinSpaced(5, 0.3, 1.7), w = VectorXd::Ones(3);
  VectorXd y(3);
  std::vector<double> jacobian(f.jacobian_pattern().entries());
  std::vector<double> hessian(f.hessian_pattern().entries());
  testing::AllocationCount count;
  f.value(z.data(), y.data());
  f.jacobian(z.data(), y.data(), jacobian.data());
  f.hessian(z.data(), w.data(), hessian.data());
  EXPECT_EQ(count.made(), 0);
  const VectorXd copied = z;
  EXPECT_GT(count.made(), 0) << "the counter sees Eigen's memory too";
  EXPECT_EQ(copied.size(), 5);
}

TEST(Structure, ReportsAffinityAndDependence) {
  const Function f =
      make_function<2, 1, 1>([](const auto& t, const auto& x, const auto& u, const auto& p) {
        using S = std::decay_t<decltype(t)>;
        return Vec<S, 2>(p[0] * x[0] + sin(t) * x[1] + u[0], x[0] + abs(u[0]));
      });
  const Arguments a{2, 1, 1};
  EXPECT_TRUE(is_affine_in(f, a.x(), 2));
  EXPECT_FALSE(is_affine_in(f, a.x(), 3)) << "abs is not affine";
  EXPECT_TRUE(is_affine_in(f, a.p(), 1));
  EXPECT_FALSE(is_affine_in(f, a.t(), 1));
  EXPECT_FALSE(is_affine_in(f, 0, a.size()));
  EXPECT_TRUE(depends_on(f, a.t()));
  EXPECT_TRUE(depends_on(f, 0, a.p()));
  EXPECT_FALSE(depends_on(f, 1, a.p()));
  EXPECT_FALSE(depends_on(make_function<2, 1, 0>(Car{}), a.t()));
}

}  // namespace
}  // namespace saltus

// A formula outside the namespace with an unqualified abs. For a plain double, this would be the
// integer abs of the C library.
TEST(MakeFunction, UnqualifiedFunctionsAreOurs) {
  const saltus::Function f = saltus::make_function<1, 0, 0>([](const auto&, const auto& x) {
    return abs(x[0]) + max(x[0], 0.25) + select(x[0], 1.0, 2.0);
  });
  EXPECT_EQ(f(Eigen::Vector2d(0.0, -0.5))[0], 2.75);
}
