#include "tests/support/unsolvable_qp.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace saltus::testing {
namespace {

// Distance of a side beyond the attainable value. Below 1e-3, a tolerance of 1e-8 with multipliers
// of 1e5 could not detect it.
constexpr double smallest_gap = 1e-3, largest_gap = 10.0;

qp::RowGroup& add_rows(qp::Stage& s, std::vector<int> columns, int rows) {
  qp::RowGroup& g = s.groups.emplace_back();
  g.M = MatrixXd::Zero(rows, static_cast<int>(columns.size()));
  g.columns = std::move(columns);
  g.rows = rows;
  g.lower = VectorXd::Constant(rows, -infinity);
  g.upper = VectorXd::Constant(rows, infinity);
  g.l1 = g.l2 = VectorXd::Zero(rows);
  return g;
}

std::vector<int> columns_between(int first, int last) {
  std::vector<int> columns;
  for (int i = first; i < last; ++i) columns.push_back(i);
  return columns;
}

// Adds missing bounds at a distance from the point.
void close_box(VectorXd& lower, VectorXd& upper, const VectorXd& point) {
  for (int i = 0; i < point.size(); ++i) {
    lower[i] = std::max(lower[i], point[i] - 5.0);
    upper[i] = std::min(upper[i], point[i] + 5.0);
  }
}

double largest_product(const VectorXd& c, const VectorXd& lower, const VectorXd& upper) {
  double sum = 0.0;
  for (int i = 0; i < c.size(); ++i) sum += c[i] * (c[i] > 0.0 ? upper[i] : lower[i]);
  return sum;
}

}  // namespace

InfeasibleQp infeasible_qp(std::uint64_t seed, const RandomQpOptions& options) {
  const RandomQp feasible = random_qp(seed, options);
  Random random(seed ^ 0x9e3779b97f4a7c15u);  // numbers different from those of the program
  InfeasibleQp out{feasible.qp, "", random.log_uniform(smallest_gap, largest_gap)};
  const int N = out.qp.intervals();
  const int k = random.integer(0, N - 1);
  qp::Stage& s = out.qp.stages[k];
  const qp::StagePoint::AtStage& z = feasible.optimum.stages[k];
  const int kind = random.integer(0, 3);
  if (kind == 0) {
    out.proof = "a row above a bound, and its multiple below that bound";
    qp::RowGroup& g = add_rows(s, columns_between(0, s.nx + s.nu), 2);
    g.M.row(0) = random.matrix(1, s.nx + s.nu);
    g.M.row(1) = 2.0 * g.M.row(0);
    g.upper[0] = random.uniform(-1.0, 1.0);
    g.lower[1] = 2.0 * (g.upper[0] + out.gap);
  } else if (kind == 1) {
    out.proof = "contradictory equalities on a state and on the state and input before it";
    const VectorXd c = random.vector(out.qp.stages[k + 1].nx);
    qp::RowGroup& first = add_rows(s, columns_between(0, s.nx + s.nu), 1);
    first.M.row(0) << c.transpose() * s.A, c.transpose() * s.B;
    first.lower[0] = first.upper[0] = c.dot(s.A * z.x + s.B * z.u);
    qp::RowGroup& second = add_rows(out.qp.stages[k + 1], columns_between(0, c.size()), 1);
    second.M.row(0) = c.transpose();
    second.lower[0] = second.upper[0] = c.dot(feasible.optimum.stages[k + 1].x) + out.gap;
  } else {
    // Largest value that a row of the next state can take within the boxes of state and input.
    VectorXd x_lower = out.qp.start, x_upper = out.qp.start;
    if (k > 0 || !out.qp.fixed_start) {
      close_box(s.x_lower, s.x_upper, z.x);
      x_lower = s.x_lower;
      x_upper = s.x_upper;
    }
    close_box(s.u_lower, s.u_upper, z.u);
    qp::Stage& next = out.qp.stages[k + 1];
    VectorXd c = random.vector(next.nx);
    if (kind == 2) c = VectorXd::Unit(next.nx, random.integer(0, next.nx - 1));
    const double reach = largest_product(s.A.transpose() * c, x_lower, x_upper) +
                         largest_product(s.B.transpose() * c, s.u_lower, s.u_upper) + c.dot(s.b);
    if (kind == 2) {
      out.proof = "a bound of a state outside the range of the previous boxes";
      int i = 0;
      c.maxCoeff(&i);
      next.x_lower[i] = reach + out.gap;
      next.x_upper[i] = infinity;
    } else {
      out.proof = "a row on a state outside the range of the previous boxes";
      qp::RowGroup& g = add_rows(next, columns_between(0, next.nx), 1);
      g.M.row(0) = c.transpose();
      g.lower[0] = reach + out.gap;
    }
  }
  return out;
}

namespace {

// Removes an input from cost, rows and bounds. The sides of the rows are shifted so that their
// slacks at the point do not change.
void free_input(qp::Stage& s, const qp::StagePoint::AtStage& z, int i) {
  for (qp::RowGroup& g : s.groups) {
    for (std::size_t j = 0; j < g.columns.size(); ++j) {
      if (g.columns[j] != s.nx + i) continue;
      g.lower.head(g.rows) -= z.u[i] * g.M.col(j).head(g.rows);
      g.upper.head(g.rows) -= z.u[i] * g.M.col(j).head(g.rows);
      g.M.col(j).setZero();
    }
  }
  s.R.row(i).setZero();
  s.R.col(i).setZero();
  s.S.row(i).setZero();
  s.r[i] = 0.0;
  s.u_lower[i] = -infinity;
  s.u_upper[i] = infinity;
}

// Makes the given program unbounded. Returns false if the program is not suitable.
bool make_unbounded(UnboundedQp& out, const qp::StagePoint& optimum, Random& random) {
  const int N = out.qp.intervals();
  const int kind = random.integer(0, 2);
  const int k = kind == 2 ? N - 1 : random.integer(0, N - 1);
  qp::Stage& s = out.qp.stages[k];
  const qp::StagePoint::AtStage& z = optimum.stages[k];
  VectorXd& du = out.direction.stages[k].u;
  const double slope = -random.log_uniform(0.1, 10.0);
  if (s.nu < (kind == 1 ? 2 : 1)) return false;
  if (kind == 0) {
    out.proof = "an input that only decreases the cost, bounded on the other side";
    const int i = random.integer(0, s.nu - 1);
    const double sign = random.chance(0.5) ? 1.0 : -1.0;
    free_input(s, z, i);
    s.b += z.u[i] * s.B.col(i);
    s.B.col(i).setZero();
    s.r[i] = sign * slope;
    (sign > 0.0 ? s.u_lower : s.u_upper)[i] = z.u[i] - sign;
    du[i] = sign;
  } else if (kind == 1) {
    out.proof = "two inputs that cancel in the dynamics and decrease the cost";
    for (const int i : {0, 1}) free_input(s, z, i);
    s.b += z.u[1] * (s.B.col(1) + s.B.col(0));
    s.B.col(1) = -s.B.col(0);
    s.r[0] = slope;
    du[0] = du[1] = 1.0;
  } else {
    out.proof = "a last state with a linear cost alone, pushed by a free input";
    const int i = random.integer(0, s.nu - 1);
    free_input(s, z, i);
    qp::Stage& last = out.qp.stages[N];
    last.Q.setZero();
    last.S.setZero();
    last.groups.clear();
    last.x_lower.setConstant(-infinity);
    last.x_upper.setConstant(infinity);
    out.feasible.stages[N].group.clear();
    out.direction.stages[N].group.clear();
    const VectorXd step = s.B.col(i);
    if (step.squaredNorm() < 0.01) return false;
    last.q = slope / step.squaredNorm() * step;
    du[i] = 1.0;
    out.direction.stages[N].x = step;
  }
  out.slope = slope;
  return true;
}

}  // namespace

UnboundedQp unbounded_qp(std::uint64_t seed, const RandomQpOptions& options) {
  for (std::uint64_t s = seed;; s += 0x1000000) {
    const RandomQp bounded = random_qp(s, options);
    Random random(s ^ 0x9e3779b97f4a7c15u);
    UnboundedQp out{bounded.qp, bounded.optimum, qp::StagePoint(bounded.qp), 0.0, ""};
    if (make_unbounded(out, bounded.optimum, random)) return out;
  }
}

}  // namespace saltus::testing
