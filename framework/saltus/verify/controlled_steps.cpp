#include "saltus/verify/controlled_steps.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {
namespace {

// Powers of the golden ratio 1.618..., relative to the interval or to the previous step.
constexpr double first_step = 0.05572809000084122;    // golden ratio to the power -6
constexpr double largest_step = 0.38196601125010515;  // golden ratio to the power -2
constexpr double most_growth = 4.23606797749979;      // golden ratio to the power 3
constexpr double most_shrinkage = 0.2360679774997897;
constexpr double safety = 0.9;
constexpr double smallest_step = 1e-13;
constexpr int most_explicit_steps = 3000, most_steps = 30000;

namespace pair54 {
constexpr double c[7] = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0};
constexpr double a[7][6] = {
    {},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
// b minus the b of order 4.
constexpr double e[7] = {71.0 / 57600,      0.0,        -71.0 / 16695, 71.0 / 1920,
                         -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
constexpr double d[7] = {-12715105075.0 / 11282082432,  0.0,
                         87487479700.0 / 32700410799,   -10690763975.0 / 1880347072,
                         701980252875.0 / 199316789632, -1453857185.0 / 822651844,
                         69997945.0 / 29380423};
}  // namespace pair54

namespace sdirk {
constexpr double gamma = 1.0 / 4;
constexpr double c[5] = {1.0 / 4, 3.0 / 4, 11.0 / 20, 1.0 / 2, 1.0};
constexpr double a[5][5] = {{1.0 / 4},
                            {1.0 / 2, 1.0 / 4},
                            {17.0 / 50, -1.0 / 25, 1.0 / 4},
                            {371.0 / 1360, -137.0 / 2720, 15.0 / 544, 1.0 / 4},
                            {25.0 / 24, -49.0 / 48, 125.0 / 16, -85.0 / 12, 1.0 / 4}};
// b minus the b of order 3; b is the last row of a.
constexpr double e[5] = {25.0 / 24 - 59.0 / 48, -49.0 / 48 + 17.0 / 96, 125.0 / 16 - 225.0 / 32,
                         0.0, 1.0 / 4};
}  // namespace sdirk

}  // namespace

ControlledSteps::ControlledSteps(PlanField& field, double tolerance)
    : field_(field),
      n_(field.outputs()),
      nx_(field.states()),
      tolerance_(tolerance),
      units_(VectorXd::Ones(n_)),
      y_(n_),
      next_(n_),
      stage_(n_),
      error_(n_),
      polynomial_((degree + 1) * n_),
      jacobian_(nx_ * nx_),
      newton_(nx_),
      k_(7, std::vector<double>(n_)),
      lu_(nx_) {}

void ControlledSteps::begin(double s, const double* y) {
  s_ = s;
  h_ = std::min(first_step, 1.0 - s);
  steps_ = stiff_signs_ = 0;
  rejected_ = has_rate_ = has_factors_ = false;
  std::copy_n(y, n_, y_.data());
}

void ControlledSteps::retry_before(double theta) {
  h_ = std::max(0.5 * theta * length_, 2.0 * smallest_step);
  s_ = start_;
  rejected_ = true;
  has_rate_ = has_factors_ = false;
  std::copy_n(polynomial_.data(), n_, y_.data());
}

double ControlledSteps::size_of(int i) const {
  return tolerance_ * std::max(units_[i], std::max(std::abs(y_[i]), std::abs(next_[i])));
}

bool ControlledSteps::step() {
  if (!has_rate_) {
    if (!field_.rates(s_, y_.data(), k_[0].data())) return false;
    has_rate_ = true;
  }
  while (h_ > smallest_step && steps_ < most_steps) {
    ++steps_;
    if (!implicit_ && steps_ > most_explicit_steps) implicit_ = true;
    h_ = std::min({h_, largest_step, 1.0 - s_});
    if (1.0 - s_ - h_ < smallest_step) h_ = 1.0 - s_;
    if (implicit_ ? step_implicit() : step_explicit()) return true;
  }
  return false;
}

// Accepts the step or proposes a different size.
bool ControlledSteps::accept(double error, int order) {
  const double factor = std::isfinite(error)
                            ? safety * std::pow(std::max(error, 1e-10), -1.0 / order)
                            : most_shrinkage;
  const double h = h_;
  h_ *= std::clamp(factor, most_shrinkage, rejected_ ? 1.0 : most_growth);
  rejected_ = !(error <= 1.0);
  if (rejected_) return false;
  start_ = s_;
  length_ = h;
  s_ = 1.0 - s_ - h < smallest_step ? 1.0 : s_ + h;
  return true;
}

bool ControlledSteps::step_explicit() {
  using namespace pair54;
  was_explicit_ = true;
  const double h = h_;
  bool finite = true;
  for (int i = 1; i < 7 && finite; ++i) {
    std::vector<double>& at = i == 6 ? next_ : stage_;
    for (int r = 0; r < n_; ++r) {
      double sum = 0.0;
      for (int j = 0; j < i; ++j) sum += a[i][j] * k_[j][r];
      at[r] = y_[r] + h * sum;
    }
    finite = field_.rates(s_ + c[i] * h, at.data(), k_[i].data());
  }
  double error = 0.0, rates = 0.0, states = 0.0;
  for (int r = 0; r < n_ && finite; ++r) {
    double sum = 0.0;
    for (int j = 0; j < 7; ++j) sum += e[j] * k_[j][r];
    error = std::max(error, std::abs(h * sum) / size_of(r));
    if (r >= nx_) continue;
    rates = std::max(rates, std::abs(k_[6][r] - k_[5][r]) / size_of(r));
    states = std::max(states, std::abs(next_[r] - stage_[r]) / size_of(r));
  }
  if (!accept(finite ? error : NAN, 5)) return false;
  // If stability, not accuracy, limits the step many times, the field is stiff.
  constexpr double edge_of_stability = 3.25;
  constexpr int certain = 15;
  if (h * rates > edge_of_stability * states)
    implicit_ = ++stiff_signs_ >= certain;
  else if (stiff_signs_ > 0)
    --stiff_signs_;
  interpolate_explicit(h);
  std::swap(y_, next_);
  std::swap(k_[0], k_[6]);
  return true;
}

void ControlledSteps::interpolate_explicit(double h) {
  for (int r = 0; r < n_; ++r) {
    double sum = 0.0;
    for (int j = 0; j < 7; ++j) sum += pair54::d[j] * k_[j][r];
    const double change = next_[r] - y_[r];
    const double third = h * k_[0][r] - change, fourth = change - h * k_[6][r] - third;
    const double fifth = h * sum;
    polynomial_[r] = y_[r];
    polynomial_[n_ + r] = change + third;
    polynomial_[2 * n_ + r] = -third + fourth + fifth;
    polynomial_[3 * n_ + r] = -fourth - 2.0 * fifth;
    polynomial_[4 * n_ + r] = fifth;
  }
}

// k = F(s + c h, y + h sum_j a_j k_j + h gamma k), solved by simplified Newton steps.
bool ControlledSteps::solve_stage(int stage, double h) {
  using namespace sdirk;
  constexpr int most_iterations = 8;
  constexpr double enough = 1e-3;  // fraction of the tolerance of a step
  std::vector<double>& k = k_[stage + 1];
  std::vector<double>& rates = error_;  // unused until the error is computed
  if (stage == 0)
    k = k_[0];
  else
    k = k_[stage];
  double before = INFINITY;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    for (int r = 0; r < n_; ++r) {
      double sum = gamma * k[r];
      for (int j = 0; j < stage; ++j) sum += a[stage][j] * k_[j + 1][r];
      stage_[r] = y_[r] + h * sum;
    }
    if (!field_.rates(s_ + c[stage] * h, stage_.data(), rates.data())) return false;
    for (int r = 0; r < nx_; ++r) newton_[r] = rates[r] - k[r];
    lu_.solve(newton_.data());
    double change = 0.0;
    for (int r = 0; r < nx_; ++r) {
      k[r] += newton_[r];
      change = std::max(change, std::abs(h * gamma * newton_[r]) / size_of(r));
    }
    for (int r = nx_; r < n_; ++r) k[r] = rates[r];
    if (change <= enough) return true;
    if (!(change < 2.0 * before)) return false;
    before = change;
  }
  return false;
}

bool ControlledSteps::step_implicit() {
  using namespace sdirk;
  const double h = h_;
  if (!has_factors_ && !field_.state_jacobian(s_, y_.data(), jacobian_.data()))
    return accept(NAN, 4);
  if (!has_factors_ || factored_h_ != h) {
    for (int r = 0; r < nx_; ++r)
      for (int j = 0; j < nx_; ++j)
        lu_.row(r)[j] = (r == j ? 1.0 : 0.0) - h * gamma * jacobian_[r * nx_ + j];
    if (!lu_.factor()) return accept(NAN, 4);
    factored_h_ = h;
  }
  has_factors_ = true;
  next_ = y_;
  for (int stage = 0; stage < 5; ++stage)
    if (!solve_stage(stage, h)) return accept(NAN, 4);
  std::vector<double>& estimate = error_;
  for (int r = 0; r < n_; ++r) {
    double sum = 0.0, sum_e = 0.0;
    for (int j = 0; j < 5; ++j) {
      sum += a[4][j] * k_[j + 1][r];
      sum_e += e[j] * k_[j + 1][r];
    }
    next_[r] = y_[r] + h * sum;
    estimate[r] = h * sum_e;
  }
  lu_.solve(estimate.data());  // the raw difference overestimates the error of stiff components
  double error = 0.0;
  for (int r = 0; r < n_; ++r) error = std::max(error, std::abs(estimate[r]) / size_of(r));
  if (!accept(error, 4)) return false;
  interpolate_implicit(h);
  std::swap(y_, next_);
  std::swap(k_[0], k_[5]);
  has_factors_ = false;
  return true;
}

void ControlledSteps::interpolate_implicit(double h) {
  for (int r = 0; r < n_; ++r) {
    const double change = next_[r] - y_[r], first = h * k_[0][r], last = h * k_[5][r];
    polynomial_[r] = y_[r];
    polynomial_[n_ + r] = first;
    polynomial_[2 * n_ + r] = 3.0 * change - 2.0 * first - last;
    polynomial_[3 * n_ + r] = first + last - 2.0 * change;
    polynomial_[4 * n_ + r] = 0.0;
  }
}

void ControlledSteps::state_at(double theta, double* y) const {
  for (int r = 0; r < n_; ++r) {
    double value = polynomial_[degree * n_ + r];
    for (int k = degree - 1; k >= 0; --k) value = value * theta + polynomial_[k * n_ + r];
    y[r] = value;
  }
}

}  // namespace saltus
