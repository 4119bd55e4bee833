// Laws that hold for every dual number of any width and nesting.
#include "saltus/autodiff/dual.hpp"

#include <gtest/gtest.h>

#include "saltus/autodiff/math.hpp"
#include "tests/autodiff/compare_scalars.hpp"

namespace saltus {
namespace {

template <class S>
class Laws : public ::testing::Test {};
using Scalars = ::testing::Types<double, Dual<double, 0>, Dual<double, 1>, Dual<double, 3>,
                                 Dual<double, 8>, Dual<double, 11>, Dual<Dual<double, 4>, 1>>;
TYPED_TEST_SUITE(Laws, Scalars);

TYPED_TEST(Laws, HoldForRingAndDivision) {
  using S = TypeParam;
  const S a = number<S>(0.7), b = number<S>(1.9), c = number<S>(-0.4);
  expect_same<S>(a + b, b + a);
  expect_same<S>(a * b, b * a);
  expect_same<S>(a * (b + c), a * b + a * c);
  expect_same<S>(a - b, -(b - a));
  expect_same<S>((a / b) * b, a);
  expect_same<S>(a / b, a * (1.0 / b));
  expect_same<S>(a / 4, 0.25 * a);
  expect_same<S>(a * 3, a + a + a);
  expect_same<S>(2 - a, -(a - 2));
  expect_same<S>(2 + a, a + 2.0);
  S d = a;
  d += b;
  d *= c;
  d -= a;
  d /= b;
  expect_same<S>(d, ((a + b) * c - a) / b);
  d = a;
  d += 1;
  d *= 2;
  d -= 3;
  d /= 4;
  expect_same<S>(d, ((a + 1.0) * 2.0 - 3.0) / 4.0);
}

TYPED_TEST(Laws, HoldForFunctionsAndTheirInverses) {
  using S = TypeParam;
  const S a = number<S>(0.7), b = number<S>(1.9);
  const double loose = 1e-12;  // third derivatives of the nested types amplify rounding
  expect_same<S>(square(S(saltus::sin(a))) + square(S(saltus::cos(a))), S(1.0), loose);
  expect_same<S>(saltus::tan(a), saltus::sin(a) / saltus::cos(a), loose);
  expect_same<S>(saltus::exp(S(saltus::log(b))), b, loose);
  expect_same<S>(square(S(saltus::sqrt(b))), b, loose);
  expect_same<S>(saltus::sin(S(saltus::asin(a))), a, loose);
  expect_same<S>(saltus::cos(S(saltus::acos(a))), a, loose);
  expect_same<S>(saltus::tan(S(saltus::atan(a))), a, loose);
  expect_same<S>(saltus::atan2(a, b), saltus::atan(S(a / b)), loose);
  expect_same<S>(saltus::tanh(a), saltus::sinh(a) / saltus::cosh(a), loose);
  expect_same<S>(square(S(saltus::cosh(a))) - square(S(saltus::sinh(a))), S(1.0), loose);
  expect_same<S>(saltus::pow(b, 3), cube(b), loose);
  expect_same<S>(saltus::pow(b, -2), 1.0 / (b * b), loose);
  expect_same<S>(saltus::pow(b, 0.5), saltus::sqrt(b), loose);
  expect_same<S>(saltus::pow(b, a), saltus::exp(S(a * saltus::log(b))), loose);
  expect_same<S>(saltus::pow(3.0, a), saltus::exp(S(a * std::log(3.0))), loose);
  expect_same<S>(saltus::hypot(a, b), saltus::sqrt(S(a * a + b * b)), loose);
  expect_same<S>(saltus::max(a, b) + saltus::min(a, b), a + b);
  expect_same<S>(saltus::max(a, -a), saltus::abs(a));
  expect_same<S>(saltus::abs(S(-b)), b);
  expect_same<S>(select(a - b, a, b), saltus::max(a, b));
  expect_same<S>(select(b - a, 1.0, a), S(1.0));
  expect_same<S>(smooth_max(a, b, 0.1) + smooth_min(a, b, 0.1), a + b, loose);
  expect_same<S>(smooth_step(a, 0.5) + smooth_step(S(-a), 0.5), S(1.0), loose);
}

TEST(Dual, NestingGivesSecondDerivatives) {
  // y = x1^2 sin(x2): H = [2 sin, 2 x1 cos; 2 x1 cos, -x1^2 sin]
  using Inner = Dual<double, 2>;
  using S = Dual<Inner, 2>;
  const double x1 = 1.3, x2 = 0.4;
  S a = S(Inner(x1, Inner::Tangent::unit(0)), S::Tangent::zero());
  S b = S(Inner(x2, Inner::Tangent::unit(1)), S::Tangent::zero());
  a.tangent.set(0, Inner(1.0));
  b.tangent.set(1, Inner(1.0));
  const S y = a * a * sin(b);
  EXPECT_NEAR(y.tangent[0].tangent[0], 2 * std::sin(x2), rounding);
  EXPECT_NEAR(y.tangent[0].tangent[1], 2 * x1 * std::cos(x2), rounding);
  EXPECT_NEAR(y.tangent[1].tangent[0], 2 * x1 * std::cos(x2), rounding);
  EXPECT_NEAR(y.tangent[1].tangent[1], -x1 * x1 * std::sin(x2), 2 * rounding);
}

TEST(Dual, ConstantsConvertImplicitlyAndDualsDoNotConvertBack) {
  using S = Dual<double, 3>;
  static_assert(std::is_convertible_v<double, S> && std::is_convertible_v<int, S>);
  static_assert(!std::is_convertible_v<S, double>);  // message: see refused.cpp
  static_assert(!std::is_constructible_v<bool, S>);
  const S c = 2;
  EXPECT_EQ(c.value, 2.0);
  EXPECT_EQ(c.tangent[2], 0.0);
}

}  // namespace
}  // namespace saltus
