#include "saltus/qp/sparse_ldl.hpp"

#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace saltus::qp {

SparsityPattern quasi_definite_pattern(const SparsityPattern& hessian,
                                       const SparsityPattern& rows) {
  const int n = hessian.rows(), m = rows.rows();
  std::vector<std::pair<int, int>> pairs;
  hessian.for_each([&](int i, int j, int) { pairs.emplace_back(i, j); });
  rows.for_each([&](int i, int j, int) { pairs.emplace_back(n + i, j); });
  for (int i = 0; i < n + m; ++i) pairs.emplace_back(i, i);
  return SparsityPattern::from_pairs(n + m, n + m, std::move(pairs));
}

std::vector<signed char> quasi_definite_signs(int n, int m) {
  std::vector<signed char> signs(n + m, 1);
  std::fill(signs.begin() + n, signs.end(), static_cast<signed char>(-1));
  return signs;
}

struct SparseLdl::Handle {
  Handle() {
    check(cholmod_start(&common), "start");
    common.print = 0;
    common.supernodal = CHOLMOD_SIMPLICIAL;
    common.final_ll = 0;
    common.nmethods = 1;
  }
  ~Handle() {
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  void check(int success, const char* what) const {
    if (success && common.status >= CHOLMOD_OK) return;
    if (common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
    throw std::runtime_error(std::string("CHOLMOD failed: ") + what);
  }

  // Builds the upper triangle by columns, with rows and columns renumbered by `position`.
  void build(const SparsityPattern& lower) {
    const int n = lower.rows();
    cholmod_free_sparse(&matrix, &common);
    matrix = cholmod_allocate_sparse(n, n, lower.entries(), /*sorted=*/0, /*packed=*/1,
                                     /*stype=*/1, CHOLMOD_REAL, &common);
    check(matrix != nullptr, "no memory for the matrix");
    int* start = static_cast<int*>(matrix->p);
    int* row = static_cast<int*>(matrix->i);
    std::fill(start, start + n + 1, 0);
    const auto column_of = [&](int i, int j) { return std::max(position[i], position[j]); };
    lower.for_each([&](int i, int j, int) { ++start[column_of(i, j) + 1]; });
    for (int j = 0; j < n; ++j) start[j + 1] += start[j];
    std::vector<int> next(start, start + n);
    slot.resize(lower.entries());
    lower.for_each([&](int i, int j, int entry) {
      slot[entry] = next[column_of(i, j)]++;
      row[slot[entry]] = std::min(position[i], position[j]);
    });
    double* value = static_cast<double*>(matrix->x);
    std::fill(value, value + lower.entries(), 0.0);
  }

  cholmod_common common;
  cholmod_sparse* matrix = nullptr;
  cholmod_factor* factor = nullptr;
  std::vector<int> position;       // position of each row in the elimination order
  std::vector<int> slot;           // index of each pattern entry among the values
  std::vector<signed char> signs;  // in elimination order
  std::vector<double> right_side;
};

SparseLdl::SparseLdl(const SparsityPattern& lower, std::vector<signed char> signs)
    : handle_(std::make_unique<Handle>()) {
  Handle& h = *handle_;
  const int n = lower.rows();
  h.position.resize(n);
  for (int i = 0; i < n; ++i) h.position[i] = i;

  // The first analysis only determines the order. The matrix is then stored in that order and
  // analysed again, so that the numeric code needs no copy.
  h.build(lower);
  h.common.method[0].ordering = CHOLMOD_AMD;
  h.common.postorder = 1;
  h.factor = cholmod_analyze(h.matrix, &h.common);
  h.check(h.factor != nullptr, "ordering");
  const int* order = static_cast<const int*>(h.factor->Perm);
  for (int i = 0; i < n; ++i) h.position[order[i]] = i;
  cholmod_free_factor(&h.factor, &h.common);

  h.build(lower);
  h.common.method[0].ordering = CHOLMOD_NATURAL;
  h.common.postorder = 0;
  h.factor = cholmod_analyze(h.matrix, &h.common);
  h.check(h.factor != nullptr, "symbolic analysis");

  h.signs.resize(n);
  for (int i = 0; i < n; ++i) h.signs[h.position[i]] = signs[i];
  h.right_side.resize(n);

  // The first numeric factorisation allocates the memory of later ones. It accepts any pivots.
  for (int i = 0; i < n; ++i) set(lower.find(i, i), signs[i]);
  if (!factor()) throw std::logic_error("SparseLdl: the pattern lacks a diagonal entry");
}

SparseLdl::~SparseLdl() = default;

int SparseLdl::rows() const { return static_cast<int>(handle_->position.size()); }

void SparseLdl::set(int entry, double value) {
  static_cast<double*>(handle_->matrix->x)[handle_->slot[entry]] = value;
}

// Calls visit(pivot, expected sign) for the pivots in order until it returns false.
template <class Visit>
bool SparseLdl::factor_and_visit(Visit visit) {
  Handle& h = *handle_;
  const int n = rows();
  double no_shift[2] = {0.0, 0.0};
  if (!cholmod_rowfac(h.matrix, nullptr, no_shift, 0, n, h.factor, &h.common) ||
      h.common.status != CHOLMOD_OK)
    return false;
  const int* start = static_cast<const int*>(h.factor->p);
  const double* value = static_cast<const double*>(h.factor->x);
  for (int j = 0; j < n; ++j) {
    const double pivot = value[start[j]];  // the diagonal of L is 1: its entry holds D
    if (!std::isfinite(pivot) || !visit(pivot, h.signs[j])) return false;
  }
  return true;
}

bool SparseLdl::factor() {
  return factor_and_visit([](double pivot, signed char sign) { return pivot * sign > 0.0; });
}

bool SparseLdl::factor_with_inertia() {
  int surplus = 0;  // excess of positive pivots
  return factor_and_visit([&](double pivot, signed char sign) {
           surplus += (pivot > 0.0) - (sign > 0);
           return pivot != 0.0;
         }) &&
         surplus == 0;
}

// Implemented here because cholmod_solve2 allocates in every call, even with a given work space.
void SparseLdl::solve(double* x) {
  Handle& h = *handle_;
  const int n = rows();
  const int* start = static_cast<const int*>(h.factor->p);
  const int* count = static_cast<const int*>(h.factor->nz);
  const int* row = static_cast<const int*>(h.factor->i);
  const double* value = static_cast<const double*>(h.factor->x);
  double* b = h.right_side.data();
  for (int i = 0; i < n; ++i) b[h.position[i]] = x[i];
  // Columns of L start with their diagonal entry, which holds D.
  for (int j = 0; j < n; ++j) {
    const double bj = b[j];
    for (int e = start[j] + 1; e < start[j] + count[j]; ++e) b[row[e]] -= value[e] * bj;
  }
  for (int j = n - 1; j >= 0; --j) {
    double bj = b[j] / value[start[j]];
    for (int e = start[j] + 1; e < start[j] + count[j]; ++e) bj -= value[e] * b[row[e]];
    b[j] = bj;
  }
  for (int i = 0; i < n; ++i) x[i] = b[h.position[i]];
}

}  // namespace saltus::qp
