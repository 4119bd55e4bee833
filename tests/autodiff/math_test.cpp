// Compares every elementary function with finite differences, and tests the conventions where
// derivatives do not exist.
#include "saltus/autodiff/math.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <initializer_list>

#include "saltus/core/types.hpp"

namespace saltus {
namespace {

using First = Dual<double, 1>;
using Second = Dual<First, 1>;

First first(double x) { return {x, First::Tangent::unit(0)}; }
Second second(double x) {
  Second s(first(x), Second::Tangent::zero());
  s.tangent.set(0, First(1.0));
  return s;
}

// Value, first and second derivative of f at x.
struct Jet {
  double value, slope, curvature;
};
template <class F>
Jet jet(F f, double x) {
  const Second y = f(second(x));
  // Both directions are x; the compiler may contract one of them to a fused multiply-add.
  const double one = y.value.tangent[0], other = y.tangent[0].value;
  EXPECT_NEAR(one, other, 1e-15 * (1.0 + std::abs(one)));
  return {y.value.value, y.value.tangent[0], y.tangent[0].tangent[0]};
}

double slope(const std::function<double(double)>& g, double x) {
  const double h = 1e-3;  // truncation h^4 and rounding 1e-16 / h are both near 1e-12
  const auto central = [&](double s) { return (g(x + s) - g(x - s)) / (2 * s); };
  return (4 * central(h / 2) - central(h)) / 3;
}

template <class F>
void agrees_with_differences(const char* name, F f, std::initializer_list<double> points) {
  for (const double x : points) {
    SCOPED_TRACE(::testing::Message() << name << " at " << x);
    const Jet y = jet(f, x);
    const double tolerance = 1e-9;  // error of the differences, see slope()
    EXPECT_NEAR(y.value, f(x), 1e-15 * (1 + std::abs(y.value)));
    EXPECT_NEAR(y.slope, slope([&](double at) { return f(at); }, x),
                tolerance * (1 + std::abs(y.slope)));
    EXPECT_NEAR(y.curvature, slope([&](double at) { return f(first(at)).tangent[0]; }, x),
                tolerance * (1 + std::abs(y.curvature)));
  }
}

// Unqualified calls inside namespace saltus compile for double and for duals.
TEST(Math, FunctionsOfOneArgumentMatchDifferences) {
  agrees_with_differences("sin", [](auto x) { return sin(x); }, {-2.0, 0.0, 0.7, 3.0});
  agrees_with_differences("cos", [](auto x) { return cos(x); }, {-2.0, 0.0, 0.7, 3.0});
  agrees_with_differences("tan", [](auto x) { return tan(x); }, {-1.0, 0.0, 0.7, 3.0});
  agrees_with_differences("asin", [](auto x) { return asin(x); }, {-0.7, 0.0, 0.5});
  agrees_with_differences("acos", [](auto x) { return acos(x); }, {-0.7, 0.0, 0.5});
  agrees_with_differences("atan", [](auto x) { return atan(x); }, {-5.0, 0.0, 0.7});
  agrees_with_differences("sinh", [](auto x) { return sinh(x); }, {-2.0, 0.0, 0.7});
  agrees_with_differences("cosh", [](auto x) { return cosh(x); }, {-2.0, 0.0, 0.7});
  agrees_with_differences("tanh", [](auto x) { return tanh(x); }, {-2.0, 0.0, 0.7});
  agrees_with_differences("exp", [](auto x) { return exp(x); }, {-2.0, 0.0, 0.7});
  agrees_with_differences("log", [](auto x) { return log(x); }, {0.2, 1.0, 7.0});
  agrees_with_differences("sqrt", [](auto x) { return sqrt(x); }, {0.2, 1.0, 7.0});
  agrees_with_differences("abs", [](auto x) { return abs(x); }, {-2.0, -0.1, 0.7});
  agrees_with_differences("square", [](auto x) { return square(x); }, {-2.0, 0.0, 0.7});
  agrees_with_differences("cube", [](auto x) { return cube(x); }, {-2.0, 0.0, 0.7});
}

TEST(Math, PowersMatchDifferences) {
  for (int k = -3; k <= 4; ++k)
    agrees_with_differences("pow(x, int)", [k](auto x) { return pow(x, k); }, {-1.3, -0.5, 0.7, 2});
  for (int k = 0; k <= 4; ++k)
    agrees_with_differences("pow(0, int)", [k](auto x) { return pow(x, k); }, {0.0});
  for (double c : {-1.5, 0.0, 0.5, 1.0, 1.5, 2.0, 3.7})
    agrees_with_differences("pow(x, double)", [c](auto x) { return pow(x, c); }, {0.3, 1.0, 2.5});
  agrees_with_differences("pow(x, x)", [](auto x) { return pow(x, x); }, {0.3, 1.0, 2.5});
  agrees_with_differences("pow(c, x)", [](auto x) { return pow(2.5, x); }, {-1.0, 0.0, 2.0});
  agrees_with_differences("pow(x, unsigned)", [](auto x) { return pow(x, 2u); }, {-1.0, 0.0, 2.0});
}

TEST(Math, FunctionsOfTwoArgumentsMatchDifferences) {
  for (double b : {-1.5, 0.4, 2.0}) {
    SCOPED_TRACE(b);
    const auto points = {-1.1, 0.3, 2.2};
    agrees_with_differences(
        "atan2(x, b)", [b](auto x) { return atan2(x, b); }, points);
    agrees_with_differences(
        "atan2(b, x)", [b](auto x) { return atan2(b, x); }, points);
    agrees_with_differences(
        "hypot(x, b)", [b](auto x) { return hypot(x, b); }, points);
    agrees_with_differences(
        "hypot(b, x)", [b](auto x) { return hypot(b, x); }, points);
    agrees_with_differences(
        "min(x, b)", [b](auto x) { return min(x, b); }, points);
    agrees_with_differences(
        "max(b, x)", [b](auto x) { return max(b, x); }, points);
  }
  agrees_with_differences("atan2(x^2, sin x)", [](auto x) { return atan2(x * x, sin(x)); },
                          {-1.0, 0.5, 2.0});
  agrees_with_differences("hypot(x^2, sin x)", [](auto x) { return hypot(x * x, sin(x)); },
                          {-1.0, 0.5, 2.0});
  agrees_with_differences("atan2(x, 0)", [](auto x) { return atan2(x, 0.0); }, {-1.0, 2.0});
  agrees_with_differences("min(x^2, x)", [](auto x) { return min(x * x, x); }, {-1.0, 0.5, 2.0});
}

TEST(Math, SwitchesMatchDifferences) {
  agrees_with_differences("select", [](auto x) { return select(x, x * x, 3.0 * x); },
                          {-1.0, -0.01, 0.01, 2.0});
  agrees_with_differences("smooth_step", [](auto x) { return smooth_step(x, 0.3); },
                          {-1.0, 0.0, 0.1, 2.0});
  agrees_with_differences("smooth_abs", [](auto x) { return smooth_abs(x, 0.3); },
                          {-1.0, 0.0, 0.1, 2.0});
  agrees_with_differences("smooth_max", [](auto x) { return smooth_max(x, 0.5, 0.3); },
                          {-1.0, 0.0, 0.5, 2.0});
  agrees_with_differences("smooth_min", [](auto x) { return smooth_min(x * x, x, 0.3); },
                          {-1.0, 0.0, 0.5, 2.0});
  EXPECT_NEAR(smooth_step(0.46, 0.1), 1.0, 1.1e-4);  // the documented end
  EXPECT_EQ(smooth_abs(0.0, 0.3), 0.3);
  EXPECT_EQ(smooth_max(1.0, 1.0, 0.3), 1.15);
  EXPECT_EQ(select(0, 2.0, 3.0), 2.0);
  EXPECT_EQ(select(std::nan(""), 2.0, 3.0), 3.0);
}

// Conventions where the derivative does not exist or is infinite; see the top of math.hpp.
template <class F>
void is(const char* name, F f, double x, Jet expected) {
  SCOPED_TRACE(name);
  const Jet y = jet(f, x);
  EXPECT_EQ(y.value, expected.value);
  EXPECT_EQ(y.slope, expected.slope);
  EXPECT_EQ(y.curvature, expected.curvature);
}

TEST(Math, FollowsTheConventionsAtKinks) {
  is("abs(0)", [](auto x) { return abs(x); }, 0.0, {0, 0, 0});
  is("sqrt(0)", [](auto x) { return sqrt(x); }, 0.0, {0, 0, 0});
  is("sqrt(x^2) at 0", [](auto x) { return sqrt(x * x); }, 0.0, {0, 0, 0});
  is("hypot(0, 0)", [](auto x) { return hypot(x, 2.0 * x); }, 0.0, {0, 0, 0});
  is("atan2(0, 0)", [](auto x) { return atan2(x, x); }, 0.0, {0, 0, 0});
  is("asin(1)", [](auto x) { return asin(x); }, 1.0, {std::asin(1.0), 0, 0});
  is("acos(-1)", [](auto x) { return acos(x); }, -1.0, {std::acos(-1.0), 0, 0});
  is("pow(0, 0.5)", [](auto x) { return pow(x, 0.5); }, 0.0, {0, 0, 0});
  is("pow(0, 1.5)", [](auto x) { return pow(x, 1.5); }, 0.0, {0, 0, 0});
  is("pow(0, 0)", [](auto x) { return pow(x, 0); }, 0.0, {1, 0, 0});
  is("pow(0, 1)", [](auto x) { return pow(x, 1.0); }, 0.0, {0, 1, 0});
  is("pow(0, 2)", [](auto x) { return pow(x, 2.0); }, 0.0, {0, 0, 2});
  is("pow(x, 0) at -1", [](auto x) { return pow(x, 0); }, -1.0, {1, 0, 0});
  is("pow(-2, 3)", [](auto x) { return pow(x, 3); }, -2.0, {-8, 12, -12});
  is("pow(-2, 3.0) with an active exponent", [](auto x) { return pow(x, decltype(x)(3.0)); }, -2.0,
     {-8, 12, -12});
  is("pow(0, x)", [](auto x) { return pow(0.0, x); }, 2.0, {0, 0, 0});
  is("min at a tie", [](auto x) { return min(x, 3.0 * x); }, 0.0, {0, 2, 0});
  is("max at a tie", [](auto x) { return max(x, -x); }, 0.0, {0, 0, 0});
  is("max(x, 0) at 0", [](auto x) { return max(x, 0.0); }, 0.0, {0, 0.5, 0});
  is("select at 0", [](auto x) { return select(x, 2.0 * x, -x); }, 0.0, {0, 2, 0});
}

// d2/dx dy in both nesting orders: the inner direction is x and the outer one y, or reversed.
template <class F>
void mixed_is(const char* name, F f, double x, double y, double expected) {
  SCOPED_TRACE(name);
  Second inner(first(x), Second::Tangent::zero()), outer(First(y), Second::Tangent::zero());
  outer.tangent.set(0, First(1.0));
  EXPECT_EQ(f(inner, outer).tangent[0].tangent[0], expected);
  inner = Second(First(x), Second::Tangent::zero());
  inner.tangent.set(0, First(1.0));
  outer = Second(first(y), Second::Tangent::zero());
  EXPECT_EQ(f(inner, outer).tangent[0].tangent[0], expected);
}

TEST(Math, MixedDerivativeOfPowersIsZeroWithoutSlopeInTheExponent) {
  const auto power = [](auto x, auto y) { return pow(x, y); };
  mixed_is("(-2)^3", power, -2.0, 3.0, 0.0);
  mixed_is("0^1", power, 0.0, 1.0, 0.0);
  mixed_is("0^2", power, 0.0, 2.0, 0.0);
  mixed_is("1^3", power, 1.0, 3.0, 1.0);  // x^(y-1) (1 + y log x)
}

// Points where x^2 + y^2 leaves the range of doubles.
TEST(Math, Atan2HasSlopesFarAway) {
  const auto angle = [](double y) { return [y](auto x) { return atan2(x, decltype(x)(y)); }; };
  for (const double r : {1e-140, 1e-3, 1e160})
    EXPECT_NEAR(angle(r)(first(r)).tangent[0] * r, 0.5, 1e-15) << r;
  is("atan2 near (0, 0)", angle(1e-170), 1e-170, {std::atan2(1.0, 1.0), 0, 0});
}

TEST(Math, NormAtZeroHasZeroSlope) {
  using S = Dual<Dual<double, 3>, 1>;
  Vec<S, 3> v = Vec<S, 3>::Zero();
  for (int i = 0; i < 3; ++i) v[i].value.tangent.set(i, 1.0);
  v[0].tangent.set(0, Dual<double, 3>(1.0));
  for (const S& length : {norm(v), v.norm(), norm(2.0 * v)}) {
    EXPECT_EQ(primal(length), 0.0);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(length.value.tangent[i], 0.0);
      EXPECT_EQ(length.tangent[0].tangent[i], 0.0);
    }
  }
}

}  // namespace
}  // namespace saltus

// Outside the namespace, argument-dependent lookup or a qualified name finds the functions.
TEST(Math, IsFoundByArgumentDependentLookup) {
  using S = saltus::Dual<double, 2>;
  const auto formula = [](const auto& x) {
    return abs(x) + sin(x) + min(x, 1.0) + pow(x, 2) + select(x, x, 0.0) + smooth_step(x, 1.0);
  };
  EXPECT_NEAR(formula(S(-0.5)).value,
              0.5 + std::sin(-0.5) - 0.5 + 0.25 + 0.5 * (1 + std::tanh(-0.5)), 1e-15);
  EXPECT_EQ(saltus::abs(-0.5), 0.5);  // not the integer abs of <cstdlib>, which gives 0
  EXPECT_EQ(saltus::min(1, 2.5), 1.0);
  EXPECT_EQ(saltus::norm(Eigen::Vector2d(3, 4)), 5.0);
}

TEST(Math, PrefersOurMinToTheStandardMin) {
  using namespace std;
  using namespace saltus;
  const Dual<double, 2> a = 1.0, b = 2.0;
  EXPECT_EQ(min(a, b).value, 1.0);
  EXPECT_EQ(max(a, b).value, 2.0);
  EXPECT_EQ(min(1.0, 2.0), 1.0);
  EXPECT_EQ(max(1, 2), 2);
}
