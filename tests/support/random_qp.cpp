#include "tests/support/random_qp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace saltus::testing {
namespace {

// Draws the optimum z first, and a second point z + d that is strictly inside every inequality.
// Equality rows are made orthogonal to d. An active inequality is active at z on the side from
// which d leads inside. The linear cost follows from the multipliers, which are drawn too.
class Builder {
 public:
  Builder(std::uint64_t seed, const RandomQpOptions& options) : o_(options), random_(seed) {
    out_.degenerate = random_.chance(o_.degenerate);
    out_.rank_deficient = random_.chance(o_.rank_deficient);
    out_.semidefinite = random_.chance(o_.semidefinite);
    out_.tight = random_.chance(o_.tight);
    out_.large_multipliers = random_.chance(o_.large_multipliers);
  }

  RandomQp build() {
    choose_sizes();
    fill_costs_and_dynamics();
    choose_points();
    for (int k = 0; k <= N_; ++k) {
      choose_bounds(k);
      choose_groups(k);
    }
    if (out_.rank_deficient) add_dependent_rows();
    set_gradients();
    out_.cost = objective(qp_, out_.optimum);
    return std::move(out_);
  }

 private:
  void choose_sizes() {
    N_ = random_.integer(o_.min_intervals, o_.max_intervals);
    const bool varying = random_.chance(o_.varying_sizes);
    const int nx = random_.integer(1, o_.max_states), nu = random_.integer(1, o_.max_inputs);
    std::vector<qp::StageCapacity> capacity;
    for (int k = 0; k <= N_; ++k) {
      qp::StageCapacity c{nx, nu, {}};
      if (varying) {
        c.nx = random_.integer(1, o_.max_states);
        c.nu = random_.integer(0, o_.max_inputs);
      }
      if (k == N_ && random_.chance(0.7)) c.nu = 0;
      capacity.push_back(c);
    }
    qp_ = qp::StageQp(capacity);
    qp_.fixed_start = !random_.chance(o_.free_start);
    with_equalities_ = random_.chance(o_.equality_rows);
    with_soft_rows_ = random_.chance(o_.soft_rows);
  }

  void fill_costs_and_dynamics() {
    for (int k = 0; k <= N_; ++k) {
      qp::Stage& s = stage(k);
      const int n = s.nx + s.nu;
      const int rank = out_.semidefinite ? std::max(1, n / 3) : n;
      const MatrixXd root = random_.matrix(rank, n);
      MatrixXd H = root.transpose() * root / n;
      const double input_cost = random_.log_uniform(1e-3, 1.0);
      H.bottomRightCorner(s.nu, s.nu).diagonal().array() += input_cost;
      // A row or a cost must hold a free initial state; otherwise the optimum is not attained.
      if (k == 0 && !qp_.fixed_start) H.topLeftCorner(s.nx, s.nx).diagonal().array() += 0.1;
      s.Q = H.topLeftCorner(s.nx, s.nx);
      s.S = H.bottomLeftCorner(s.nu, s.nx);
      s.R = H.bottomRightCorner(s.nu, s.nu);
      s.constant = random_.uniform(-1.0, 1.0);
      // The scale makes a state grow by a factor of about 1 over a stage for all sizes.
      s.A = random_.matrix(s.b.size(), s.nx) * std::sqrt(3.0 / s.nx);
      s.B = random_.matrix(s.b.size(), s.nu);
    }
  }

  void choose_points() {
    qp::StagePoint& z = out_.optimum = qp::StagePoint(qp_);
    d_ = qp::StagePoint(qp_);
    const double length = out_.tight ? random_.log_uniform(1e-3, 1.0) : 1.0;
    for (int k = 0; k <= N_; ++k) {
      qp::Stage& s = stage(k);
      z.stages[k].x = random_.vector(s.nx);
      z.stages[k].u = random_.vector(s.nu);
      z.stages[k].costate = random_.vector(s.b.size());
      d_.stages[k].u = length * random_.vector(s.nu);
      if (k == 0 && !qp_.fixed_start) d_.stages[0].x = length * random_.vector(s.nx);
      if (k > 0) {
        const qp::Stage& p = stage(k - 1);
        stage(k - 1).b = z.stages[k].x - p.A * z.stages[k - 1].x - p.B * z.stages[k - 1].u;
        d_.stages[k].x = p.A * d_.stages[k - 1].x + p.B * d_.stages[k - 1].u;
      }
    }
    if (qp_.fixed_start) qp_.start = z.stages[0].x;
  }

  double draw_multiplier() {
    if (out_.degenerate && random_.chance(0.3)) return 0.0;
    return random_.log_uniform(
        1e-3, out_.large_multipliers ? o_.largest_multiplier : o_.ordinary_multiplier);
  }
  double draw_gap() {
    return out_.tight ? random_.log_uniform(o_.smallest_margin, 1.0) : random_.uniform(0.1, 2.0);
  }
  void note_margin(double margin) { out_.margin = std::min(out_.margin, margin); }

  // Draws the sides of a quantity that is `value` at the optimum and changes by `step` to the
  // interior point.
  void choose_hard_sides(double value, double step, double active, double& lower, double& upper,
                         double& multiplier) {
    const double low = std::min(value, value + step), high = std::max(value, value + step);
    const bool two_sided = random_.chance(0.6), upper_first = random_.chance(0.5);
    multiplier = 0.0;
    if (two_sided || upper_first) upper = high + draw_gap();
    if (two_sided || !upper_first) lower = low - draw_gap();
    if (random_.chance(active) && std::abs(step) >= o_.smallest_margin) {
      multiplier = draw_multiplier() * (step < 0.0 ? 1.0 : -1.0);
      (step < 0.0 ? upper : lower) = value;
    }
    if (upper < infinity) note_margin(upper - value - step);
    if (lower > -infinity) note_margin(value + step - lower);
  }

  void choose_bounds(int k) {
    qp::Stage& s = stage(k);
    qp::StagePoint::AtStage& z = out_.optimum.stages[k];
    const qp::StagePoint::AtStage& d = d_.stages[k];
    const double bounded_inputs = random_.uniform(0.0, 1.0);
    const double bounded_states = 0.4 * random_.uniform(0.0, 1.0);
    for (int i = 0; i < s.nu; ++i)
      if (random_.chance(bounded_inputs))
        choose_hard_sides(z.u[i], d.u[i], 0.4, s.u_lower[i], s.u_upper[i], z.u_bound[i]);
    if (k == 0 && qp_.fixed_start) return;
    for (int i = 0; i < s.nx; ++i)
      if (random_.chance(bounded_states))
        choose_hard_sides(z.x[i], d.x[i], 0.3, s.x_lower[i], s.x_upper[i], z.x_bound[i]);
  }

  std::vector<int> all_columns(const qp::Stage& s) {
    std::vector<int> columns;
    for (int i = 0; i < s.nx + s.nu; ++i) columns.push_back(i);
    return columns;
  }
  std::vector<int> some_columns(const qp::Stage& s) {
    const int kind = random_.integer(0, 2);
    std::vector<int> columns;
    for (int i = 0; i < s.nx + s.nu; ++i)
      if (kind == 0 || (kind == 1 && i >= s.nx) || (kind == 2 && i < s.nx && i < 3))
        columns.push_back(i);
    return columns;
  }

  double entry(const qp::Stage& s, const qp::StagePoint::AtStage& p, int column) const {
    return column < s.nx ? p.x[column] : p.u[column - s.nx];
  }
  double product(int k, const qp::RowGroup& g, int row, const qp::StagePoint& point) {
    double sum = 0.0;
    for (std::size_t j = 0; j < g.columns.size(); ++j)
      sum += g.M(row, j) * entry(stage(k), point.stages[k], g.columns[j]);
    return sum;
  }

  // Reserves one more row than the `rows` that are drawn.
  std::pair<qp::RowGroup&, VectorXd&> add_group(int k, std::vector<int> columns, int rows,
                                                bool soft) {
    qp::RowGroup& g = stage(k).groups.emplace_back();
    g.columns = std::move(columns);
    g.rows = rows;
    g.soft = soft;
    g.M = random_.matrix(rows + 1, static_cast<int>(g.columns.size()));
    g.lower = VectorXd::Constant(rows + 1, -infinity);
    g.upper = VectorXd::Constant(rows + 1, infinity);
    g.l1 = g.l2 = VectorXd::Zero(rows + 1);
    VectorXd& multipliers = out_.optimum.stages[k].group.emplace_back(VectorXd::Zero(rows + 1));
    return {g, multipliers};
  }

  void choose_groups(int k) {
    qp::Stage& s = stage(k);
    for (int count = random_.integer(0, 2); count > 0; --count) add_inequalities(k);
    if (with_soft_rows_ && random_.chance(0.7)) add_soft_rows(k);
    // Fewer rows than inputs, so that rows are independent and d exists.
    if (with_equalities_ && s.nu >= 2) add_equalities(k, random_.integer(0, s.nu - 1));
  }

  void add_inequalities(int k) {
    const std::vector<int> columns = some_columns(stage(k));
    if (columns.empty()) return;
    const auto& [g, multipliers] = add_group(k, columns, random_.integer(1, 4), false);
    const int rows = g.rows;
    for (int i = 0; i < rows; ++i)
      choose_hard_sides(product(k, g, i, out_.optimum), product(k, g, i, d_), 0.3, g.lower[i],
                        g.upper[i], multipliers[i]);
    // Adds the same row again at twice its size. Both are active, so multipliers are not unique.
    if (!out_.degenerate || multipliers[0] == 0.0) return;
    g.M.row(rows) = 2.0 * g.M.row(0);
    g.lower[rows] = 2.0 * g.lower[0];
    g.upper[rows] = 2.0 * g.upper[0];
    multipliers[rows] = random_.chance(0.5) ? 0.5 * multipliers[0] : 0.0;
    ++g.rows;
  }

  void add_equalities(int k, int rows) {
    if (rows == 0) return;
    const auto& [g, multipliers] = add_group(k, all_columns(stage(k)), rows, false);
    VectorXd step(g.columns.size());
    for (std::size_t j = 0; j < g.columns.size(); ++j)
      step[j] = entry(stage(k), d_.stages[k], g.columns[j]);
    for (int i = 0; i < rows; ++i) {
      g.M.row(i) -= (g.M.row(i).dot(step) / step.squaredNorm()) * step.transpose();
      g.lower[i] = g.upper[i] = product(k, g, i, out_.optimum);
      multipliers[i] = random_.uniform(-1.0, 1.0);
    }
  }

  void add_soft_rows(int k) {
    const std::vector<int> columns = some_columns(stage(k));
    if (columns.empty()) return;
    const auto& [g, multipliers] = add_group(k, columns, random_.integer(1, 3), true);
    for (int i = 0; i < g.rows; ++i) {
      const int penalty = random_.integer(0, 2);  // linear, quadratic, both
      if (penalty != 1) g.l1[i] = random_.log_uniform(1e-2, 1e2);
      if (penalty != 0) g.l2[i] = random_.log_uniform(1e-2, 1e3);
      const double value = product(k, g, i, out_.optimum);
      const double sign = random_.chance(0.5) ? 1.0 : -1.0;
      double& side = sign > 0.0 ? g.upper[i] : g.lower[i];
      double& other = sign > 0.0 ? g.lower[i] : g.upper[i];
      switch (random_.integer(0, 2)) {
        case 0: {  // missed
          const double t = random_.uniform(0.01, 1.0);
          side = value - sign * t;
          multipliers[i] = sign * (g.l1[i] + g.l2[i] * t);
          break;
        }
        case 1:  // reached
          side = value;
          multipliers[i] = sign * random_.uniform(0.1, 0.9) * g.l1[i];
          break;
        default:
          side = value + sign * random_.uniform(0.1, 2.0);
      }
      if (random_.chance(0.5)) other = side - sign * random_.uniform(2.0, 3.0);
    }
  }

  void add_dependent_rows() {
    // Within a stage: the sum of two equality rows, or twice a single row.
    for (int k = 0; k <= N_; ++k) {
      for (std::size_t j = 0; j < stage(k).groups.size(); ++j) {
        qp::RowGroup& g = stage(k).groups[j];
        if (g.soft || g.rows == 0 || g.lower[0] != g.upper[0] || !random_.chance(0.5)) continue;
        const int last = g.rows - 1;
        g.M.row(g.rows) = g.M.row(0) + g.M.row(last);
        g.lower[g.rows] = g.upper[g.rows] = g.lower[0] + g.lower[last];
        ++g.rows;
      }
    }
    // Across two stages: a row of stage k on (x, u) fixes c'x of the next stage, and a row there
    // repeats it.
    const int k = random_.integer(0, N_ - 1);
    const VectorXd& step = d_.stages[k + 1].x;
    VectorXd c = random_.vector(stage(k + 1).nx);
    if (step.squaredNorm() > 0.0) c -= (c.dot(step) / step.squaredNorm()) * step;
    VectorXd row(stage(k).nx + stage(k).nu);
    row << stage(k).A.transpose() * c, stage(k).B.transpose() * c;
    if (c.norm() < 0.1 || row.norm() < 0.1) return;  // no such row is compatible with d
    const auto& [first, y] = add_group(k, all_columns(stage(k)), 1, false);
    first.M.row(0) = row.transpose();
    first.lower[0] = first.upper[0] = product(k, first, 0, out_.optimum);
    y[0] = random_.uniform(-1.0, 1.0);
    const auto& [second, y2] = add_group(k + 1, state_columns(stage(k + 1)), 1, false);
    second.M.row(0) = c.transpose();
    second.lower[0] = second.upper[0] = c.dot(out_.optimum.stages[k + 1].x);
    y2[0] = random_.uniform(-1.0, 1.0);
  }

  static std::vector<int> state_columns(const qp::Stage& s) {
    std::vector<int> columns;
    for (int i = 0; i < s.nx; ++i) columns.push_back(i);
    return columns;
  }

  void set_gradients() {
    const qp::StagePoint& z = out_.optimum;
    for (int k = 0; k <= N_; ++k) {
      qp::Stage& s = stage(k);
      const qp::StagePoint::AtStage& p = z.stages[k];
      VectorXd pull = VectorXd::Zero(s.nx + s.nu);
      for (std::size_t j = 0; j < s.groups.size(); ++j) {
        const qp::RowGroup& g = s.groups[j];
        for (int i = 0; i < g.rows; ++i)
          for (std::size_t c = 0; c < g.columns.size(); ++c)
            pull[g.columns[c]] += g.M(i, c) * p.group[j][i];
      }
      s.q = -(s.Q * p.x + s.S.transpose() * p.u + s.A.transpose() * p.costate + p.x_bound +
              pull.head(s.nx));
      if (k > 0) s.q += z.stages[k - 1].costate;
      if (k == 0 && qp_.fixed_start) {
        // Any linear cost is valid, because the multiplier of the start balances it.
        const VectorXd q = random_.vector(s.nx);
        out_.optimum.stages[0].x_bound = s.q - q;
        s.q = q;
      }
      s.r = -(s.R * p.u + s.S * p.x + s.B.transpose() * p.costate + p.u_bound + pull.tail(s.nu));
    }
  }

  qp::Stage& stage(int k) { return qp_.stages[k]; }

  const RandomQpOptions& o_;
  Random random_;
  RandomQp out_;
  qp::StageQp& qp_ = out_.qp;
  qp::StagePoint d_;
  int N_ = 0;
  bool with_equalities_ = false, with_soft_rows_ = false;
};

}  // namespace

std::string RandomQp::describe() const {
  std::string text = fmt::format("{} intervals, margin {:.1e}", qp.intervals(), margin);
  if (!qp.fixed_start) text += ", free start";
  if (degenerate) text += ", degenerate";
  if (rank_deficient) text += ", rank-deficient";
  if (semidefinite) text += ", semidefinite";
  if (tight) text += ", tight";
  if (large_multipliers) text += ", large multipliers";
  return text;
}

RandomQp random_qp(std::uint64_t seed, const RandomQpOptions& options) {
  return Builder(seed, options).build();
}

double multiplier_scale(const qp::StagePoint& point) {
  double scale = 1.0;
  const auto take = [&](const VectorXd& v) {
    if (v.size() > 0) scale = std::max(scale, v.lpNorm<Eigen::Infinity>());
  };
  for (const qp::StagePoint::AtStage& z : point.stages) {
    take(z.costate);
    take(z.x_bound);
    take(z.u_bound);
    for (const VectorXd& g : z.group) take(g);
  }
  return scale;
}

}  // namespace saltus::testing
