#include "saltus/ocp/term.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {

Reference::Reference() = default;
Reference::Reference(const Reference& other) = default;
Reference::Reference(Reference&& other) noexcept = default;
Reference& Reference::operator=(const Reference& other) = default;
Reference& Reference::operator=(Reference&& other) noexcept = default;
Reference::~Reference() = default;

Reference::Reference(VectorXd value) : times_{0.0}, values_(std::move(value)) {}

Reference::Reference(std::vector<double> times, MatrixXd values)
    : times_(std::move(times)), values_(std::move(values)) {
  if (static_cast<long>(times_.size()) != values_.cols() || times_.empty())
    throw DefinitionError(
        fmt::format("reference: {} times but {} columns of values", times_.size(), values_.cols()));
  for (std::size_t i = 1; i < times_.size(); ++i)
    if (!(times_[i] > times_[i - 1]))
      throw DefinitionError(fmt::format("reference: time {} ({} s) is not after time {} ({} s)", i,
                                        times_[i], i - 1, times_[i - 1]));
  if (!std::isfinite(times_.front()) || !std::isfinite(times_.back()))
    throw DefinitionError(fmt::format("reference: its times are {} s to {} s, but must be finite",
                                      times_.front(), times_.back()));
}

void Reference::check_entry(int i) const {
  if (i < 0 || i >= size())
    throw DefinitionError(
        fmt::format("reference: it has {} entries, so there is no entry {}", size(), i));
}

int Reference::segment(double t) const {
  if (times_.size() < 2 || t < times_.front() || t >= times_.back()) return -1;
  const auto it = std::upper_bound(times_.begin(), times_.end(), t);
  return static_cast<int>(it - times_.begin()) - 1;
}

double Reference::at(double t, int i) const {
  if (is_zero()) return 0.0;
  check_entry(i);
  if (varies() && std::isnan(t)) return t;
  const int s = segment(t);
  if (s < 0) return values_(i, t < times_.front() ? 0 : values_.cols() - 1);
  return values_(i, s) + rate(t, i) * (t - times_[s]);
}

double Reference::rate(double t, int i) const {
  if (!varies()) return 0.0;
  check_entry(i);
  if (std::isnan(t)) return t;
  const int s = segment(t);
  if (s < 0) return 0.0;
  return (values_(i, s + 1) - values_(i, s)) / (times_[s + 1] - times_[s]);
}

bool Reference::is_finite() const { return values_.allFinite(); }

}  // namespace saltus
