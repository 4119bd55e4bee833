// B_1 T_p = B_p by LU decomposition with full pivoting, which shows the rank of B_1; B_p is not
// square, so what solves the rows of the pivots is then checked in all of them. T_p is inverted by
// LU with partial pivoting.
#include "saltus/qp/resultant.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "saltus/qp/lanes.hpp"

namespace saltus::qp {
namespace {

constexpr double rounding = 1e-11;  // of B's entries, well above what their computation loses
// A pivot of T_p below this is no resultant: some force of the group moves nothing.
constexpr double least_map_pivot = 1e-8;

// Of fixed capacity, so that nothing allocates.
template <int max_rows>
using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, max_rows,
                            max_resultant_size>;
using Padded = Eigen::Map<MatrixXd, 0, Eigen::OuterStride<>>;

double largest_entry(const MatrixXd& B, const ResultantSizes& s) {
  return B.topLeftCorner(s.rows, s.parts * s.size).cwiseAbs().maxCoeff();
}

}  // namespace

bool maps_to_resultant(const MatrixXd& B, const ResultantSizes& s, const double* T) {
  const double allowed = rounding * largest_entry(B, s);
  const int ld = padded(s.size);
  for (int c = 0; c < (s.parts - 1) * s.size; ++c)
    for (int i = 0; i < s.rows; ++i) {
      double sum = -B(i, s.size + c);
      for (int l = 0; l < s.size; ++l) sum += B(i, l) * T[l + c * ld];
      if (std::fabs(sum) > allowed) return false;
    }
  return true;
}

bool find_resultant_maps(const MatrixXd& B, const ResultantSizes& s, double* T, double* T_inverse) {
  const int m = s.size, ld = padded(m);
  if (s.rows > max_resultant_rows || m > max_resultant_size) return false;
  Eigen::FullPivLU<Small<max_resultant_rows>> first(s.rows, m);
  first.setThreshold(rounding);
  first.compute(B.topLeftCorner(s.rows, m));
  if (first.rank() < m) return false;
  std::fill_n(T, ld * (s.parts - 1) * m, 0.0);
  std::fill_n(T_inverse, ld * (s.parts - 1) * m, 0.0);
  Small<max_resultant_rows> further;
  Eigen::PartialPivLU<Small<max_resultant_size>> map(m);
  for (int part = 1; part < s.parts; ++part) {
    const int offset = (part - 1) * m * ld;
    Padded forward(T + offset, m, m, Eigen::OuterStride<>(ld));
    Padded back(T_inverse + offset, m, m, Eigen::OuterStride<>(ld));
    further = B.block(0, part * m, s.rows, m);
    forward = first.solve(further);
    map.compute(forward);
    if (map.matrixLU().diagonal().cwiseAbs().minCoeff() < least_map_pivot) return false;
    back = map.inverse();
  }
  return maps_to_resultant(B, s, T);
}

}  // namespace saltus::qp
