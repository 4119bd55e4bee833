#include "saltus/verify/plan_field.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus {

PlanField::PlanField(const Arguments& sizes, Function dynamics, std::vector<Function> integrands,
                     InputShape shape)
    : sizes_(sizes),
      dynamics_(std::move(dynamics)),
      integrands_(std::move(integrands)),
      active_(integrands_.size(), 1),
      shape_(shape),
      z_(sizes.size()),
      values_(sizes.nx) {}

void PlanField::load(const Plan::Interval& interval, const VectorXd& parameters) {
  start_ = interval.start;
  length_ = interval.length;
  coefficients_ = &interval.coefficients;
  parameters_ = &parameters;
  std::copy_n(parameters.data(), sizes_.np, z_.data() + sizes_.p());
}

const double* PlanField::argument(double s, const double* x) {
  z_[0] = start_ + s * length_;
  std::copy_n(x, sizes_.nx, z_.data() + sizes_.x());
  for (int i = 0; i < sizes_.nu; ++i) z_[sizes_.u(i)] = input_at_start(i) + s * input_change(i);
  return z_.data();
}

bool PlanField::rates(double s, const double* y, double* rates) {
  const double* z = argument(s, y);
  dynamics_.value(z, rates);
  for (std::size_t i = 0; i < integrands_.size(); ++i) {
    double* rate = rates + sizes_.nx + i;
    if (active_[i])
      integrands_[i].value(z, rate);
    else
      *rate = 0.0;
  }
  bool finite = true;
  for (int i = 0; i < outputs(); ++i) {
    rates[i] *= length_;
    finite = finite && std::isfinite(rates[i]);
  }
  return finite;
}

bool PlanField::state_jacobian(double s, const double* x, double* rows) {
  const SparsityPattern& pattern = dynamics_.jacobian_pattern();
  entries_.resize(pattern.entries());
  dynamics_.jacobian(argument(s, x), values_.data(), entries_.data());
  const int nx = sizes_.nx;
  std::fill_n(rows, nx * nx, 0.0);
  bool finite = true;
  pattern.for_each([&](int row, int column, int e) {
    if (column < sizes_.x() || column >= sizes_.x(nx)) return;
    rows[row * nx + column - sizes_.x()] = length_ * entries_[e];
    finite = finite && std::isfinite(entries_[e]);
  });
  return finite;
}

}  // namespace saltus
