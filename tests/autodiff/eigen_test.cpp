// Duals inside Eigen: mixing with matrices of doubles, products of any size, memory.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "saltus/autodiff/math.hpp"
#include "saltus/core/types.hpp"
#include "tests/autodiff/compare_scalars.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

template <class S>
class InEigen : public ::testing::Test {};
using Scalars = ::testing::Types<Dual<double, 0>, Dual<double, 8>, Dual<Dual<double, 4>, 1>>;
TYPED_TEST_SUITE(InEigen, Scalars);

TYPED_TEST(InEigen, eigen_mixes_with_matrices_of_doubles) {
  using S = TypeParam;
  Vec<S, 3> v(number<S>(0.7), number<S>(1.9), number<S>(-0.4));
  const Vec<S, 3> w(number<S>(-1.2), number<S>(0.1), number<S>(0.8));
  Eigen::Matrix3d m;
  m << 1, 2, 3, 0, -1, 4, 2, 0, 1;
  const Eigen::Vector3d k(0.5, -2.0, 1.0);

  const Vec<S, 3> product = m * v;
  for (int i = 0; i < 3; ++i)
    expect_same<S>(product[i], m(i, 0) * v[0] + m(i, 1) * v[1] + m(i, 2) * v[2]);
  const Vec<S, 3> scaled = 2.0 * v + v * 3 - v / 2;
  expect_same<S>(scaled[1], 4.5 * v[1]);
  const Vec<S, 3> times = v[0] * w;
  expect_same<S>(times[2], v[0] * w[2]);
  const Vec<S, 3> lifted = v[0] * k + k - v;
  expect_same<S>(lifted[1], v[0] * -2.0 - 2.0 - v[1]);
  expect_same<S>(v.dot(w), v[0] * w[0] + v[1] * w[1] + v[2] * w[2]);
  expect_same<S>(k.dot(v), 0.5 * v[0] - 2.0 * v[1] + v[2]);
  expect_same<S>(v.cross(w)[0], v[1] * w[2] - v[2] * w[1]);
  expect_same<S>(k.cross(v)[0], -2.0 * v[2] - v[1]);
  expect_same<S>(v.cross(k)[0], v[1] + 2.0 * v[2]);
  expect_same<S>(v.squaredNorm(), v.dot(v));
  expect_same<S>(v.norm(), saltus::norm(v));
  expect_same<S>(norm(Vec<S, 2>(v.template head<2>())), saltus::hypot(v[0], v[1]), 1e-12);
  const Mat<S, 3, 3> outer = v * w.transpose();
  expect_same<S>((outer * k.asDiagonal()).trace(), v.cwiseProduct(w).dot(k));
  const Mat<S, 3, 3> inverse = (outer + m).inverse();
  const Mat<S, 3, 3> one = inverse * (outer + m);
  expect_same<S>(one(1, 1), S(1.0), 1e-11);
  expect_same<S>(one(0, 2), S(0.0), 1e-11);
  v += k;
  v = v.array() * 2.0;
  expect_same<S>(v[2], 2.0 * (number<S>(-0.4) + 1.0));
}

TYPED_TEST(InEigen, dynamic_matrices_on_the_heap_are_not_misaligned) {
  using S = TypeParam;
  using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
  const int n = 21;  // large enough for Eigen's blocked products
  Matrix a(n, n), b(n, 1);
  for (int i = 0; i < n; ++i) {
    b(i, 0) = number<S>(0.1 * i);
    for (int j = 0; j < n; ++j) a(i, j) = number<S>(i == j ? 2.0 : 0.01 * i - 0.02 * j);
  }
  const MatrixXd numbers = MatrixXd::Identity(n, n);
  const Matrix same = numbers * (a * b);
  S sum = 0.0;
  for (int j = 0; j < n; ++j) sum += a(3, j) * b(j, 0);
  expect_same<S>(same(3, 0), sum, 1e-12);
}

TYPED_TEST(InEigen, products_of_more_than_eight_rows) {
  using S = TypeParam;
  Eigen::Matrix<double, 12, 9> m;
  Vec<S, 9> v;
  for (int j = 0; j < 9; ++j) {
    v[j] = number<S>(0.1 * j);
    for (int i = 0; i < 12; ++i) m(i, j) = 0.3 * i - 0.2 * j + 0.1;
  }
  Eigen::Matrix<double, 12, 9, Eigen::RowMajor> by_rows = m;
  testing::AllocationCount count;
  const Vec<S, 12> a = m * v;
  const Vec<S, 12> b = by_rows * v + m * (2.0 * v);
  const Mat<S, 1, 12> c = v.transpose() * m.transpose();
  const Mat<S, 9, 9> outer = v * v.transpose();
  const Vec<S, 9> d = outer * Vec<double, 9>::Ones();
  EXPECT_EQ(count.made(), 0);
  S sum = 0.0, all = 0.0;
  for (int j = 0; j < 9; ++j) {
    sum += m(7, j) * v[j];
    all += v[j];
  }
  expect_same<S>(a[7], sum);
  expect_same<S>(b[7], 3.0 * sum);
  expect_same<S>(c[7], sum);
  expect_same<S>(d[3], v[3] * all);
}

TYPED_TEST(InEigen, no_memory_is_allocated) {
  using S = TypeParam;
  const Vec<S, 3> v(number<S>(0.7), number<S>(1.9), number<S>(-0.4));
  testing::AllocationCount count;
  const Vec<S, 3> w = v.cross(v) + 2.0 * v;
  const S y = saltus::sin(w[0]) + norm(w);
  EXPECT_EQ(count.made(), 0);
  EXPECT_NE(primal(y), 0.0);
}

}  // namespace
}  // namespace saltus
