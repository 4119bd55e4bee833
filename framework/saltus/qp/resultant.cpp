// Solves B_1 T_p = B_p by elimination with row exchanges. B_p is not square: the solution of the
// pivot rows is then checked in all rows. T_p is inverted in the same way.
#include "saltus/qp/resultant.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "saltus/qp/lanes.hpp"

namespace saltus::qp {
namespace {

// relative to the entries of B, well above the error of their computation
constexpr double rounding = 1e-11;
// With a pivot of T_p below this there is no resultant: some force of the group has no effect.
constexpr double least_map_pivot = 1e-8;

// [A | R] by rows, each row padded to whole vectors.
struct Rows {
  explicit Rows(int columns) : stride(padded(columns)) {}
  double* operator[](int i) { return entries.data() + i * stride; }

  int stride;
  alignas(64) std::array<double, max_resultant_rows * padded(2 * max_resultant_size)> entries;
};

// Reduces the leading m rows of A to the identity and R to the solution. Returns false if a pivot
// is not larger than `least`. Written out with a few vectors per row: a general decomposition takes
// ten times as long for sizes known only at run time.
bool eliminate(Rows& a, int rows, int m, double least) {
  for (int j = 0; j < m; ++j) {
    int best = j;
    for (int i = j + 1; i < rows; ++i)
      if (std::fabs(a[i][j]) > std::fabs(a[best][j])) best = i;
    if (!(std::fabs(a[best][j]) > least)) return false;
    const double inverse = 1.0 / a[best][j];
    const int first = j / lanes * lanes;
    double *row = a[j], *pivot_row = a[best];
    for (int v = first; v < a.stride; v += lanes) {
      const Lanes scaled = load(pivot_row + v) * inverse;
      store(pivot_row + v, load(row + v));
      store(row + v, scaled);
    }
    for (int i = 0; i < rows; ++i) {
      if (i == j) continue;
      double* to = a[i];
      const Lanes factor = broadcast(to[j]);
      for (int v = first; v < a.stride; v += lanes)
        store(to + v, load(to + v) - load(row + v) * factor);
    }
  }
  return true;
}

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
  if (s.rows < m || s.rows > max_resultant_rows || m > max_resultant_size) return false;
  const double least = rounding * largest_entry(B, s);
  std::fill_n(T, ld * (s.parts - 1) * m, 0.0);
  std::fill_n(T_inverse, ld * (s.parts - 1) * m, 0.0);
  Rows work(2 * m);
  for (int part = 1; part < s.parts; ++part) {
    double* map = T + (part - 1) * m * ld;
    double* inverse = T_inverse + (part - 1) * m * ld;
    for (int i = 0; i < s.rows; ++i)
      for (int c = 0; c < work.stride; ++c)
        work[i][c] = c < m ? B(i, c) : c < 2 * m ? B(i, part * m + c - m) : 0.0;
    if (!eliminate(work, s.rows, m, least)) return false;
    for (int c = 0; c < m; ++c)
      for (int i = 0; i < m; ++i) map[i + c * ld] = work[i][m + c];
    for (int i = 0; i < m; ++i) {
      for (int c = 0; c < m; ++c) {
        work[i][c] = map[i + c * ld];
        work[i][m + c] = c == i ? 1.0 : 0.0;
      }
    }
    if (!eliminate(work, m, m, least_map_pivot)) return false;
    for (int c = 0; c < m; ++c)
      for (int i = 0; i < m; ++i) inverse[i + c * ld] = work[i][m + c];
  }
  return maps_to_resultant(B, s, T);
}

}  // namespace saltus::qp
