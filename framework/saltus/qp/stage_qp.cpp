#include "saltus/qp/stage_qp.hpp"

#include <algorithm>

#include "saltus/qp/side_residual.hpp"

namespace saltus::qp {
namespace {

// Active sizes may be smaller than the arrays: only leading parts are read. Products are sums over
// columns because a product of run-time size allocates.

double state_or_input(const Stage& s, const StagePoint::AtStage& p, int i) {
  return i < s.nx ? p.x[i] : p.u[i - s.nx];
}

double row_value(const Stage& s, const StagePoint::AtStage& p, const RowGroup& g, int row) {
  double value = 0.0;
  for (std::size_t j = 0; j < g.columns.size(); ++j)
    value += g.M(row, j) * state_or_input(s, p, g.columns[j]);
  return value;
}

// Entry i of M'lambda, summed over all rows of the stage.
double pull_of_rows(const Stage& s, const StagePoint::AtStage& p, int i) {
  double pull = 0.0;
  for (std::size_t k = 0; k < s.groups.size(); ++k) {
    const RowGroup& g = s.groups[k];
    const auto at = std::lower_bound(g.columns.begin(), g.columns.end(), i);
    if (at == g.columns.end() || *at != i) continue;
    pull += g.M.col(at - g.columns.begin()).head(g.rows).dot(p.group[k].head(g.rows));
  }
  return pull;
}

// Computes y'A x of the leading rows and columns, four rows at a time.
double form(const VectorXd& y, const MatrixXd& A, const VectorXd& x, int rows, int columns) {
  Eigen::Array4d fours = Eigen::Array4d::Zero();
  int i = 0;
  for (; i + 4 <= rows; i += 4) {
    Eigen::Array4d product = Eigen::Array4d::Zero();
    for (int j = 0; j < columns; ++j) product += A.col(j).segment<4>(i).array() * x[j];
    fours += product * y.segment<4>(i).array();
  }
  double value = fours.sum();
  for (; i < rows; ++i)
    for (int j = 0; j < columns; ++j) value += y[i] * A(i, j) * x[j];
  return value;
}

double cost(const Stage& s, const StagePoint::AtStage& p) {
  const auto x = p.x.head(s.nx);
  const auto u = p.u.head(s.nu);
  double cost = s.constant + s.q.head(s.nx).dot(x) + s.r.head(s.nu).dot(u);
  cost += 0.5 * form(p.x, s.Q, p.x, s.nx, s.nx) + form(p.u, s.S, p.x, s.nu, s.nx) +
          0.5 * form(p.u, s.R, p.u, s.nu, s.nu);
  for (const RowGroup& g : s.groups) {
    if (!g.soft) continue;
    for (int row = 0; row < g.rows; ++row) {
      const double value = row_value(s, p, g, row);
      const double t = std::max({value - g.upper[row], g.lower[row] - value, 0.0});
      cost += t * (g.l1[row] + 0.5 * g.l2[row] * t);
    }
  }
  return cost;
}

}  // namespace

StageQp::StageQp(const std::vector<StageCapacity>& capacity) {
  for (std::size_t k = 0; k < capacity.size(); ++k) {
    const StageCapacity& c = capacity[k];
    const int next = k + 1 < capacity.size() ? capacity[k + 1].nx : 0;
    Stage& s = stages.emplace_back();
    s.nx = c.nx;
    s.nu = c.nu;
    s.A = MatrixXd::Zero(next, c.nx);
    s.B = MatrixXd::Zero(next, c.nu);
    s.b = VectorXd::Zero(next);
    s.Q = MatrixXd::Zero(c.nx, c.nx);
    s.S = MatrixXd::Zero(c.nu, c.nx);
    s.R = MatrixXd::Zero(c.nu, c.nu);
    s.q = VectorXd::Zero(c.nx);
    s.r = VectorXd::Zero(c.nu);
    s.x_lower = VectorXd::Constant(c.nx, -infinity);
    s.x_upper = VectorXd::Constant(c.nx, infinity);
    s.u_lower = VectorXd::Constant(c.nu, -infinity);
    s.u_upper = VectorXd::Constant(c.nu, infinity);
    for (const StageCapacity::RowGroup& g : c.groups) {
      RowGroup& group = s.groups.emplace_back();
      group.columns.reserve(g.columns);
      group.M = MatrixXd::Zero(g.rows, g.columns);
      group.lower = VectorXd::Constant(g.rows, -infinity);
      group.upper = VectorXd::Constant(g.rows, infinity);
      group.soft = g.soft;
      group.l1 = VectorXd::Zero(g.rows);
      group.l2 = VectorXd::Zero(g.rows);
    }
  }
  if (!stages.empty()) start = VectorXd::Zero(stages.front().nx);
}

StagePoint::StagePoint(const StageQp& qp) {
  for (const Stage& s : qp.stages) {
    AtStage& p = stages.emplace_back();
    p.x = p.x_bound = VectorXd::Zero(s.q.size());
    p.u = p.u_bound = VectorXd::Zero(s.r.size());
    p.costate = VectorXd::Zero(s.b.size());
    for (const RowGroup& g : s.groups) p.group.push_back(VectorXd::Zero(g.M.rows()));
  }
}

double objective(const StageQp& qp, const StagePoint& point) {
  double sum = 0.0;
  for (std::size_t k = 0; k < qp.stages.size(); ++k) sum += cost(qp.stages[k], point.stages[k]);
  return sum;
}

double StageQp::Residual::largest() const {
  return std::max({stationarity, feasibility, complementarity});
}

StageQp::Residual kkt_residual(const StageQp& qp, const StagePoint& point) {
  StageQp::Residual worst;
  const int N = qp.intervals();
  for (int k = 0; k <= N; ++k) {
    const Stage& s = qp.stages[k];
    const StagePoint::AtStage& p = point.stages[k];
    const int next = k < N ? qp.stages[k + 1].nx : 0;
    const bool given = k == 0 && qp.fixed_start;
    const auto x = p.x.head(s.nx);
    const auto u = p.u.head(s.nu);

    for (int i = 0; i < s.nx; ++i) {
      if (given) {
        raise(worst.feasibility, x[i] - qp.start[i]);
        continue;
      }
      double gradient = s.q[i] + s.Q.col(i).head(s.nx).dot(x) + s.S.col(i).head(s.nu).dot(u) +
                        p.x_bound[i] + pull_of_rows(s, p, i);
      if (k < N) gradient += s.A.col(i).head(next).dot(p.costate.head(next));
      if (k > 0) gradient -= point.stages[k - 1].costate[i];
      raise(worst.stationarity, gradient);
      add_hard(x[i], s.x_lower[i], s.x_upper[i], p.x_bound[i], worst.feasibility,
               worst.complementarity);
    }
    for (int i = 0; i < s.nu; ++i) {
      double gradient =
          s.r[i] + s.R.col(i).head(s.nu).dot(u) + p.u_bound[i] + pull_of_rows(s, p, s.nx + i);
      for (int j = 0; j < s.nx; ++j) gradient += s.S(i, j) * x[j];
      if (k < N) gradient += s.B.col(i).head(next).dot(p.costate.head(next));
      raise(worst.stationarity, gradient);
      add_hard(u[i], s.u_lower[i], s.u_upper[i], p.u_bound[i], worst.feasibility,
               worst.complementarity);
    }
    for (int i = 0; i < next; ++i) {
      double defect = s.b[i] - point.stages[k + 1].x[i];
      for (int j = 0; j < s.nx; ++j) defect += s.A(i, j) * x[j];
      for (int j = 0; j < s.nu; ++j) defect += s.B(i, j) * u[j];
      raise(worst.feasibility, defect);
    }
    for (std::size_t j = 0; j < s.groups.size(); ++j) {
      const RowGroup& g = s.groups[j];
      for (int row = 0; row < g.rows; ++row) {
        const double value = row_value(s, p, g, row);
        const double multiplier = p.group[j][row];
        if (g.soft)
          add_soft(value, g.lower[row], g.upper[row], g.l1[row], g.l2[row], multiplier,
                   worst.stationarity, worst.complementarity);
        else
          add_hard(value, g.lower[row], g.upper[row], multiplier, worst.feasibility,
                   worst.complementarity);
      }
    }
  }
  return worst;
}

}  // namespace saltus::qp
