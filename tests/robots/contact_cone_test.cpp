#include "saltus/robots/model/contact_cone.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "saltus/autodiff/dual.hpp"
#include "saltus/autodiff/tracer.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Vec<double, 6> wrench(double fx, double fy, double fz, double tx = 0, double ty = 0,
                      double tz = 0) {
  Vec<double, 6> w;
  w << fx, fy, fz, tx, ty, tz;
  return w;
}

// Message of the DefinitionError that the options cause.
std::string complaint(const robots::ContactCone::Options& options) {
  return error_of<DefinitionError>([&] { robots::contact_cone(options); }, "");
}

TEST(ContactCone, HasTheFourteenRowsOfTheReferenceController) {
  const robots::ContactCone cone = robots::contact_cone();
  EXPECT_EQ(cone.rows(), 14);
  EXPECT_EQ(robots::contact_cone_rows({}), 14);
  ASSERT_EQ(cone.names.size(), 14u);
  EXPECT_EQ(cone.names[3], "friction edge 3");
  EXPECT_EQ(cone.names[9], "centre of pressure x max");
  EXPECT_EQ(cone.names[13], "normal force max");
}

TEST(ContactCone, WritesTheRowsOfTheFormula) {
  const robots::ContactCone cone =
      robots::contact_cone({.friction = 0.4,
                            .edges = 8,
                            .foot = {between(-0.07, 0.10), between(-0.03, 0.02)},
                            .torsional_friction = 1.0 / 75.0,
                            .normal_force = at_least(10.0)});
  ASSERT_EQ(cone.rows(), 8 + 6 + 1);
  for (int i = 0; i < 8; ++i) {
    EXPECT_NEAR(cone.A(i, 0), std::cos(i * std::numbers::pi / 4), 1e-15);
    EXPECT_NEAR(cone.A(i, 1), std::sin(i * std::numbers::pi / 4), 1e-15);
    EXPECT_NEAR(cone.A(i, 2), -0.4 * std::cos(std::numbers::pi / 8), 1e-15);
  }
  EXPECT_EQ(cone.A(2, 0), 0.0);  // cos 90 degrees, exactly: it must not enter the sparsity
  EXPECT_EQ(cone.A(4, 1), 0.0);
  Mat<double, 7, 6> rest;
  rest << 0, 0, -1.0 / 75, 0, 0, 1,  //
      0, 0, -1.0 / 75, 0, 0, -1,     //
      0, 0, -0.07, 0, 1, 0,          //
      0, 0, -0.10, 0, -1, 0,         //
      0, 0, -0.03, -1, 0, 0,         //
      0, 0, -0.02, 1, 0, 0,          //
      0, 0, -1, 0, 0, 0;
  EXPECT_EQ(cone.A.bottomRows(7), rest);
  EXPECT_EQ(cone.b.head(14), VectorXd::Zero(14));
  EXPECT_EQ(cone.b[14], -10.0);
}

TEST(ContactCone, FourCircumscribedEdgesGiveTwoBoxes) {
  const robots::ContactCone cone =
      robots::contact_cone({.friction = 0.5,
                            .edges = 4,
                            .pyramid = robots::ContactCone::Pyramid::circumscribed,
                            .normal_force_rows = false});
  EXPECT_EQ(cone.rows(), 10);
  EXPECT_LE(cone.violation(wrench(50, -50, 100)), 1e-12);
  EXPECT_GT(cone.violation(wrench(50.1, 0, 100)), 0.0);
  EXPECT_EQ(cone.normal_force, between(10.0, 1000.0));
}

TEST(ContactCone, PyramidsAreInscribedAndCircumscribed) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
  for (int edges : {3, 4, 6, 8, 16}) {
    robots::ContactCone::Options options{.friction = 0.6, .edges = edges};
    const robots::ContactCone inner = robots::contact_cone(options);
    options.pyramid = robots::ContactCone::Pyramid::circumscribed;
    const robots::ContactCone outer = robots::contact_cone(options);
    for (int i = 0; i < 200; ++i) {
      const double a = angle(random);
      const auto at = [&](double factor) {
        return wrench(60 * factor * std::cos(a), 60 * factor * std::sin(a), 100);
      };
      EXPECT_GT(inner.violation(at(1.0001)), 0.0) << edges << " edges, angle " << a;
      EXPECT_LE(outer.violation(at(0.9999)), 0.0) << edges << " edges, angle " << a;
      EXPECT_LE(inner.violation(at(0.9999 * std::cos(std::numbers::pi / edges))), 0.0);
    }
  }
}

TEST(ContactCone, CentreOfPressureIsLimitedToTheEdge) {
  const robots::ContactCone cone =
      robots::contact_cone({.foot = {between(-0.05, 0.1), between(-0.03, 0.04)}});
  // A vertical force of 200 N at (x, y) has the torque (y fz, -x fz, 0) about the origin.
  const auto at = [](double x, double y) { return wrench(0, 0, 200, 200 * y, -200 * x); };
  for (const double x : {-0.05, 0.1})
    for (const double y : {-0.03, 0.04}) {
      EXPECT_NEAR(cone.violation(at(x, y)), 0.0, 1e-12);
      EXPECT_LT(cone.violation(at(0.99 * x, 0.99 * y)), 0.0);
      EXPECT_GT(cone.violation(at(1.01 * x, y)), 0.0);
      EXPECT_GT(cone.violation(at(x, 1.01 * y)), 0.0);
    }
}

TEST(ContactCone, MatchesTheWrenchesOfItsCorners) {
  const robots::FootRectangle foot{between(-0.05, 0.11), between(-0.03, 0.04)};
  const double mu = 0.4;
  robots::ContactCone::Options options{.friction = mu,
                                       .edges = 4,
                                       .pyramid = robots::ContactCone::Pyramid::circumscribed,
                                       .foot = foot,
                                       .torsional_friction = 1.0,
                                       .corners = true,
                                       .normal_force_rows = false};
  const robots::ContactCone cone = robots::contact_cone(options);
  EXPECT_EQ(cone.rows(), 4 + 6 + 8);
  options.corners = false;
  const robots::ContactCone without = robots::contact_cone(options);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(-1.0, 1.0), share(0.0, 1.0);
  const auto force_at = [&](double x, double y, double fz, double fx, double fy) {
    return wrench(fx, fy, fz, y * fz, -x * fz, x * fy - y * fx);
  };
  for (int k = 0; k < 200; ++k) {
    Vec<double, 6> all = Vec<double, 6>::Zero();
    for (const double x : {foot.x.lower, foot.x.upper})
      for (const double y : {foot.y.lower, foot.y.upper}) {
        const double fz = 100.0 * share(random);
        const Vec<double, 6> one =
            force_at(x, y, fz, mu * fz * part(random), mu * fz * part(random));
        all += one;
        EXPECT_LT(cone.violation(one), 1e-12);
        // On one corner, the only torsion is that of the force.
        const Vec<double, 6> turning = wrench(0, 0, 0, 0, 0, k % 2 == 0 ? 1e-3 : -1e-3);
        EXPECT_NEAR(cone.violation(one + turning), 1e-3, 1e-12);
        EXPECT_LT(without.violation(one + turning), 1e-12);
      }
    EXPECT_LT(cone.violation(all), 0.0);
  }
  // Pure torsion: each corner pushes along both of its bounds.
  const double most = mu * (0.5 * 0.16 + 0.5 * 0.07) * 100.0;
  const Vec<double, 6> middle = force_at(0.03, 0.005, 100.0, 0.0, 0.0);
  EXPECT_NEAR(cone.violation(middle + wrench(0, 0, 0, 0, 0, most)), 0.0, 1e-12);
  EXPECT_NEAR(cone.violation(middle - wrench(0, 0, 0, 0, 0, most)), 0.0, 1e-12);
}

TEST(ContactCone, HasAFixedSizeMatrix) {
  const robots::ContactCone cone = robots::contact_cone();
  const Vec<double, 6> w = wrench(3, -2, 150, 1, 2, 0.5);
  const Mat<double, 14, 6> rows = cone.fixed<14>();
  EXPECT_LT((rows * w - cone.A * w).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_EQ(cone.fixed_bounds<14>(), cone.b);
  EXPECT_THROW(cone.fixed<12>(), DefinitionError);
}

TEST(ContactCone, IsSparseInATerm) {
  const Mat<double, 14, 6> rows = robots::contact_cone().fixed<14>();
  Vec<Tracer, 6> w;
  for (int i = 0; i < 6; ++i) w[i] = Tracer::input(i);
  const Vec<Tracer, 14> values(rows * w);
  for (int r = 0; r < 14; ++r)
    for (int c = 0; c < 6; ++c)
      EXPECT_EQ(values[r].inputs().contains(c), rows(r, c) != 0.0) << "row " << r << ", " << c;
}

TEST(ContactCone, RejectsInvalidCones) {
  EXPECT_NE(complaint({.friction = 0.0}).find("friction coefficient must be positive, not 0"),
            std::string::npos);
  EXPECT_NE(complaint({.friction = nan}).find("friction"), std::string::npos);
  EXPECT_NE(complaint({.edges = 2}).find("at least 3 edges, not 2"), std::string::npos);
  EXPECT_NE(complaint({.foot = {between(0.1, -0.1), between(-1, 1)}}).find("empty along x"),
            std::string::npos);
  EXPECT_NE(complaint({.foot = {between(-1, 1), between(0, nan)}}).find("along y"),
            std::string::npos);
  EXPECT_NE(complaint({.torsional_friction = -0.1}).find("torsional"), std::string::npos);
  EXPECT_NE(complaint({.torsional_friction = nan}).find("torsional"), std::string::npos);
  EXPECT_NE(complaint({.normal_force = between(-1, 5)}).find("fz_min"), std::string::npos);
  EXPECT_NE(complaint({.normal_force = between(10, 5)}).find("fz_min = 10 N exceeds"),
            std::string::npos);
  EXPECT_NE(complaint({.normal_force = between(nan, 5)}).find("fz_min"), std::string::npos);
  EXPECT_NE(complaint({.normal_force = between(1, nan)}).find("fz_max"), std::string::npos);
}

}  // namespace
}  // namespace saltus
