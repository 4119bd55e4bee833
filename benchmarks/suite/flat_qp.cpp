// Dynamics k are the rows A x_k + B u_k - x_(k+1) = -b, whose multiplier is the costate. Entries
// that are zero in all stages are omitted, which solvers without stages need.
#include "benchmarks/suite/flat_qp.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus::bench {
namespace {

struct Entry {
  int row, col;
  double value;
};

void put(std::vector<Entry>& entries, int row, int col, double value) {
  if (value != 0.0) entries.push_back({row, col, value});
}

SparsityPattern pattern_of(int rows, int cols, const std::vector<Entry>& entries) {
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(entries.size());
  for (const Entry& e : entries) pairs.emplace_back(e.row, e.col);
  return SparsityPattern::from_pairs(rows, cols, std::move(pairs));
}

void add(const std::vector<Entry>& entries, const SparsityPattern& pattern, VectorXd& values) {
  for (const Entry& e : entries) values[pattern.find(e.row, e.col)] += e.value;
}

}  // namespace

std::vector<StageSizes> stage_sizes(const qp::StageQp& qp) {
  std::vector<StageSizes> sizes;
  for (const qp::Stage& s : qp.stages) {
    StageSizes& size = sizes.emplace_back(StageSizes{s.nx, s.nu, 0});
    for (const qp::RowGroup& g : s.groups) size.rows += g.rows;
  }
  return sizes;
}

qp::SparseQp flatten(const qp::StageQp& qp) {
  const int N = qp.intervals();
  std::vector<Entry> hessian, jacobian;
  std::vector<double> gradient, lower, upper, row_lower, row_upper;
  double constant = 0.0;
  int first = 0, row = 0;
  for (int k = 0; k <= N; ++k) {
    const qp::Stage& s = qp.stages[k];
    const int u = first + s.nx, next = u + s.nu;
    constant += s.constant;
    for (int i = 0; i < s.nx; ++i) {
      for (int j = 0; j <= i; ++j) put(hessian, first + i, first + j, s.Q(i, j));
      const bool fixed = k == 0 && qp.fixed_start;
      gradient.push_back(s.q[i]);
      lower.push_back(fixed ? qp.start[i] : s.x_lower[i]);
      upper.push_back(fixed ? qp.start[i] : s.x_upper[i]);
    }
    for (int i = 0; i < s.nu; ++i) {
      for (int j = 0; j < s.nx; ++j) put(hessian, u + i, first + j, s.S(i, j));
      for (int j = 0; j <= i; ++j) put(hessian, u + i, u + j, s.R(i, j));
      gradient.push_back(s.r[i]);
      lower.push_back(s.u_lower[i]);
      upper.push_back(s.u_upper[i]);
    }
    for (int i = 0; k < N && i < qp.stages[k + 1].nx; ++i, ++row) {
      for (int j = 0; j < s.nx; ++j) put(jacobian, row, first + j, s.A(i, j));
      for (int j = 0; j < s.nu; ++j) put(jacobian, row, u + j, s.B(i, j));
      put(jacobian, row, next + i, -1.0);
      row_lower.push_back(-s.b[i]);
      row_upper.push_back(-s.b[i]);
    }
    for (const qp::RowGroup& g : s.groups) {
      if (g.soft) throw DefinitionError("a program with soft rows has no flat form");
      for (int i = 0; i < g.rows; ++i, ++row) {
        for (std::size_t j = 0; j < g.columns.size(); ++j)
          put(jacobian, row, first + g.columns[j], g.M(i, j));
        row_lower.push_back(g.lower[i]);
        row_upper.push_back(g.upper[i]);
      }
    }
    first = next;
  }
  const auto vector = [](const std::vector<double>& v) {
    return VectorXd(Eigen::Map<const VectorXd>(v.data(), static_cast<Eigen::Index>(v.size())));
  };
  qp::SparseQp flat(pattern_of(first, first, hessian), pattern_of(row, first, jacobian));
  add(hessian, flat.hessian_pattern, flat.hessian);
  add(jacobian, flat.row_pattern, flat.rows);
  flat.gradient = vector(gradient);
  flat.constant = constant;
  flat.lower = vector(lower);
  flat.upper = vector(upper);
  flat.row_lower = vector(row_lower);
  flat.row_upper = vector(row_upper);
  return flat;
}

namespace {

// Start of each stage in the flat program, and the stage of a variable.
struct Layout {
  std::vector<int> variable, row, stage_of;

  explicit Layout(const std::vector<StageSizes>& sizes) : variable{0}, row{0} {
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      variable.push_back(variable.back() + sizes[k].nx + sizes[k].nu);
      row.push_back(row.back() + sizes[k].rows + (k + 1 < sizes.size() ? sizes[k + 1].nx : 0));
      stage_of.resize(variable.back(), static_cast<int>(k));
    }
  }
};

void set_sides(const qp::SparseQp& flat, int first, qp::Stage& s) {
  s.x_lower = flat.lower.segment(first, s.nx);
  s.x_upper = flat.upper.segment(first, s.nx);
  s.u_lower = flat.lower.segment(first + s.nx, s.nu);
  s.u_upper = flat.upper.segment(first + s.nx, s.nu);
  s.q = flat.gradient.segment(first, s.nx);
  s.r = flat.gradient.segment(first + s.nx, s.nu);
}

void set_costs(const qp::SparseQp& flat, const Layout& at, qp::StageQp& qp) {
  flat.hessian_pattern.for_each([&](int i, int j, int e) {
    const int k = at.stage_of[i];
    if (at.stage_of[j] != k) throw DefinitionError("a cost couples stages");
    qp::Stage& s = qp.stages[k];
    const int row = i - at.variable[k], col = j - at.variable[k];
    const double value = flat.hessian[e];
    if (row < s.nx) {
      s.Q(row, col) = s.Q(col, row) = value;
    } else if (col < s.nx) {
      s.S(row - s.nx, col) = value;
    } else {
      s.R(row - s.nx, col - s.nx) = s.R(col - s.nx, row - s.nx) = value;
    }
  });
}

void set_dynamics(const qp::SparseQp& flat, const Layout& at, int k, qp::StageQp& qp) {
  qp::Stage& s = qp.stages[k];
  for (int i = 0; i < qp.stages[k + 1].nx; ++i) {
    const int row = at.row[k] + i;
    bool has_next = false;
    for (int e = flat.row_pattern.row_begin(row); e < flat.row_pattern.row_end(row); ++e) {
      const int col = flat.row_pattern.col(e) - at.variable[k];
      if (col >= 0 && col < s.nx) {
        s.A(i, col) = flat.rows[e];
      } else if (col >= 0 && col < s.nx + s.nu) {
        s.B(i, col - s.nx) = flat.rows[e];
      } else if (col == s.nx + s.nu + i && flat.rows[e] == -1.0) {
        has_next = true;
      } else {
        throw DefinitionError("a row of the dynamics has an entry outside of its stage");
      }
    }
    if (!has_next || flat.row_lower[row] != flat.row_upper[row])
      throw DefinitionError("a row of the dynamics is not an equation of the next state");
    s.b[i] = -flat.row_lower[row];
  }
}

void set_rows(const qp::SparseQp& flat, const Layout& at, int k, int first, qp::RowGroup& g) {
  for (int i = 0; i < g.rows; ++i) {
    const int row = first + i;
    for (int e = flat.row_pattern.row_begin(row); e < flat.row_pattern.row_end(row); ++e) {
      const int col = flat.row_pattern.col(e) - at.variable[k];
      const auto place = std::find(g.columns.begin(), g.columns.end(), col);
      if (place == g.columns.end()) throw DefinitionError("a row has an entry in another stage");
      g.M(i, place - g.columns.begin()) = flat.rows[e];
    }
    g.lower[i] = flat.row_lower[row];
    g.upper[i] = flat.row_upper[row];
  }
}

}  // namespace

qp::StageQp in_stages(const qp::SparseQp& flat, const std::vector<StageSizes>& sizes) {
  const Layout at(sizes);
  if (at.variable.back() != flat.variables() || at.row.back() != flat.row_pattern.rows())
    throw DefinitionError("the stages and the program differ in the number of variables or rows");
  const int N = static_cast<int>(sizes.size()) - 1;
  std::vector<qp::StageCapacity> capacity;
  std::vector<std::vector<int>> columns;
  const auto first_row = [&](int k) { return at.row[k] + (k < N ? sizes[k + 1].nx : 0); };
  for (int k = 0; k <= N; ++k) {
    std::set<int> touched;
    for (int row = first_row(k); row < at.row[k + 1]; ++row)
      for (int e = flat.row_pattern.row_begin(row); e < flat.row_pattern.row_end(row); ++e)
        if (at.stage_of[flat.row_pattern.col(e)] == k)
          touched.insert(flat.row_pattern.col(e) - at.variable[k]);
    columns.emplace_back(touched.begin(), touched.end());
    qp::StageCapacity& c = capacity.emplace_back();
    c.nx = sizes[k].nx;
    c.nu = sizes[k].nu;
    if (sizes[k].rows > 0)
      c.groups.push_back({sizes[k].rows, static_cast<int>(columns.back().size())});
  }
  qp::StageQp qp(capacity);
  qp.start = flat.lower.head(sizes[0].nx);
  qp.fixed_start = qp.start == flat.upper.head(sizes[0].nx);
  set_costs(flat, at, qp);
  for (int k = 0; k <= N; ++k) {
    qp::Stage& s = qp.stages[k];
    set_sides(flat, at.variable[k], s);
    if (k < N) set_dynamics(flat, at, k, qp);
    if (s.groups.empty()) continue;
    s.groups[0].rows = sizes[k].rows;
    s.groups[0].columns = columns[k];
    set_rows(flat, at, k, first_row(k), s.groups[0]);
  }
  qp.stages[0].constant = flat.constant;
  return qp;
}

PrimalDualPoint flatten(const qp::StageQp& qp, const qp::StagePoint& point) {
  int variables = 0, rows = 0;
  const std::vector<StageSizes> sizes = stage_sizes(qp);
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    variables += sizes[k].nx + sizes[k].nu;
    rows += sizes[k].rows + (k > 0 ? sizes[k].nx : 0);
  }
  PrimalDualPoint flat{VectorXd::Zero(variables), VectorXd::Zero(rows), VectorXd::Zero(variables)};
  int first = 0, row = 0;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    const qp::StagePoint::AtStage& p = point.stages[k];
    const qp::Stage& s = qp.stages[k];
    flat.w.segment(first, s.nx) = p.x.head(s.nx);
    flat.w.segment(first + s.nx, s.nu) = p.u.head(s.nu);
    flat.z.segment(first, s.nx) = p.x_bound.head(s.nx);
    flat.z.segment(first + s.nx, s.nu) = p.u_bound.head(s.nu);
    if (k + 1 < sizes.size()) {
      flat.lambda.segment(row, sizes[k + 1].nx) = p.costate.head(sizes[k + 1].nx);
      row += sizes[k + 1].nx;
    }
    for (std::size_t g = 0; g < s.groups.size(); ++g) {
      flat.lambda.segment(row, s.groups[g].rows) = p.group[g].head(s.groups[g].rows);
      row += s.groups[g].rows;
    }
    first += s.nx + s.nu;
  }
  // A fixed start has no bounds: its multiplier makes the Lagrangian stationary.
  if (qp.fixed_start) {
    const qp::Stage& s = qp.stages[0];
    const qp::StagePoint::AtStage& p = point.stages[0];
    VectorXd slope = s.Q.topLeftCorner(s.nx, s.nx) * p.x.head(s.nx) + s.q.head(s.nx);
    if (s.nu > 0) slope += s.S.topLeftCorner(s.nu, s.nx).transpose() * p.u.head(s.nu);
    if (sizes.size() > 1)
      slope += s.A.topLeftCorner(sizes[1].nx, s.nx).transpose() * p.costate.head(sizes[1].nx);
    for (std::size_t g = 0; g < s.groups.size(); ++g)
      for (std::size_t j = 0; j < s.groups[g].columns.size(); ++j)
        if (s.groups[g].columns[j] < s.nx)
          slope[s.groups[g].columns[j]] += s.groups[g]
                                               .M.col(static_cast<int>(j))
                                               .head(s.groups[g].rows)
                                               .dot(p.group[g].head(s.groups[g].rows));
    flat.z.head(s.nx) = -slope;
  }
  return flat;
}

qp::StagePoint in_stages(const qp::StageQp& qp, const PrimalDualPoint& flat) {
  qp::StagePoint point(qp);
  const std::vector<StageSizes> sizes = stage_sizes(qp);
  int first = 0, row = 0;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    qp::StagePoint::AtStage& p = point.stages[k];
    const qp::Stage& s = qp.stages[k];
    p.x.head(s.nx) = flat.w.segment(first, s.nx);
    p.u.head(s.nu) = flat.w.segment(first + s.nx, s.nu);
    if (k > 0 || !qp.fixed_start) p.x_bound.head(s.nx) = flat.z.segment(first, s.nx);
    p.u_bound.head(s.nu) = flat.z.segment(first + s.nx, s.nu);
    if (k + 1 < sizes.size()) {
      p.costate.head(sizes[k + 1].nx) = flat.lambda.segment(row, sizes[k + 1].nx);
      row += sizes[k + 1].nx;
    }
    for (std::size_t g = 0; g < s.groups.size(); ++g) {
      p.group[g].head(s.groups[g].rows) = flat.lambda.segment(row, s.groups[g].rows);
      row += s.groups[g].rows;
    }
    first += s.nx + s.nu;
  }
  return point;
}

VectorXd rolled_out(const qp::StageQp& qp, const VectorXd& variables) {
  VectorXd w = variables;
  if (qp.fixed_start) w.head(qp.stages[0].nx) = qp.start.head(qp.stages[0].nx);
  int first = 0;
  for (int k = 0; k < qp.intervals(); ++k) {
    const qp::Stage& s = qp.stages[k];
    const int next = first + s.nx + s.nu, count = qp.stages[k + 1].nx;
    VectorXd following = s.b.head(count);
    if (s.nx > 0) following += s.A.topLeftCorner(count, s.nx) * w.segment(first, s.nx);
    if (s.nu > 0) following += s.B.topLeftCorner(count, s.nu) * w.segment(first + s.nx, s.nu);
    w.segment(next, count) = following;
    first = next;
  }
  return w;
}

}  // namespace saltus::bench
