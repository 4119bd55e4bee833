#include "saltus/sequences/mode_stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/ocp/windows_of.hpp"
#include "saltus/solver/quadratic_model.hpp"

namespace saltus {
namespace {

// Rounding level of zero, relative to the largest entry.
constexpr double rounding = 1e-9;
// Below this share, a mode's copy of the input does not represent the mode.
constexpr double least_share = 0.05;

MatrixXd hessian_of(const qp::Stage& s) {
  MatrixXd H(s.nx + s.nu, s.nx + s.nu);
  H << s.Q, s.S.transpose(), s.S, s.R;
  return H;
}

void set_hessian(qp::Stage& s, const MatrixXd& H) {
  s.Q = H.topLeftCorner(s.nx, s.nx);
  s.S = H.bottomLeftCorner(s.nu, s.nx);
  s.R = H.bottomRightCorner(s.nu, s.nu);
}

VectorXd gradient_of(const qp::Stage& s) {
  VectorXd g(s.nx + s.nu);
  g << s.q, s.r;
  return g;
}

bool is_convex(const MatrixXd& H) {
  if (H.size() == 0) return true;
  const VectorXd values = eigenvalues_of(H);
  return values.minCoeff() >= -rounding * std::max(values.cwiseAbs().maxCoeff(), 1e-300);
}

// Keeps the leading blocks only, so that sizes match the contents.
void trim(qp::Stage& s, int next) {
  s.A = s.A.topLeftCorner(next, s.nx).eval();
  s.B = s.B.topLeftCorner(next, s.nu).eval();
  s.b = s.b.head(next).eval();
  s.Q = s.Q.topLeftCorner(s.nx, s.nx).eval();
  s.S = s.S.topLeftCorner(s.nu, s.nx).eval();
  s.R = s.R.topLeftCorner(s.nu, s.nu).eval();
  s.q = s.q.head(s.nx).eval();
  s.r = s.r.head(s.nu).eval();
  s.x_lower = s.x_lower.head(s.nx).eval();
  s.x_upper = s.x_upper.head(s.nx).eval();
  s.u_lower = s.u_lower.head(s.nu).eval();
  s.u_upper = s.u_upper.head(s.nu).eval();
  std::vector<qp::RowGroup> groups;
  for (qp::RowGroup& g : s.groups) {
    const int columns = static_cast<int>(g.columns.size());
    if (g.rows == 0) continue;
    g.M = g.M.topLeftCorner(g.rows, columns).eval();
    for (VectorXd* v : {&g.lower, &g.upper, &g.l1, &g.l2})
      if (v->size() >= g.rows) *v = v->head(g.rows).eval();
    groups.push_back(std::move(g));
  }
  s.groups = std::move(groups);
}

// Moves rows and costs on the next state to (x, u).
void fold_end(qp::Stage& s, const qp::Stage& end) {
  MatrixXd F(s.b.size(), s.nx + s.nu);
  F << s.A, s.B;
  MatrixXd H = hessian_of(s) + F.transpose() * end.Q * F;
  const VectorXd g = gradient_of(s) + F.transpose() * (end.Q * s.b + end.q);
  s.constant += 0.5 * s.b.dot(end.Q * s.b) + end.q.dot(s.b) + end.constant;
  set_hessian(s, H);
  s.q = g.head(s.nx);
  s.r = g.tail(s.nu);
  for (qp::RowGroup group : end.groups) {
    MatrixXd on_state = MatrixXd::Zero(group.rows, s.b.size());
    for (std::size_t c = 0; c < group.columns.size(); ++c)
      on_state.col(group.columns[c]) += group.M.col(static_cast<int>(c));
    const VectorXd shift = on_state * s.b;
    group.M = on_state * F;
    group.lower -= shift;
    group.upper -= shift;
    group.columns.resize(s.nx + s.nu);
    for (int j = 0; j < s.nx + s.nu; ++j) group.columns[j] = j;
    s.groups.push_back(std::move(group));
  }
}

void scale_costs(qp::Stage& s, double by) {
  for (MatrixXd* m : {&s.Q, &s.S, &s.R}) *m *= by;
  for (VectorXd* v : {&s.q, &s.r}) *v *= by;
  s.constant *= by;
  for (qp::RowGroup& group : s.groups)
    for (VectorXd* v : {&group.l1, &group.l2}) *v *= by;
}

VectorXd largest(const VectorXd& lower, const VectorXd& upper) {
  return lower.cwiseAbs().cwiseMax(upper.cwiseAbs());
}

bool has_costs_or_rows(const qp::Stage& s) {
  return !s.groups.empty() || !s.Q.isZero(0.0) || !s.q.isZero(0.0) || s.constant != 0.0;
}

}  // namespace

ModeStages::ModeStages(const ModeGraph& graph, const IntegratorChoice& integrator, int phases)
    : integrator_(integrator) {
  nominal_ = graph.mode(0).nominal_state;
  for (int i = 0; i < graph.size() && reason_.empty(); ++i) {
    all_ |= only(i);
    const PhaseDefinition& mode = graph.mode(i);
    const auto unfit = [&](const char* why) {
      reason_ = fmt::format("mode '{}' {}", mode.name, why);
    };
    if (graph.size() > 64) reason_ = "there are more than 64 modes";
    if (mode.has_free_duration()) unfit("has a free duration");
    if (mode.sizes.nx != states()) unfit("has a different number of states from the first mode");
    if (mode.sizes.nx == states() && mode.nominal_state != nominal_)
      unfit("has different nominal states from the first mode");
    if (mode.duration != graph.mode(0).duration)
      unfit("has a different duration from the first mode");
    if (mode.input_change_weight.size() > 0) unfit("penalises changes of its inputs");
    if (!mode.integrals.empty()) unfit("limits an integral");
    if (mode.input_parametrisation == InputParametrisation::piecewise_linear_continuous)
      unfit("has inputs that are continuous across phases");
    if (!mode.switching.modes.empty()) unfit("has inner events");
    for (const PhaseDefinition::ParameterBlock& block : mode.parameters)
      if (block.unknown) unfit("has unknown parameters");
    if (mode.dynamics.reads(0)) unfit("has dynamics that depend on time");
    for (const Term& term : mode.terms)
      if (term.function.reads(0) || term.reference.varies()) unfit("has terms that depend on time");
    for_each_window(mode, [&](const Window& window, const auto&) {
      if (!window.is_whole()) unfit("has terms or bounds that depend on time");
    });
    for (int j = 0; j < graph.size(); ++j)
      if (graph.may_follow(i, j) && graph.has_event(i, j))
        unfit("has a transition with a jump or a guard");
    for (const bool given : {true, false})
      if (reason_.empty()) reason_ = transcribe(graph, i, given);
  }
  if (reason_.empty())
    reason_ =
        transcribe_end(graph, graph.start_time() + (phases - 1) * graph.mode(0).duration.lower);
}

// Converts the problem of one phase into a stage and an end. Returns the reason if that is
// impossible; `name` appears in it.
std::string ModeStages::stage(OptimalControlProblem problem, const std::string& name,
                              ModeStage& made, qp::StageFill& fill) const {
  try {
    made.shooting = std::make_shared<MultipleShooting>(
        std::move(problem), ShootingOptions{.intervals_per_phase = 1, .integrator = integrator_});
  } catch (const DefinitionError& e) {
    return fmt::format("{} is not affine: {}", name, e.what());
  }
  NonlinearProgram& nlp = made.shooting->nlp();
  if (!nlp.is_linear_quadratic()) return name + " is not affine with quadratic costs";
  QuadraticModel model(nlp);
  const VectorXd w = VectorXd::Zero(nlp.variables()), lambda = VectorXd::Zero(nlp.rows());
  model.linearise(nlp, w, lambda, Curvature::exact);
  made.qp = std::make_shared<qp::SparseQp>(model.qp());
  made.map = std::make_shared<qp::StageMap>(*made.qp, made.shooting->stages());
  fill = made.map->fill(*made.qp);
  if (fill == qp::StageFill::not_staged || made.map->stages().stages.size() != 2)
    return name + " is not a single stage";
  return {};
}

std::string ModeStages::transcribe(const ModeGraph& graph, int mode, bool given_start) {
  const std::string name = graph.mode(mode).name;
  OptimalControlProblem problem = graph.problem_of(mode, false);
  if (!given_start)
    problem.start_within(std::vector<Bounds>(states()), VectorXd(VectorXd::Zero(states())));
  ModeStage made;
  qp::StageFill fill = qp::StageFill::filled;
  const std::string why = stage(std::move(problem), fmt::format("mode '{}'", name), made, fill);
  if (!why.empty()) return why;
  // With a free start, only a row of data can be infeasible already.
  if (!given_start && fill == qp::StageFill::infeasible) impossible_ |= only(mode);
  made.stage = made.map->stages().stages[0];
  qp::Stage end = made.map->stages().stages[1];
  if (made.stage.nx != states() || end.nx != states() || end.nu != 0)
    return fmt::format("mode '{}' has soft terms that do not fit into one stage", name);
  trim(made.stage, states());
  trim(end, 0);
  made.end_lower = end.x_lower;
  made.end_upper = end.x_upper;
  if (has_costs_or_rows(end)) fold_end(made.stage, end);
  if (!is_convex(hessian_of(made.stage))) return fmt::format("mode '{}' is not convex", name);
  made.stage.x_lower = given_start ? VectorXd::Constant(states(), -infinity) : made.stage.x_lower;
  made.stage.x_upper = given_start ? VectorXd::Constant(states(), infinity) : made.stage.x_upper;
  (given_start ? given_ : free_).push_back(std::move(made));
  return {};
}

std::string ModeStages::transcribe_end(const ModeGraph& graph, double begin_of_last) {
  OptimalControlProblem problem = graph.end_problem(0, begin_of_last);
  problem.start_within(std::vector<Bounds>(states()), VectorXd(VectorXd::Zero(states())));
  ModeStage last;
  qp::StageFill fill = qp::StageFill::filled;
  const std::string why = stage(std::move(problem), "the end", last, fill);
  if (!why.empty()) return why;
  end_feasible_ = fill != qp::StageFill::infeasible;
  end_ = last.map->stages().stages[1];
  end_.constant += last.map->stages().stages[0].constant;  // for the whole program
  trim(end_, 0);
  scale_costs(end_, 1.0 / cost_unit_);
  return is_convex(end_.Q) ? "" : "the end is not convex";
}

void ModeStages::end_after(const ModeGraph& graph, double begin_of_last) {
  const std::string why = transcribe_end(graph, begin_of_last);
  if (!why.empty())
    throw DefinitionError(fmt::format("modes '{}': {} if the last phase begins at t = {:.6g} s",
                                      graph.name(), why, begin_of_last));
}

double ModeStages::largest_cost() const {
  double size = 0.0;
  const auto include = [&](const qp::Stage& s) {
    for (const MatrixXd* m : {&s.Q, &s.S, &s.R})
      if (m->size() > 0) size = std::max(size, m->cwiseAbs().maxCoeff());
    for (const VectorXd* v : {&s.q, &s.r})
      if (v->size() > 0) size = std::max(size, v->cwiseAbs().maxCoeff());
  };
  for (const ModeStage& mode : free_) include(mode.stage);
  include(end_);
  return size > 0.0 ? size * cost_unit_ : 1.0;
}

void ModeStages::divide_costs(double by) {
  for (std::vector<ModeStage>* modes : {&given_, &free_})
    for (ModeStage& mode : *modes) scale_costs(mode.stage, cost_unit_ / by);
  scale_costs(end_, cost_unit_ / by);
  cost_unit_ = by;
  sets_.clear();
}

bool ModeStages::admits(int mode, const VectorXd& x) const {
  const qp::Stage& s = given_[mode].stage;
  for (const qp::RowGroup& g : s.groups) {
    if (g.soft || !std::all_of(g.columns.begin(), g.columns.end(), [&](int j) { return j < s.nx; }))
      continue;
    for (int i = 0; i < g.rows; ++i) {
      double value = 0.0, size = 1.0;
      for (std::size_t c = 0; c < g.columns.size(); ++c) {
        value += g.M(i, static_cast<int>(c)) * x[g.columns[c]];
        size = std::max(size, std::abs(g.M(i, static_cast<int>(c)) * x[g.columns[c]]));
      }
      if (value < g.lower[i] - rounding * size || value > g.upper[i] + rounding * size)
        return false;
    }
  }
  return true;
}

SetStage& ModeStages::of(ModeSet set, bool first) {
  const auto [it, is_new] = sets_.try_emplace({set, first});
  if (!is_new) return it->second;
  if (is_single(set)) {
    const ModeStage& one = (first ? given_ : free_)[std::countr_zero(set)];
    it->second.stage = one.stage;
    it->second.end_lower = one.end_lower;
    it->second.end_upper = one.end_upper;
    it->second.hold.radius = largest(one.stage.u_lower, one.stage.u_upper);
  } else {
    it->second = hull(set, first);
  }
  return it->second;
}

SetStage ModeStages::hull(ModeSet set, bool first) const {
  const std::vector<ModeStage>& all = first ? given_ : free_;
  SetStage result;
  int nu = 0;
  for (ModeSet rest = set; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    const bool is_last = (rest & (rest - 1)) == 0;
    HullMode& mode = result.modes.emplace_back();
    mode.mode = i;
    mode.first = nu;
    mode.nu = all[i].stage.nu;
    nu += is_last ? mode.nu : states() + mode.nu + 1;
  }
  const int nx = states(), n = nx + nu, count = static_cast<int>(result.modes.size());
  qp::Stage& s = result.stage;
  s.nx = nx;
  s.nu = nu;
  s.x_lower = VectorXd::Constant(nx, infinity);
  s.x_upper = VectorXd::Constant(nx, -infinity);
  result.end_lower = s.x_lower;
  result.end_upper = s.x_upper;
  s.u_lower = VectorXd::Constant(nu, -infinity);
  s.u_upper = VectorXd::Constant(nu, infinity);
  result.hold.radius =
      VectorXd::Ones(nu);  // bounds of shares; copies lie between zero and the bounds of the mode
  for (std::size_t m = 0; m < result.modes.size(); ++m) {
    const HullMode& mode = result.modes[m];
    const qp::Stage& one = free_[mode.mode].stage;
    const bool is_last = m + 1 == result.modes.size();
    if (!is_last)
      result.hold.radius.segment(mode.first, nx) =
          first ? VectorXd::Constant(nx, infinity) : largest(one.x_lower, one.x_upper);
    result.hold.radius.segment(mode.first + (is_last ? 0 : nx), mode.nu) =
        largest(one.u_lower, one.u_upper);
  }

  // (x_i, u_i, mu_i) = T_i (x, w) + (0, 0, t_i).
  std::vector<MatrixXd> maps;
  for (int m = 0; m < count; ++m) {
    const HullMode& mode = result.modes[m];
    MatrixXd& T = maps.emplace_back(MatrixXd::Zero(nx + mode.nu + 1, n));
    if (m + 1 < count) {
      T.middleCols(nx + mode.first, nx + mode.nu + 1).setIdentity();
      s.u_lower[mode.first + nx + mode.nu] = 0.0;
      continue;
    }
    T.topLeftCorner(nx, nx).setIdentity();
    T.block(nx, nx + mode.first, mode.nu, mode.nu).setIdentity();
    for (int o = 0; o < m; ++o) {
      const HullMode& other = result.modes[o];
      T.block(0, nx + other.first, nx, nx) -= MatrixXd::Identity(nx, nx);
      T(nx + mode.nu, nx + other.first + nx + other.nu) = -1.0;
    }
  }

  bool same_hessian = true;
  const MatrixXd H0 = hessian_of(all[result.modes[0].mode].stage);
  for (const HullMode& mode : result.modes) {
    const MatrixXd H = hessian_of(all[mode.mode].stage);
    same_hessian = same_hessian && H.rows() == H0.rows() &&
                   (H - H0).cwiseAbs().maxCoeff() <= rounding * H0.cwiseAbs().maxCoeff();
  }
  MatrixXd H = MatrixXd::Zero(n, n), F = MatrixXd::Zero(nx, n);
  VectorXd g = VectorXd::Zero(n);
  s.b = VectorXd::Zero(nx);
  if (same_hessian) {  // in x and the sum of all inputs
    MatrixXd sum = MatrixXd::Zero(H0.rows(), n);
    sum.topLeftCorner(nx, nx).setIdentity();
    for (int m = 0; m < count; ++m)
      sum.bottomRows(H0.rows() - nx) += maps[m].middleRows(nx, H0.rows() - nx);
    H = sum.transpose() * H0 * sum;
  }
  for (int m = 0; m < count; ++m) {
    HullMode& mode = result.modes[m];
    const qp::Stage& one = all[mode.mode].stage;
    const int size = nx + mode.nu;
    const MatrixXd T = maps[m].topRows(size);
    const Eigen::RowVectorXd share = maps[m].row(size);
    const double rest = m + 1 < count ? 0.0 : 1.0;  // mu_i = share (x, w) + rest
    if (!same_hessian) H += T.transpose() * hessian_of(one) * T;
    g += T.transpose() * gradient_of(one) + one.constant * share.transpose();
    s.constant += one.constant * rest;
    MatrixXd flow(nx, size);
    flow << one.A, one.B;
    F += flow * T + one.b * share;
    s.b += one.b * rest;
    s.x_lower = s.x_lower.cwiseMin(one.x_lower);
    s.x_upper = s.x_upper.cwiseMax(one.x_upper);
    result.end_lower = result.end_lower.cwiseMin(all[mode.mode].end_lower);
    result.end_upper = result.end_upper.cwiseMax(all[mode.mode].end_upper);

    std::vector<Eigen::RowVectorXd> rows;
    std::vector<double> lower, upper;
    const auto add = [&](int group, int row, const Eigen::RowVectorXd& on_copy, double l,
                         double h) {
      const Eigen::RowVectorXd value = on_copy * T;
      const auto side = [&](double limit, bool is_upper, bool equality) {
        rows.emplace_back(value - limit * share);
        lower.push_back(is_upper && !equality ? -infinity : limit * rest);
        upper.push_back(is_upper ? limit * rest : infinity);
        mode.rows.push_back({group, row, is_upper, equality});
      };
      if (l == h) return side(h, true, true);
      if (h < infinity) side(h, true, false);
      if (l > -infinity) side(l, false, false);
    };
    for (std::size_t k = 0; k < one.groups.size(); ++k) {
      const qp::RowGroup& group = one.groups[k];
      if (group.soft) continue;  // a penalty is never negative
      for (int i = 0; i < group.rows; ++i) {
        Eigen::RowVectorXd on_copy = Eigen::RowVectorXd::Zero(size);
        for (std::size_t c = 0; c < group.columns.size(); ++c)
          on_copy[group.columns[c]] += group.M(i, static_cast<int>(c));
        add(static_cast<int>(k), i, on_copy, group.lower[i], group.upper[i]);
      }
    }
    for (int j = 0; j < size; ++j)
      add(-1, j, Eigen::RowVectorXd::Unit(size, j), j < nx ? one.x_lower[j] : one.u_lower[j - nx],
          j < nx ? one.x_upper[j] : one.u_upper[j - nx]);
    if (m + 1 == count) {
      rows.emplace_back(share);
      lower.push_back(-rest);
      upper.push_back(infinity);
    }
    qp::RowGroup& group = s.groups.emplace_back();
    group.rows = static_cast<int>(rows.size());
    MatrixXd M(group.rows, n);
    for (int i = 0; i < group.rows; ++i) M.row(i) = rows[i];
    for (int j = 0; j < n; ++j)
      if (!M.col(j).isZero(0.0)) group.columns.push_back(j);
    group.M.resize(group.rows, static_cast<int>(group.columns.size()));
    for (std::size_t c = 0; c < group.columns.size(); ++c)
      group.M.col(static_cast<int>(c)) = M.col(group.columns[c]);
    group.lower = Eigen::Map<const VectorXd>(lower.data(), group.rows);
    group.upper = Eigen::Map<const VectorXd>(upper.data(), group.rows);
  }
  set_hessian(s, H);
  s.q = g.head(nx);
  s.r = g.tail(nu);
  s.A = F.leftCols(nx);
  s.B = F.rightCols(nu);
  return result;
}

VectorXd ModeStages::input(int mode, const VectorRef& x, const VectorRef& u, const VectorRef& end) {
  const ModeStage& one = free_[mode];
  qp::StagePoint point(one.map->stages());
  point.stages[0].x.head(x.size()) = x;
  point.stages[0].u.head(u.size()) = u;
  point.stages[1].x.head(end.size()) = end;
  PrimalDualPoint program;
  one.map->convert(*one.qp, point, program);
  return one.shooting->trajectory(program.w).pieces().front().coefficients;
}

qp::StageQp ModeStages::capacity(int phases, bool fixed_start) {
  qp::StageCapacity most{.nx = states(), .nu = 0, .groups = {}};
  const auto include = [&](const qp::Stage& s) {
    most.nu = std::max(most.nu, s.nu);
    most.groups.resize(std::max(most.groups.size(), s.groups.size()));
    for (std::size_t g = 0; g < s.groups.size(); ++g) {
      most.groups[g].rows = std::max(most.groups[g].rows, s.groups[g].rows);
      most.groups[g].columns =
          std::max(most.groups[g].columns, static_cast<int>(s.groups[g].columns.size()));
      most.groups[g].soft = most.groups[g].soft || s.groups[g].soft;
    }
  };
  for (std::size_t i = 0; i < free_.size(); ++i) include(free_[i].stage), include(given_[i].stage);
  const SetStage& everything = of(all_, false);
  include(everything.stage);
  // Any of the modes may be the last one, whose rows have the most columns.
  for (qp::StageCapacity::RowGroup& group : most.groups) {
    for (const qp::RowGroup& g : everything.stage.groups)
      group.rows = std::max(group.rows, g.rows + 1);
    group.columns = most.nx + most.nu;
  }
  std::vector<qp::StageCapacity> stages(phases, most);
  qp::StageCapacity& last =
      stages.emplace_back(qp::StageCapacity{.nx = states(), .nu = 0, .groups = {}});
  for (const qp::RowGroup& g : end_.groups)
    last.groups.push_back({g.rows, static_cast<int>(g.columns.size()), g.soft});
  qp::StageQp qp(stages);
  qp.fixed_start = fixed_start;
  return qp;
}

void restrict_point(const SetStage& from, const qp::StagePoint::AtStage& point, const SetStage& to,
                    ModeSet to_set, qp::StagePoint::AtStage& out) {
  const int nx = to.stage.nx;
  out.x.head(nx) = point.x.head(nx);
  out.costate = point.costate;
  out.x_bound.head(nx) = point.x_bound.head(nx);
  out.u.setZero();
  out.u_bound.setZero();
  for (VectorXd& group : out.group) group.setZero();
  if (from.modes.empty() || (!to.modes.empty() && from.modes.size() == to.modes.size())) {
    out = point;
    return;
  }
  // Copies and share of each mode of `from`.
  const auto copy_of = [&](std::size_t m, VectorXd& x, VectorXd& u, double& share) {
    const HullMode& mode = from.modes[m];
    if (m + 1 < from.modes.size()) {
      x = point.u.segment(mode.first, nx);
      u = point.u.segment(mode.first + nx, mode.nu);
      share = point.u[mode.first + nx + mode.nu];
      return;
    }
    x = point.x.head(nx);
    u = point.u.segment(mode.first, mode.nu);
    share = 1.0;
    for (std::size_t o = 0; o < m; ++o) {
      x -= point.u.segment(from.modes[o].first, nx);
      share -= point.u[from.modes[o].first + nx + from.modes[o].nu];
    }
  };
  VectorXd x, u;
  double share = 0.0;
  for (std::size_t m = 0; m < from.modes.size(); ++m) {
    const HullMode& mode = from.modes[m];
    if ((to_set & only(mode.mode)) == 0) continue;
    copy_of(m, x, u, share);
    if (to.modes.empty()) {
      out.u.head(mode.nu) = u / std::max(share, least_share);
      for (std::size_t r = 0; r < mode.rows.size(); ++r) {
        const HullRow& row = mode.rows[r];
        const double lambda = point.group[m][static_cast<int>(r)];
        if (row.group >= 0)
          out.group[row.group][row.row] += lambda;
        else
          (row.row < nx ? out.x_bound[row.row] : out.u_bound[row.row - nx]) += lambda;
      }
      return;
    }
    for (std::size_t k = 0; k < to.modes.size(); ++k) {
      const HullMode& target = to.modes[k];
      if (target.mode != mode.mode) continue;
      const int rows = static_cast<int>(mode.rows.size());
      out.group[k].head(rows) = point.group[m].head(rows);
      if (k + 1 == to.modes.size()) {
        out.u.segment(target.first, mode.nu) = u;
      } else {
        out.u.segment(target.first, nx) = x;
        out.u.segment(target.first + nx, mode.nu) = u;
        out.u[target.first + nx + mode.nu] = share;
      }
    }
  }
}

}  // namespace saltus
