// Tests duals inside Eigen: expressions that mix duals with matrices of doubles.
#include <Eigen/LU>

#include "tests/autodiff/in_eigen.hpp"

namespace saltus::test {

TYPED_TEST(InEigen, EigenMixesWithMatricesOfDoubles) {
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

}  // namespace saltus::test
