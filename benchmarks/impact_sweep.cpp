#include "benchmarks/impact_sweep.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "benchmarks/push_recovery_cases.hpp"
#include "saltus/solver/ipopt.hpp"

namespace saltus::push_recovery {
namespace {

// The tolerance is far below the changes between neighbouring points of the sweep.
constexpr double solver_tolerance = 1e-10;

MultipleShooting transcribe_variant(const SweepVariant& variant) {
  QpCase c = read_case("ICUB-1");
  c.model.step = variant.step;
  c.model.intervals = variant.intervals;
  c.model.cost_rule = variant.cost_rule;
  c.weights.wrench_change = variant.wrench_change;
  MultipleShooting shooting = transcribe(c);
  VectorXd previous = VectorXd::Zero(12);
  previous.head<3>() = c.data.force;  // on the stance foot alone, without torque
  shooting.set_previous_input(previous);
  return shooting;
}

}  // namespace

std::string SweepVariant::name() const {
  return fmt::format("{:g} ms, N = {}, {}{}", 1e3 * step, intervals,
                     cost_rule == CostRule::nodes ? "node-summed" : "integrated",
                     wrench_change > 0.0 ? ", first differences" : "");
}

std::vector<SweepVariant> sweep_variants() {
  constexpr double published_wrench_change = 1e-4;  // from the first author's controller
  std::vector<SweepVariant> variants;
  for (const auto& [step, intervals] : {std::pair{0.01, 15}, {0.05, 3}, {0.05, 15}})
    for (const CostRule rule : {CostRule::nodes, CostRule::integrated})
      for (const double change : {0.0, published_wrench_change})
        variants.push_back({step, intervals, rule, change});
  return variants;
}

ImpactSweep::ImpactSweep(const SweepVariant& variant)
    : variant_(variant),
      shooting_(transcribe_variant(variant)),
      solver_(make_ipopt({.tolerance = solver_tolerance})) {}

ImpactSweep::~ImpactSweep() = default;

SweepPoint ImpactSweep::solve(double impact_time) {
  shooting_.retime("impact", impact_time);
  bool is_warm = last_.ok();
  if (is_warm) {
    // Shifts states and inputs in time and keeps the multipliers, because the rows keep their
    // order.
    NlpPoint start = last_.point;
    start.w = shooting_.guess_from(last_.trajectory).w;
    last_ = saltus::solve(shooting_, *solver_, start);
    is_warm = last_.ok();
  }
  if (!is_warm) last_ = saltus::solve(shooting_, *solver_);
  SweepPoint point;
  point.impact_time = impact_time;
  point.status = last_.status;
  point.cost = last_.cost;
  if (!last_.trajectory.empty()) point.first_input = last_.trajectory.pieces().front().coefficients;
  point.kkt = last_.kkt.scaled();
  point.iterations = last_.iterations;
  return point;
}

SweepPoint ImpactSweep::solve_rounded(double impact_time) {
  const long node = std::lround(impact_time / variant_.step);
  if (node != rounded_node_) rounded_ = solve(static_cast<double>(node) * variant_.step);
  rounded_node_ = node;
  rounded_.impact_time = impact_time;
  return rounded_;
}

std::vector<double> sweep_times(double step) {
  const auto count = std::lround((sweep_end - sweep_begin) / step);
  std::vector<double> times;
  for (long i = 0; i <= count; ++i)
    times.push_back(sweep_begin + (sweep_end - sweep_begin) * static_cast<double>(i) /
                                      static_cast<double>(count));
  return times;
}

Change largest_change(const std::vector<SweepPoint>& points) {
  Change largest;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const SweepPoint &a = points[i - 1], &b = points[i];
    const double cost = std::abs(b.cost - a.cost);
    const double input = (b.first_input - a.first_input).cwiseAbs().maxCoeff();
    if (cost > largest.cost) largest.cost = cost, largest.cost_step = i - 1;
    if (input > largest.input) largest.input = input, largest.input_step = i - 1;
  }
  return largest;
}

}  // namespace saltus::push_recovery
