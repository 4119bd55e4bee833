// The tracer's sets are exact: no entry is missing and no entry is superfluous.
#include "saltus/autodiff/tracer.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <set>
#include <utility>

#include "saltus/autodiff/math.hpp"
#include "saltus/core/types.hpp"

namespace saltus {
namespace {

using Inputs = std::set<int>;
using Pairs = std::set<std::pair<int, int>>;  // (i, j) with i >= j

Inputs inputs(const Tracer& y) {
  Inputs found;
  y.inputs().for_each([&](int i) { found.insert(i); });
  return found;
}
Pairs pairs(const Tracer& y) {
  Pairs found;
  y.for_each_pair([&](int i, int j) { found.emplace(i, j); });
  return found;
}

const Tracer x = Tracer::input(0), y = Tracer::input(1), p = Tracer::input(2);

TEST(Tracer, SumsAndConstantsAreAffine) {
  const Tracer sum = 2.0 * x - y / 3.0 + 4;
  EXPECT_EQ(inputs(sum), (Inputs{0, 1}));
  EXPECT_EQ(pairs(sum), Pairs{});
  EXPECT_EQ(inputs(-x), (Inputs{0}));
  EXPECT_TRUE(Tracer(3.0).is_constant());
  EXPECT_TRUE(Tracer().is_zero());
}

TEST(Tracer, ProductsInteractOnlyAcrossFactors) {
  EXPECT_EQ(pairs(x * y), (Pairs{{1, 0}}));
  EXPECT_EQ(pairs(x * x), (Pairs{{0, 0}}));
  EXPECT_EQ(pairs((x + y) * (x + y)), (Pairs{{0, 0}, {1, 0}, {1, 1}}));
  EXPECT_EQ(pairs(x * p), (Pairs{{2, 0}}));
  EXPECT_EQ(pairs((x + 1.0) * p + y), (Pairs{{2, 0}}));
  EXPECT_EQ(pairs(x * y * p), (Pairs{{1, 0}, {2, 0}, {2, 1}}));
  EXPECT_EQ(pairs(sin(x) * y), (Pairs{{0, 0}, {1, 0}}));
  EXPECT_EQ(pairs(sin(x) + cos(y)), (Pairs{{0, 0}, {1, 1}}));
  EXPECT_EQ(pairs(sin(x + y)), (Pairs{{0, 0}, {1, 0}, {1, 1}}));
}

TEST(Tracer, QuotientsAreNonlinearInTheDenominatorAlone) {
  EXPECT_EQ(pairs(x / y), (Pairs{{1, 0}, {1, 1}}));
  EXPECT_EQ(pairs(1.0 / y), (Pairs{{1, 1}}));
  EXPECT_EQ(pairs(x / 2.0), Pairs{});
}

TEST(Tracer, ConstantZerosAnnihilateAndConstantsFold) {
  EXPECT_TRUE((0.0 * x).is_zero());
  EXPECT_TRUE((0.0 * sin(x) * y).is_zero());
  EXPECT_TRUE((0.0 / x).is_zero());
  const Tracer zero = sin(Tracer(0.0)) * cos(Tracer(1.0)) + 2.0 - 2.0;
  EXPECT_TRUE((zero * x).is_zero());
  EXPECT_EQ(inputs(zero * x + y), (Inputs{1}));
  EXPECT_EQ((Tracer(2.0) * 3.0 - 1.0).constant(), 5.0);
  EXPECT_EQ((-Tracer(2.0)).constant(), -2.0);
  EXPECT_EQ(pow(Tracer(2.0), 3).constant(), 8.0);
  EXPECT_EQ(atan2(Tracer(1.0), 1.0).constant(), std::atan2(1.0, 1.0));
  EXPECT_EQ(min(Tracer(1.0), 2.0).constant(), 1.0);
}

TEST(Tracer, TracesPowers) {
  EXPECT_EQ(inputs(pow(x, 0)), Inputs{});
  EXPECT_EQ(pow(x, 0.0).constant(), 1.0);
  EXPECT_EQ(pairs(pow(x, 1)), Pairs{});
  EXPECT_EQ(pairs(pow(x, 2)), (Pairs{{0, 0}}));
  EXPECT_EQ(pairs(pow(x, y)), (Pairs{{0, 0}, {1, 0}, {1, 1}}));
  EXPECT_EQ(pairs(pow(2.0, y)), (Pairs{{1, 1}}));
  EXPECT_EQ(pairs(square(x) + cube(y)), (Pairs{{0, 0}, {1, 1}}));
}

TEST(Tracer, SwitchesCountBothBranchesAndTheCondition) {
  EXPECT_EQ(inputs(select(p, x, y)), (Inputs{0, 1, 2}));
  EXPECT_EQ(pairs(select(p, x, y)).size(), 6u);  // piecewise: affine in none of them
  EXPECT_EQ(inputs(select(x, 1.0, 2.0)), (Inputs{0}));
  EXPECT_EQ(inputs(select(1.0, x, y)), (Inputs{0}));  // the constant condition is known
  EXPECT_EQ(inputs(select(Tracer(-1.0), x, y)), (Inputs{1}));
  EXPECT_EQ(inputs(min(x, 3.0)), (Inputs{0}));
  EXPECT_EQ(pairs(max(x, y)), (Pairs{{0, 0}, {1, 0}, {1, 1}}));
  EXPECT_EQ(pairs(abs(x)), (Pairs{{0, 0}}));
  EXPECT_EQ(pairs(smooth_max(x, y, 0.1)), (Pairs{{0, 0}, {1, 0}, {1, 1}}));
}

TEST(Tracer, EveryFunctionOfOneArgumentIsNonlinearAndFolds) {
  const Tracer c = 0.5;
  for (const Tracer& f : {sin(x), cos(x), tan(x), asin(x), acos(x), atan(x), sinh(x), cosh(x),
                          tanh(x), exp(x), log(x), sqrt(x), abs(x), hypot(x, 1.0), atan2(x, 1.0)})
    EXPECT_EQ(pairs(f), (Pairs{{0, 0}}));
  const double folded[] = {sin(c).constant(),  cos(c).constant(),  tan(c).constant(),
                           asin(c).constant(), acos(c).constant(), atan(c).constant(),
                           sinh(c).constant(), cosh(c).constant(), tanh(c).constant(),
                           exp(c).constant(),  log(c).constant(),  sqrt(c).constant()};
  const double expected[] = {std::sin(0.5),  std::cos(0.5),  std::tan(0.5),  std::asin(0.5),
                             std::acos(0.5), std::atan(0.5), std::sinh(0.5), std::cosh(0.5),
                             std::tanh(0.5), std::exp(0.5),  std::log(0.5),  std::sqrt(0.5)};
  for (int i = 0; i < 12; ++i) EXPECT_EQ(folded[i], expected[i]);
}

TEST(Tracer, ZerosOfConstantMatricesAreExact) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  m(0, 0) = 1.0;
  m(1, 2) = 2.0;
  const Vec<Tracer, 3> v(x, y, p);
  const Vec<Tracer, 3> w = m * v;
  EXPECT_EQ(inputs(w[0]), (Inputs{0}));
  EXPECT_EQ(inputs(w[1]), (Inputs{2}));
  EXPECT_TRUE(w[2].is_zero());
  const Vec<Tracer, 3> crossed = Eigen::Vector3d(0.0, 0.0, 1.0).cross(v);
  EXPECT_EQ(inputs(crossed[0]), (Inputs{1}));
  EXPECT_TRUE(crossed[2].is_constant());
  EXPECT_EQ(pairs(v.squaredNorm()), (Pairs{{0, 0}, {1, 1}, {2, 2}}));
  EXPECT_EQ(pairs(norm(v)).size(), 6u);
  EXPECT_EQ(pairs(v.dot(m * v)), (Pairs{{0, 0}, {2, 1}}));
}

TEST(Tracer, TracesHundredsOfInputs) {
  Tracer sum;
  for (int i = 0; i < 300; ++i) sum += square(Tracer::input(i));
  EXPECT_EQ(inputs(sum).size(), 300u);
  EXPECT_EQ(pairs(sum).size(), 300u);
  EXPECT_TRUE(pairs(sum).count({299, 299}) == 1);
  EXPECT_EQ(pairs(Tracer::input(299) * Tracer::input(7)), (Pairs{{299, 7}}));
}

// Eigen's checks are assertions, which Release builds disable.
template <class Use>
void expect_beyond(const Use& use, long row, long rows, int first_input) {
  try {
    use();
    FAIL() << "a missing entry was accepted";
  } catch (const detail::IndexError& e) {
    EXPECT_EQ(e.row, row);
    EXPECT_EQ(e.rows, rows);
    EXPECT_EQ(e.first_input, first_input);
  }
}

TEST(TracedVector, ChecksItsSize) {
#ifndef NDEBUG
  GTEST_SKIP() << "assertions of Eigen's come first in this build";
#endif
  Vec<Tracer, 2> v{Tracer::input(3), Tracer::input(4)};
  const Mat<Tracer, 2, 2> m = Mat<Tracer, 2, 2>::Identity();
  expect_beyond([&] { (void)v[2]; }, 2, 2, 3);
  expect_beyond([&] { (void)v(-1); }, -1, 2, 3);
  expect_beyond([&] { v[2] = 1.0; }, 2, 2, 3);
  expect_beyond([&] { v << 1.0, 2.0, 3.0; }, 2, 2, -1);
  expect_beyond([&] { (void)(v + v)[2]; }, 2, 2, -1);
  expect_beyond([&] { (void)v.array()[2]; }, 2, 2, -1);
  expect_beyond([&] { (void)v.segment<2>(1).sum(); }, 2, 2, -1);
  expect_beyond([&] { (void)v.head(1)[1]; }, 1, 1, -1);
  expect_beyond([&] { v.tail<1>()[-1] = 0.0; }, -1, 1, -1);
  expect_beyond([&] { (void)(m * v)[2]; }, 2, 2, -1);
  expect_beyond([&] { (void)m(2, 0); }, 2, 2, -1);
  expect_beyond([&] { (void)m.col(2).sum(); }, 1, 2, -1);
  EXPECT_NO_THROW((v << m.col(0)));
  EXPECT_NO_THROW((void)(m * v).head<2>().norm());
}

TEST(TracedVector, ChecksCoeffAndData) {
  Vec<Tracer, 2> v{Tracer::input(3), Tracer::input(4)};
  const Mat<Tracer, 2, 2> m = Mat<Tracer, 2, 2>::Identity();
  expect_beyond([&] { (void)v.coeff(2); }, 2, 2, 3);
  expect_beyond([&] { v.coeffRef(-1) = 1.0; }, -1, 2, 3);
  expect_beyond([&] { (void)m.coeff(0, 2); }, 4, 4, -1);
  EXPECT_FALSE(v.data()[2].is_written());
  EXPECT_FALSE((v.data()[-1] + v[0]).is_written());
  {
    Vec<Tracer, 2> w = v;
    w.data()[1] = w.coeff(0);
    w = w.reverse().eval();
  }
  EXPECT_FALSE(detail::was_written_beyond());
  {
    Vec<Tracer, 2> w = v;
    w.data()[2] = 1.0;
  }
  EXPECT_TRUE(detail::was_written_beyond());
  EXPECT_FALSE(detail::was_written_beyond());
}

TEST(TracedVector, PropagatesUnwrittenEntries) {
  Vec<Tracer, 2> v;
  v[0] = x;
  EXPECT_TRUE(v[0].is_written());
  EXPECT_FALSE(v[1].is_written());
  EXPECT_FALSE((v[0] + v[1]).is_written());
  EXPECT_FALSE((2.0 * sin(v[1])).is_written());
  EXPECT_FALSE(v.sum().is_written());
  EXPECT_TRUE((0.0 * v[1]).is_zero());
  EXPECT_TRUE((Vec<Tracer, 2>::Zero().eval()[1].is_zero()));
  v[1] = 1.0;
  EXPECT_TRUE(v.sum().is_written());
}

}  // namespace
}  // namespace saltus
