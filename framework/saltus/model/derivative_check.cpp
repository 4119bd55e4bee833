#include "saltus/model/derivative_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <ostream>
#include <random>

namespace saltus {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
// Relative change below which the derivative of an output cannot be measured: if terms of order one
// cancel, only rounding remains.
constexpr double smallest_change = 1e-5;

// Columns d g / d z_j by central differences at steps h_j and h_j / 2, extrapolated to order h_j^4.
MatrixXd differences(const std::function<VectorXd(const VectorXd&)>& g, const VectorXd& z,
                     const VectorXd& steps) {
  MatrixXd columns(g(z).size(), z.size());
  for (int j = 0; j < z.size(); ++j) {
    const auto central = [&](double h) -> VectorXd {
      VectorXd ahead = z, behind = z;
      ahead[j] += h;
      behind[j] -= h;
      return (g(ahead) - g(behind)) / (ahead[j] - behind[j]);  // the step as rounded
    };
    columns.col(j) = (4.0 * central(steps[j] / 2.0) - central(steps[j])) / 3.0;
  }
  return columns;
}

// `unit` converts the entry to the scale of the comparison.
DerivativeReport::Entry compare(int row, int col, double exact, double difference, double rounding,
                                double unit, bool in_pattern) {
  DerivativeReport::Entry entry{row, col, exact, difference, 0.0, in_pattern, 0};
  const double gap = std::abs(exact - difference);
  entry.error = std::isfinite(gap)
                    ? unit * std::max(0.0, gap - rounding) / std::max(1.0, unit * std::abs(exact))
                    : std::numeric_limits<double>::infinity();
  return entry;
}

void note(const DerivativeReport::Entry& entry, double tolerance, DerivativeReport::Entry& worst,
          std::vector<DerivativeReport::Entry>& failures) {
  if (worst.row < 0 || entry.error > worst.error) worst = entry;
  if (entry.error > tolerance) failures.push_back(entry);
}

void sort_and_judge(DerivativeReport& report) {
  const auto worse = [](const DerivativeReport::Entry& a, const DerivativeReport::Entry& b) {
    return a.error > b.error;
  };
  std::stable_sort(report.jacobian_failures.begin(), report.jacobian_failures.end(), worse);
  std::stable_sort(report.hessian_failures.begin(), report.hessian_failures.end(), worse);
  report.ok = report.jacobian_failures.empty() && report.hessian_failures.empty();
}

std::string name_of(int index, const std::vector<std::string>& names, const char* symbol) {
  if (index < static_cast<int>(names.size())) return fmt::format("{}", names[index]);
  return fmt::format("{}[{}]", symbol, index);
}

std::string table(const std::string& title, const std::vector<DerivativeReport::Entry>& failures,
                  const DerivativeReport& report, bool second) {
  constexpr std::size_t most = 10;
  std::string text =
      fmt::format("{}: {} wrong\n  {:>18} {:>18} {:>15} {:>15} {:>9}\n", title, failures.size(),
                  second ? "input" : "output", "input", "function", "difference", "error");
  for (std::size_t k = 0; k < std::min(most, failures.size()); ++k) {
    const DerivativeReport::Entry& e = failures[k];
    text += fmt::format(
        "  {:>18} {:>18} {:>15.8g} {:>15.8g} {:>9.1e}{}{}\n",
        second ? name_of(e.row, report.input_names, "z") : name_of(e.row, report.output_names, "y"),
        name_of(e.col, report.input_names, "z"), e.exact, e.difference, e.error,
        e.in_pattern ? "" : "  missing from the pattern",
        report.points > 1 ? fmt::format("  at point {}", e.point) : "");
  }
  if (failures.size() > most) text += fmt::format("  and {} more\n", failures.size() - most);
  return text;
}

}  // namespace

DerivativeReport check_derivatives(const Function& function, const VectorRef& z,
                                   const DerivativeCheckOptions& options) {
  DerivativeReport report;
  report.tolerance = options.tolerance;
  report.input_names = options.input_names;
  report.output_names = options.output_names;

  const bool has_magnitudes = options.magnitudes.size() > 0;
  const VectorXd magnitudes = has_magnitudes ? options.magnitudes : VectorXd::Ones(z.size());
  const VectorXd steps = options.step * magnitudes.cwiseMax(z.cwiseAbs());
  const auto rounding = [&](double size, int j) { return 8.0 * epsilon * size / steps[j]; };

  const VectorXd y = function(z);
  const MatrixXd jacobian = function.dense_jacobian(z);
  const MatrixXd slopes = differences([&](const VectorXd& at) { return function(at); }, z, steps);
  VectorXd changes = VectorXd::Ones(function.outputs());
  if (has_magnitudes)
    changes =
        (jacobian.cwiseAbs().cwiseMax(slopes.cwiseAbs()) * magnitudes).cwiseMax(smallest_change);
  for (int i = 0; i < function.outputs(); ++i)
    for (int j = 0; j < function.inputs(); ++j)
      note(compare(i, j, jacobian(i, j), slopes(i, j), rounding(std::abs(y[i]), j),
                   magnitudes[j] / changes[i], function.jacobian_pattern().contains(i, j)),
           options.tolerance, report.worst_jacobian, report.jacobian_failures);

  VectorXd weights = options.weights;
  if (weights.size() == 0) {
    weights.resize(function.outputs());
    for (int i = 0; i < weights.size(); ++i) weights[i] = 1.0 + 0.5 * std::sin(1.0 + i);
  }
  weights = weights.cwiseQuotient(changes);
  const MatrixXd hessian = function.dense_hessian(z, weights);
  const MatrixXd curvature = differences(
      [&](const VectorXd& at) -> VectorXd {
        return function.dense_jacobian(at).transpose() * weights;
      },
      z, steps);
  const VectorXd gradient = (jacobian.transpose() * weights).cwiseAbs();
  for (int i = 0; i < function.inputs(); ++i)
    for (int j = 0; j <= i; ++j)
      note(compare(i, j, hessian(i, j), curvature(i, j), rounding(gradient[i], j),
                   magnitudes[i] * magnitudes[j], function.hessian_pattern().contains(i, j)),
           options.tolerance, report.worst_hessian, report.hessian_failures);

  sort_and_judge(report);
  return report;
}

DerivativeReport check_derivatives(const Function& function, const VectorRef& lower,
                                   const VectorRef& upper, int points, std::uint32_t seed,
                                   const DerivativeCheckOptions& options) {
  DerivativeReport all;
  all.points = points;
  all.seed = seed;
  all.tolerance = options.tolerance;
  all.input_names = options.input_names;
  all.output_names = options.output_names;
  std::mt19937 random(seed);
  for (int k = 0; k < points; ++k) {
    VectorXd z(function.inputs());
    for (int j = 0; j < z.size(); ++j)  // uniform_real_distribution differs between libraries
      z[j] = lower[j] + (upper[j] - lower[j]) * (random() / 4294967296.0);
    DerivativeReport one = check_derivatives(function, z, options);
    const auto merge = [&](DerivativeReport::Entry& worst, DerivativeReport::Entry& candidate,
                           std::vector<DerivativeReport::Entry>& failures,
                           std::vector<DerivativeReport::Entry>& more) {
      candidate.point = k;
      if (worst.row < 0 || candidate.error > worst.error) worst = candidate;
      for (DerivativeReport::Entry& entry : more) {
        entry.point = k;
        failures.push_back(entry);
      }
    };
    merge(all.worst_jacobian, one.worst_jacobian, all.jacobian_failures, one.jacobian_failures);
    merge(all.worst_hessian, one.worst_hessian, all.hessian_failures, one.hessian_failures);
  }
  sort_and_judge(all);
  return all;
}

std::string to_string(const DerivativeReport& report) {
  std::string text = fmt::format(
      "derivatives {} at {} point{}{}: worst scaled error {:.1e} (Jacobian), {:.1e} (Hessian), "
      "accepted {:.1e}\n",
      report.ok ? "agree with differences" : "DIFFER from differences", report.points,
      report.points == 1 ? "" : "s", report.seed ? fmt::format(" (seed {})", *report.seed) : "",
      report.worst_jacobian.error, report.worst_hessian.error, report.tolerance);
  if (!report.jacobian_failures.empty())
    text += table("Jacobian", report.jacobian_failures, report, false);
  if (!report.hessian_failures.empty())
    text += table("Hessian of the weighted sum", report.hessian_failures, report, true);
  return text;
}

std::ostream& operator<<(std::ostream& out, const DerivativeReport& report) {
  return out << to_string(report);
}

}  // namespace saltus
