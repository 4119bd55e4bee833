// C. Lawson and R. Hanson, Solving Least Squares Problems, chapter 23.
#include "tests/corpus/stationarity.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace saltus::corpus {
namespace {

constexpr double complex_step = 1e-30;
constexpr double active_within = 1e-4;  // relative to 1 and the bound

// Variables of the plan that the solver determines, as directions of derivatives.
struct Variable {
  int piece = -1;  // inputs
  int input = 0;
  bool at_end = false;  // selects the second coefficient of a linear input
  int phase = -1;       // a duration
  double value = 0.0, size = 1.0;
  Bounds bounds;
};

struct Row {
  Bounds bounds;
  double value = 0.0;
};

class SingleShooting {
 public:
  SingleShooting(const std::vector<OutsidePhase>& phases, const std::vector<PlanPiece>& plan)
      : phases_(phases), plan_(plan) {
    std::vector<double> largest(16, 0.0);
    for (std::size_t k = 0; k < plan.size(); ++k) {
      const PlanPiece& piece = plan[k];
      const OutsidePhase& phase = phases[piece.phase];
      for (int i = 0; i < phase.nu; ++i) {
        for (const bool at_end : {false, true}) {
          if (at_end && !piece.is_linear) continue;
          const double value = at_end ? piece.last_input[i] : piece.first_input[i];
          largest[i] = std::max(largest[i], std::abs(value));
          variables_.push_back(
              {static_cast<int>(k), i, at_end, -1, value, 1.0, phase.input_bounds[i]});
        }
      }
      if (!phase.duration.is_equality() && (k == 0 || plan[k - 1].phase != piece.phase)) {
        double length = 0.0;
        for (const PlanPiece& other : plan)
          if (other.phase == piece.phase) length += other.length;
        variables_.push_back({-1, 0, false, piece.phase, length, length, phase.duration});
      }
    }
    for (Variable& v : variables_)
      if (v.phase < 0) v.size = largest[v.input] > 0.0 ? largest[v.input] : 1.0;
  }

  const std::vector<Variable>& variables() const { return variables_; }

  // Cost and rows with an imaginary step in one variable, or without a step for -1.
  Complex run(int stepped, std::vector<Row>* bounds, std::vector<Complex>& rows) const {
    rows.clear();
    Complex cost = 0.0;
    const OutsidePhase* last = nullptr;
    std::vector<Complex> x(plan_.front().state.data(),
                           plan_.front().state.data() + plan_.front().state.size());
    Complex t = plan_.front().start, phase_start = t;
    for (std::size_t k = 0; k < plan_.size(); ++k) {
      const PlanPiece& piece = plan_[k];
      const OutsidePhase& phase = phases_[piece.phase];
      if (last != &phase) {
        if (last != nullptr && phase.entry.value) {
          std::vector<Complex> z{t};
          z.insert(z.end(), x.begin(), x.end());
          x.resize(phase.entry.rows);
          phase.entry.complex_value(z.data(), x.data());
        }
        phase_start = t;
        last = &phase;
      }
      std::vector<Complex> first(piece.first_input.data(), piece.first_input.data() + phase.nu);
      std::vector<Complex> end(piece.last_input.data(), piece.last_input.data() + phase.nu);
      Complex length = piece.length;
      if (stepped >= 0) {
        const Variable& v = variables_[stepped];
        const Complex step(0.0, complex_step);
        if (v.piece == static_cast<int>(k)) {
          if (!v.at_end) first[v.input] += step;
          if (v.at_end || !piece.is_linear) end[v.input] += step;
        }
        if (v.phase == piece.phase) length += step * (piece.length / v.value);
      }
      append_path(phase, t, phase_start, x, first, rows, bounds);
      cost += advance(phase, t, length, x, first, end);
      t += length;
      if (k + 1 == plan_.size() || plan_[k + 1].phase != piece.phase) {
        append_path(phase, t, phase_start, x, end, rows, bounds);
        cost += append_end(phase, t, x, end, rows, bounds);
      }
    }
    return cost;
  }

 private:
  static std::vector<Complex> argument(Complex t, const std::vector<Complex>& x,
                                       const std::vector<Complex>& u) {
    std::vector<Complex> z{t};
    z.insert(z.end(), x.begin(), x.end());
    z.insert(z.end(), u.begin(), u.end());
    return z;
  }
  static void append(const OutsideRow& row, const std::vector<Complex>& z,
                     std::vector<Complex>& rows, std::vector<Row>* bounds) {
    std::vector<Complex> y(row.formula.rows);
    row.formula.complex_value(z.data(), y.data());
    for (int i = 0; i < row.formula.rows; ++i) {
      rows.push_back(y[i]);
      if (bounds != nullptr) bounds->push_back({row.bounds[i], y[i].real()});
    }
  }
  static void append_path(const OutsidePhase& phase, Complex t, Complex phase_start,
                          const std::vector<Complex>& x, const std::vector<Complex>& u,
                          std::vector<Complex>& rows, std::vector<Row>* bounds) {
    const double since = (t - phase_start).real();
    for (const OutsideRow& row : phase.path)
      if (since >= row.from - 1e-9 && since <= row.to + 1e-9)
        append(row, argument(t, x, u), rows, bounds);
  }
  static Complex append_end(const OutsidePhase& phase, Complex t, const std::vector<Complex>& x,
                            const std::vector<Complex>& u, std::vector<Complex>& rows,
                            std::vector<Row>* bounds) {
    const std::vector<Complex> z = argument(t, x, u);
    for (const OutsideRow& row : phase.ends) append(row, z, rows, bounds);
    Complex cost = 0.0;
    for (const OutsideFormula& f : phase.end_costs) {
      Complex value = 0.0;
      f.complex_value(z.data(), &value);
      cost += value;
    }
    return cost;
  }

  // Eight steps of the classical Runge-Kutta method. Returns the running costs.
  Complex advance(const OutsidePhase& phase, Complex t, Complex length, std::vector<Complex>& x,
                  const std::vector<Complex>& first, const std::vector<Complex>& end) const {
    constexpr int steps = 8;
    const int n = phase.nx;
    std::vector<Complex> z(1 + n + phase.nu), k1(n + 1), k2(n + 1), k3(n + 1), k4(n + 1);
    const auto rate = [&](double s, const std::vector<Complex>* k, double factor,
                          std::vector<Complex>& result) {
      z[0] = t + s * length;
      for (int i = 0; i < n; ++i)
        z[1 + i] = x[i] + (k == nullptr ? 0.0 : factor * length * (*k)[i]);
      for (int i = 0; i < phase.nu; ++i) z[1 + n + i] = first[i] + s * (end[i] - first[i]);
      phase.field.complex_value(z.data(), result.data());
      result[n] = 0.0;
      for (const OutsideFormula& f : phase.running_costs) {
        Complex value = 0.0;
        f.complex_value(z.data(), &value);
        result[n] += value;
      }
    };
    Complex cost = 0.0;
    const double h = 1.0 / steps;
    for (int j = 0; j < steps; ++j) {
      const double s = j * h;
      rate(s, nullptr, 0.0, k1);
      rate(s + 0.5 * h, &k1, 0.5 * h, k2);
      rate(s + 0.5 * h, &k2, 0.5 * h, k3);
      rate(s + h, &k3, h, k4);
      for (int i = 0; i <= n; ++i) {
        const Complex change = h / 6.0 * length * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        if (i < n)
          x[i] += change;
        else
          cost += change;
      }
    }
    return cost;
  }

  const std::vector<OutsidePhase>& phases_;
  const std::vector<PlanPiece>& plan_;
  std::vector<Variable> variables_;
};

// +1: at the upper bound, -1: at the lower one, 2: an equality, 0: inactive.
int activity(const Bounds& b, double value, double size) {
  if (b.is_equality()) return 2;
  const auto near = [&](double side) {
    return std::isfinite(side) &&
           std::abs(value - side) <= active_within * std::max(size, std::abs(side));
  };
  return near(b.upper) ? 1 : near(b.lower) ? -1 : 0;
}

}  // namespace

VectorXd non_negative_least_squares(const MatrixXd& a, const VectorXd& b,
                                    const std::vector<bool>& free) {
  const int n = static_cast<int>(a.cols());
  VectorXd x = VectorXd::Zero(n);
  std::vector<bool> inside(free);
  const double floor = 1e-12 * (1.0 + b.norm());
  for (int round = 0; round < 3 * n + 10; ++round) {
    for (;;) {
      std::vector<int> columns;
      for (int j = 0; j < n; ++j)
        if (inside[j]) columns.push_back(j);
      VectorXd trial = VectorXd::Zero(n);
      if (!columns.empty()) {
        const MatrixXd part = a(Eigen::all, columns);
        trial(columns) = part.completeOrthogonalDecomposition().solve(b).eval();
      }
      double step = 1.0;
      for (const int j : columns)
        if (!free[j] && trial[j] <= 0.0 && x[j] > trial[j])
          step = std::min(step, x[j] / (x[j] - trial[j]));
      x += step * (trial - x);
      if (step >= 1.0) break;
      for (const int j : columns)
        if (!free[j] && x[j] <= 1e-14 * (1.0 + x.lpNorm<Eigen::Infinity>())) {
          x[j] = 0.0;
          inside[j] = false;
        }
    }
    const VectorXd slope = a.transpose() * (b - a * x);
    int best = -1;
    for (int j = 0; j < n; ++j)
      if (!inside[j] && slope[j] > floor * (1.0 + a.col(j).norm()) &&
          (best < 0 || slope[j] > slope[best]))
        best = j;
    if (best < 0) break;
    inside[best] = true;
  }
  return x;
}

Stationarity stationarity(const std::vector<OutsidePhase>& phases,
                          const std::vector<PlanPiece>& plan, double cost_scale) {
  const SingleShooting shooting(phases, plan);
  const int n = static_cast<int>(shooting.variables().size());
  std::vector<Row> rows;
  std::vector<Complex> values;
  const double cost = shooting.run(-1, &rows, values).real();
  VectorXd gradient(n);
  MatrixXd slopes(rows.size(), n);  // scaled by the sizes of the variables
  for (int i = 0; i < n; ++i) {
    const double scale = shooting.variables()[i].size / complex_step;
    gradient[i] = shooting.run(i, nullptr, values).imag() * scale;
    for (std::size_t r = 0; r < rows.size(); ++r) slopes(r, i) = values[r].imag() * scale;
  }
  std::vector<VectorXd> columns;
  std::vector<bool> free;
  const auto add = [&](const VectorXd& normal, int side) {
    const double norm = normal.norm();
    if (!(norm > 0.0)) return;
    columns.push_back(-normal / norm * (side == -1 ? -1.0 : 1.0));
    free.push_back(side == 2);
  };
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (const int side = activity(rows[r].bounds, rows[r].value, 1.0)) add(slopes.row(r), side);
  for (int i = 0; i < n; ++i) {
    const Variable& v = shooting.variables()[i];
    const VectorXd unit = VectorXd::Unit(n, i);
    if (const int side = activity(v.bounds, v.value, v.size)) add(unit, side);
  }
  MatrixXd a(n, columns.size());
  for (std::size_t j = 0; j < columns.size(); ++j) a.col(j) = columns[j];
  const VectorXd rest = columns.empty()
                            ? gradient
                            : (gradient - a * non_negative_least_squares(a, gradient, free)).eval();
  const double size = std::max({std::abs(cost), gradient.lpNorm<Eigen::Infinity>(), cost_scale});
  Stationarity result;
  if (n == 0 || !(size > 0.0)) return result;
  int worst = 0;
  const double largest = rest.cwiseAbs().maxCoeff(&worst);
  const Variable& v = shooting.variables()[worst];
  result.residual = std::isfinite(rest.sum()) ? largest / size : infinity;
  result.variable = v.phase >= 0
                        ? fmt::format("duration of '{}'", phases[v.phase].name)
                        : fmt::format("input {} at {:.4g} s", v.input, plan[v.piece].start);
  return result;
}

}  // namespace saltus::corpus
