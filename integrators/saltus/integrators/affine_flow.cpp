#include "saltus/integrators/affine_flow.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {
namespace {

constexpr int binomial[3][3] = {{1, 0, 0}, {1, 1, 0}, {1, 2, 1}};
constexpr double series_norm = 0.5;        // norm bound |tau M| of the series
constexpr double negligible_term = 1e-20;  // per entry, to keep the digits of small ones
constexpr int longest_series = 40;         // 0.5^40 / 40! is far below negligible_term
constexpr double no_truncation = 0.0;      // for finite series
// Equals 50 doublings. A larger norm leaves no correct digit.
constexpr double largest_norm = 1e15;

// c += scale a b. Skips zeros in `a`, which is mostly zeros.
void add_product(double scale, const RowMajorMatrix& a, const RowMajorMatrix& b,
                 RowMajorMatrix& c) {
  const Eigen::Index n = a.rows();
  for (Eigen::Index i = 0; i < n; ++i) {
    double* out = c.data() + i * n;
    for (Eigen::Index k = 0; k < n; ++k) {
      const double factor = scale * a(i, k);
      if (factor == 0.0) continue;
      const double* row = b.data() + k * n;
      for (Eigen::Index j = 0; j < n; ++j) out[j] += factor * row[j];
    }
  }
}

// c += scale a' b.
void add_transposed_product(double scale, const RowMajorMatrix& a, const RowMajorMatrix& b,
                            RowMajorMatrix& c) {
  const Eigen::Index n = a.rows();
  for (Eigen::Index k = 0; k < n; ++k) {
    const double* row = b.data() + k * n;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double factor = scale * a(k, i);
      if (factor == 0.0) continue;
      double* out = c.data() + i * n;
      for (Eigen::Index j = 0; j < n; ++j) out[j] += factor * row[j];
    }
  }
}

// Leibniz rule for all derivatives up to `order`.
template <class Product>
void add_product(int order, double scale, const MatrixJet& a, const MatrixJet& b, MatrixJet& c,
                 Product&& product) {
  for (int k = 0; k <= order; ++k)
    for (int i = 0; i <= k; ++i) product(scale * binomial[k][i], a[i], b[k - i], c[k]);
}

const auto plain = [](double s, const RowMajorMatrix& a, const RowMajorMatrix& b,
                      RowMajorMatrix& c) { add_product(s, a, b, c); };
const auto transposed = [](double s, const RowMajorMatrix& a, const RowMajorMatrix& b,
                           RowMajorMatrix& c) { add_transposed_product(s, a, b, c); };

void add(int order, const MatrixJet& a, MatrixJet& sum) {
  for (int k = 0; k <= order; ++k) sum[k] += a[k];
}

void copy(int order, const MatrixJet& from, MatrixJet& to) {
  for (int k = 0; k <= order; ++k) to[k] = from[k];
}

// term = scale (term M + its transpose), for symmetric results.
void symmetrise(int order, double scale, const MatrixJet& half, MatrixJet& term) {
  const Eigen::Index n = half[0].rows();
  for (int k = 0; k <= order; ++k)
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) term[k](i, j) = scale * (half[k](i, j) + half[k](j, i));
}

bool is_negligible(int order, double relative, const MatrixJet& term, const MatrixJet& sum) {
  for (int k = 0; k <= order; ++k)
    if (term[k].cwiseAbs().maxCoeff() > relative * sum[k].cwiseAbs().maxCoeff()) return false;
  return true;
}

double norm_of(const RowMajorMatrix& m) { return m.cwiseAbs().rowwise().sum().maxCoeff(); }

// Scales rows after the states by `row` and the corresponding columns by `column`.
void change_unit(int order, int states, double row, double column, MatrixJet& jet) {
  for (int k = 0; k <= order; ++k) {
    const Eigen::Index behind = jet[k].rows() - states;
    jet[k].bottomRows(behind) *= row;
    jet[k].rightCols(behind) *= column;
  }
}

}  // namespace

void MatrixJet::resize(int size) {
  for (RowMajorMatrix& m : derivative) m.setZero(size, size);
}

void MatrixJet::set_zero(int order) {
  for (int k = 0; k <= order; ++k) derivative[k].setZero();
}

AffineFlow::AffineFlow(int states, int size, int count)
    : forms(count), integrals(count), states_(states), form_terms_(count) {
  for (MatrixJet* jet : {&generator, &flow, &term_, &next_}) jet->resize(size);
  settled_.resize(size);
  for (auto* jets : {&forms, &integrals, &form_terms_})
    for (MatrixJet& jet : *jets) jet.resize(size);
}

// Marks states whose rates depend on marked states only. If all are marked, M is nilpotent.
bool AffineFlow::is_chain(int order) {
  const int n = static_cast<int>(settled_.size());
  std::fill(settled_.begin(), settled_.end(), char{0});
  int left = n;
  for (bool progress = true; progress && left > 0;) {
    progress = false;
    for (int r = 0; r < n; ++r) {
      if (settled_[r]) continue;
      bool free = true;
      for (int c = 0; c < n && free; ++c)
        for (int k = 0; k <= order && free; ++k) free = settled_[c] || generator[k](r, c) == 0.0;
      if (!free) continue;
      settled_[r] = 1;
      --left;
      progress = true;
    }
  }
  return left == 0;
}

// Unit of c, a power of two, so that the change of units does not round.
double AffineFlow::unit_of_columns() const {
  const auto rates = generator[0].topRows(states_).cwiseAbs();
  if (rates.size() == 0) return 1.0;
  const double of_x = rates.leftCols(states_).rowwise().sum().maxCoeff();
  const double of_c = rates.rightCols(rates.cols() - states_).rowwise().sum().maxCoeff();
  const double most = std::max(of_x, series_norm);
  return of_c > most ? std::exp2(std::floor(std::log2(most / of_c))) : 1.0;
}

bool AffineFlow::compute(int order) {
  double norm = norm_of(generator[0]);
  double finite = norm;
  for (int k = 0; k <= order; ++k) {
    finite += generator[k].cwiseAbs().sum();
    for (const MatrixJet& form : forms) finite += form[k].cwiseAbs().sum();
  }
  if (!std::isfinite(finite) || norm > largest_norm) return false;
  // The series of a chain of n states has n terms, the integral of a form twice as many.
  const bool ends = is_chain(order);
  const int longest = ends ? 2 * static_cast<int>(settled_.size()) : longest_series;
  const double negligible = ends ? no_truncation : negligible_term;
  const double unit = ends ? 1.0 : unit_of_columns();
  if (unit != 1.0) {
    change_unit(order, states_, 1.0 / unit, unit, generator);
    for (MatrixJet& form : forms) change_unit(order, states_, unit, unit, form);
    norm = norm_of(generator[0]);
  }
  int doublings = 0;
  for (; !ends && norm > series_norm; norm *= 0.5) ++doublings;
  const double tau = std::ldexp(1.0, -doublings);

  // F = sum_k (tau M)^k / k!
  flow.set_zero(order);
  term_.set_zero(order);
  flow[0].diagonal().setOnes();
  term_[0].diagonal().setOnes();
  for (int k = 1; k <= longest; ++k) {
    next_.set_zero(order);
    add_product(order, tau / k, generator, term_, next_, plain);
    std::swap(term_, next_);
    add(order, term_, flow);
    if (is_negligible(order, negligible, term_, flow)) break;
  }

  // G = sum_k E_k,  E_0 = tau Q,  E_k = tau (E_{k-1} M + M' E_{k-1}) / (k + 1)
  for (std::size_t i = 0; i < forms.size(); ++i) {
    MatrixJet& term = form_terms_[i];
    for (int k = 0; k <= order; ++k) term[k] = tau * forms[i][k];
    copy(order, term, integrals[i]);
    for (int k = 1; k <= longest; ++k) {
      next_.set_zero(order);
      add_product(order, 1.0, term, generator, next_, plain);
      symmetrise(order, tau / (k + 1), next_, term);
      add(order, term, integrals[i]);
      if (is_negligible(order, negligible, term, integrals[i])) break;
    }
  }

  for (int d = 0; d < doublings; ++d) {
    for (MatrixJet& integral : integrals) {
      next_.set_zero(order);
      add_product(order, 1.0, integral, flow, next_, plain);
      add_product(order, 1.0, flow, next_, integral, transposed);
    }
    next_.set_zero(order);
    add_product(order, 1.0, flow, flow, next_, plain);
    std::swap(flow, next_);
  }
  if (unit != 1.0) {
    change_unit(order, states_, unit, 1.0 / unit, flow);
    for (MatrixJet& integral : integrals)
      change_unit(order, states_, 1.0 / unit, 1.0 / unit, integral);
  }
  // Rounding makes the two triangles differ in the last digit.
  for (MatrixJet& integral : integrals) {
    copy(order, integral, next_);
    symmetrise(order, 0.5, next_, integral);
  }
  return true;
}

}  // namespace saltus
