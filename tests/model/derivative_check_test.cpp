// The checker accepts right derivatives and names the wrong entry of wrong ones.
#include "saltus/model/derivative_check.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "saltus/model/make_function.hpp"

namespace saltus {
namespace {

// y0 = a b, y1 = sin(b), with a selectable mistake.
enum class Mistake { none, jacobian, hessian, pattern, not_a_number };
class Handwritten final : public FunctionBody {
 public:
  explicit Handwritten(Mistake mistake) : FunctionBody(2, 2), mistake_(mistake) {
    jacobian_pattern_ = mistake == Mistake::pattern
                            ? SparsityPattern::from_pairs(2, 2, {{0, 1}, {1, 1}})
                            : SparsityPattern::from_pairs(2, 2, {{0, 0}, {0, 1}, {1, 1}});
    hessian_pattern_ = SparsityPattern::from_pairs(2, 2, {{1, 0}, {1, 1}});
  }
  void value(const double* z, double* y) const override {
    y[0] = z[0] * z[1];
    y[1] = std::sin(z[1]);
  }
  void jacobian(const double* z, double* y, double* entries) const override {
    value(z, y);
    if (mistake_ != Mistake::pattern) *entries++ = z[1];
    entries[0] = z[0] + (mistake_ == Mistake::jacobian ? 0.5 : 0.0);
    entries[1] = mistake_ == Mistake::not_a_number ? std::nan("") : std::cos(z[1]);
  }
  void hessian(const double* z, const double* w, double* entries, Curvature) const override {
    entries[0] = w[0];
    entries[1] = (mistake_ == Mistake::hessian ? 1.0 : -1.0) * w[1] * std::sin(z[1]);
  }

 private:
  Mistake mistake_;
};

DerivativeReport check(Mistake mistake) {
  const Function f(std::make_shared<Handwritten>(mistake));
  return check_derivatives(f, Eigen::Vector2d(1.5, 0.7),
                           {.input_names = {"lever", "angle"}, .output_names = {"torque", "sine"}});
}

TEST(DerivativeCheck, AcceptsCorrectDerivatives) {
  const DerivativeReport report = check(Mistake::none);
  EXPECT_TRUE(report.ok) << report;
  EXPECT_LT(report.worst_jacobian.error, 1e-11);  // truncation error of order four
  EXPECT_LT(report.worst_hessian.error, 1e-11);
  EXPECT_NE(to_string(report).find("agree"), std::string::npos);
}

TEST(DerivativeCheck, NamesTheWrongEntry) {
  const DerivativeReport report = check(Mistake::jacobian);
  EXPECT_FALSE(report.ok);
  ASSERT_EQ(report.jacobian_failures.size(), 1u);
  EXPECT_EQ(report.worst_jacobian.row, 0);
  EXPECT_EQ(report.worst_jacobian.col, 1);
  EXPECT_NEAR(report.worst_jacobian.exact, 2.0, 1e-12);
  EXPECT_NEAR(report.worst_jacobian.difference, 1.5, 1e-9);
  const std::string text = to_string(report);
  EXPECT_NE(text.find("DIFFER"), std::string::npos);
  EXPECT_NE(text.find("torque"), std::string::npos);
  EXPECT_NE(text.find("angle"), std::string::npos);
}

TEST(DerivativeCheck, DetectsWrongCurvature) {
  const DerivativeReport report = check(Mistake::hessian);
  EXPECT_FALSE(report.ok);
  EXPECT_TRUE(report.jacobian_failures.empty());
  ASSERT_EQ(report.hessian_failures.size(), 1u);
  EXPECT_EQ(report.worst_hessian.row, 1);
  EXPECT_EQ(report.worst_hessian.col, 1);
}

TEST(DerivativeCheck, DetectsAMissingPatternEntry) {
  const DerivativeReport report = check(Mistake::pattern);
  EXPECT_FALSE(report.ok);
  EXPECT_FALSE(report.worst_jacobian.in_pattern);
  EXPECT_NE(to_string(report).find("missing from the pattern"), std::string::npos);
}

TEST(DerivativeCheck, DetectsNan) {
  const DerivativeReport report = check(Mistake::not_a_number);
  EXPECT_FALSE(report.ok);
  EXPECT_TRUE(std::isinf(report.worst_jacobian.error));
}

TEST(DerivativeCheck, RandomPointsPrintTheirSeed) {
  const Function f = make_function<2, 0, 0>([](auto t, auto x) { return x[0] * exp(x[1]) * t; });
  const VectorXd lower = VectorXd::Constant(3, -1.0), upper = VectorXd::Constant(3, 1.0);
  const DerivativeReport report = check_derivatives(f, lower, upper, 5, 42);
  EXPECT_TRUE(report.ok) << report;
  EXPECT_NE(to_string(report).find("5 points (seed 42)"), std::string::npos);
}

TEST(DerivativeCheck, LargeValuesAreNoErrors) {
  const Function f = make_function<1, 0, 0>([](auto, auto x) { return 1e9 + sin(x[0]); });
  const DerivativeReport report = check_derivatives(f, Eigen::Vector2d(0.0, 0.3));
  EXPECT_TRUE(report.ok) << report;
}

}  // namespace
}  // namespace saltus
