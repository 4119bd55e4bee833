#include "benchmarks/measurement.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/core/bounds.hpp"
#include "saltus/core/clock.hpp"

namespace saltus::bench {
namespace {

// An interior-point method leaves products of 1e-8 and less: multipliers of inactive sides are
// below the tolerance over their distance, which is far larger than this for all but a few.
constexpr double binding_multiplier = 1e-4;

int count_binding(const VectorXd& multipliers, int size) {
  return static_cast<int>((multipliers.head(size).array().abs() > binding_multiplier).count());
}

}  // namespace

void Measurement::solve(qp::StageQpSolver& solver, const qp::StageQp& qp, qp::StagePoint& point,
                        bool warm, std::uint64_t seed) {
  const double begin = thread_microseconds();
  const qp::QpResult result = solver.solve(qp, point, warm);
  const double end = thread_microseconds();
  count(end - begin, result, kkt_residual(qp, point).largest(), seed);
}

void Measurement::count(double microseconds, const qp::QpResult& result, double residual,
                        std::uint64_t seed) {
  times_.push_back(microseconds);
  iterations_ += result.iterations;
  result_.iterations_max = std::max(result_.iterations_max, result.iterations);
  // std::max would drop a NaN. Infinity stays the largest.
  if (!(residual <= result_.kkt_max)) result_.kkt_max = std::isnan(residual) ? infinity : residual;
  if (result.status != qp::QpStatus::optimal || !(residual <= accepted_residual))
    result_.failures.push_back({seed, result.status, residual});
}

void Measurement::detail(const std::string& name, double value) {
  const auto at = std::find_if(result_.details.begin(), result_.details.end(),
                               [&](const Detail& d) { return d.name == name; });
  if (at == result_.details.end())
    result_.details.push_back({name, value});
  else
    at->value += value;
}

CaseResult Measurement::result() const {
  CaseResult result = result_;
  result.n = static_cast<int>(times_.size());
  result.microseconds = spread(times_);
  const double n = std::max(1, result.n);
  result.iterations_mean = iterations_ / n;
  for (Detail& d : result.details) d.value /= n;
  return result;
}

int binding_rows(const qp::StageQp& qp, const qp::StagePoint& point, int stage, int group) {
  return count_binding(point.stages[stage].group[group], qp.stages[stage].groups[group].rows);
}

int binding_bounds(const qp::StageQp& qp, const qp::StagePoint& point) {
  int binding = 0;
  for (std::size_t k = 0; k < qp.stages.size(); ++k) {
    if (k > 0 || !qp.fixed_start)
      binding += count_binding(point.stages[k].x_bound, qp.stages[k].nx);
    binding += count_binding(point.stages[k].u_bound, qp.stages[k].nu);
  }
  return binding;
}

}  // namespace saltus::bench
