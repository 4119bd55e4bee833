// Tests duals inside Eigen: products of any size and their memory.
#include "tests/autodiff/in_eigen.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus::test {

TYPED_TEST(InEigen, DynamicMatricesOnTheHeapAreNotMisaligned) {
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

TYPED_TEST(InEigen, ProductsOfMoreThanEightRowsAreCorrect) {
  using S = TypeParam;
  Eigen::Matrix<double, 12, 9> m;
  Vec<S, 9> v;
  for (int j = 0; j < 9; ++j) {
    v[j] = number<S>(0.1 * j);
    for (int i = 0; i < 12; ++i) m(i, j) = 0.3 * i - 0.2 * j + 0.1;
  }
  Eigen::Matrix<double, 12, 9, Eigen::RowMajor> by_rows = m;
  saltus::testing::AllocationCount count;
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

TYPED_TEST(InEigen, NoMemoryIsAllocated) {
  using S = TypeParam;
  const Vec<S, 3> v(number<S>(0.7), number<S>(1.9), number<S>(-0.4));
  saltus::testing::AllocationCount count;
  const Vec<S, 3> w = v.cross(v) + 2.0 * v;
  const S y = saltus::sin(w[0]) + norm(w);
  EXPECT_EQ(count.made(), 0);
  EXPECT_NE(primal(y), 0.0);
}

}  // namespace saltus::test
