#include "saltus/solve/least_relaxation.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "saltus/solver/infeasibility_proof.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {
namespace {

using Side = ProblemChange::Side;

// fraction of the total; smaller amounts are effects of rho
constexpr double smallest_relaxation_fraction = 1e-3;

// Values and derivatives of the problem's rows at the relaxed point.
struct RowValues {
  explicit RowValues(LeastRelaxation& relaxed)
      : program(relaxed.shooting->editable_program()),
        w(relaxed.point()),
        g(program.rows()),
        entries(program.jacobian_pattern().entries()) {
    program.constraints(w.data(), g.data());
    program.jacobian(w.data(), entries.data());
  }

  bool repeats(int a, int b) const {
    const SparsityPattern& pattern = program.jacobian_pattern();
    const int n = pattern.row_end(a) - pattern.row_begin(a);
    if (n != pattern.row_end(b) - pattern.row_begin(b) || g[a] != g[b]) return false;
    for (int i = 0; i < n; ++i)
      if (pattern.col(pattern.row_begin(a) + i) != pattern.col(pattern.row_begin(b) + i) ||
          entries[pattern.row_begin(a) + i] != entries[pattern.row_begin(b) + i])
        return false;
    return true;
  }

  ShootingProgram& program;
  VectorXd w, g;
  std::vector<double> entries;
};

}  // namespace

VectorXd LeastRelaxation::point() const {
  return result.point.w.head(shooting->program().variables());
}

Trajectory LeastRelaxation::trajectory() const { return shooting->trajectory(point()); }

HoldingForce LeastRelaxation::force_of(int k) const {
  HoldingForce force;
  const auto add = [&](double multiplier, double lower, double upper) {
    force.upper += std::max(multiplier, 0.0);
    force.lower += std::max(-multiplier, 0.0);
    force.is_value = force.is_value && lower == upper;
  };
  const auto add_row = [&](int r) {
    add(multiplier(r), program->row_lower()[r], program->row_upper()[r]);
  };
  if (group[k] >= 0) {
    for (const int r : program->rows_of(group[k])) add_row(r);
    return force;
  }
  for (const int r : asked[k].group.rows) add_row(r);
  for (const int v : asked[k].group.variables)
    add(result.point.z[v], program->lower()[v], program->upper()[v]);
  return force;
}

LeastRelaxation least_relaxation(
    const OptimalControlProblem& problem, const ShootingOptions& options, Solver& solver,
    const Trajectory* guess,
    const std::function<bool(const NegotiableConstraint&)>& is_negotiable) {
  LeastRelaxation relaxed;
  relaxed.shooting = std::make_unique<MultipleShooting>(problem, options);
  ShootingProgram& program = relaxed.shooting->editable_program();
  const VectorXd own = relaxed.shooting->initial_guess().w;
  relaxed.asked = negotiable_constraints(program, own, is_negotiable);
  std::vector<ElasticGroup> groups;
  for (const NegotiableConstraint& asked : relaxed.asked) {
    relaxed.group.push_back(asked.gives ? static_cast<int>(groups.size()) : -1);
    if (asked.gives) groups.push_back(asked.group);
  }
  relaxed.program = std::make_unique<ElasticProgram>(program, std::move(groups), own);
  const VectorXd w = guess != nullptr ? relaxed.shooting->guess_from(*guess).w : own;
  relaxed.result = solver.solve(*relaxed.program, relaxed.program->start(w), false);
  if (relaxed.ok()) relaxed.amount = relaxed.program->relaxation(relaxed.result.point.w);
  return relaxed;
}

RelaxedConstraints relaxed_constraints(LeastRelaxation& relaxed) {
  RelaxedConstraints gives;
  const RowValues at(relaxed);
  const double least = std::max(smallest_relaxation, smallest_relaxation_fraction * relaxed.amount);
  std::vector<std::pair<std::string, int>> named;  // rows of each name
  const bool is_certain = relaxed.amount > 0.0 && at.program.is_linear_quadratic() &&
                          is_proved_infeasible(at.program, at.w);
  for (int k = 0; k < static_cast<int>(relaxed.asked.size()); ++k) {
    const int group = relaxed.group[k];
    if (group < 0) continue;
    const NegotiableConstraint& asked = relaxed.asked[k];
    const std::vector<int> rows = relaxed.program->rows_of(group);
    const double unit = asked.unit, nominal = asked.group.nominal;
    for (const Side side : {Side::lower, Side::upper}) {
      const bool is_low = side == Side::lower;
      const int slack = is_low ? relaxed.program->below(group) : relaxed.program->above(group);
      const double relative = relaxed.result.point.w[slack];
      if (!(relative > least)) continue;
      const double sign = is_low ? -1.0 : 1.0;
      std::size_t held = 0;  // index of the largest multiplier
      for (std::size_t i = 1; i < rows.size(); ++i)
        if (sign * relaxed.multiplier(rows[i]) > sign * relaxed.multiplier(rows[held])) held = i;
      const std::size_t row_count = asked.group.rows.size();
      const int row = held < row_count ? asked.group.rows[held] : -1;
      const double value = row >= 0 ? at.g[row] : at.w[asked.group.variables[held - row_count]];
      const double lower = relaxed.program->row_lower()[rows[held]],
                   upper = relaxed.program->row_upper()[rows[held]];
      const double amount = relative * nominal * unit;
      if (asked.change)
        gives.changes.push_back(
            {*asked.change, asked.phase, asked.name, asked.component, side, sign * amount});
      else
        gives.can_change = false;
      if (row >= 0 && std::ranges::any_of(named, [&](const auto& other) {
            return other.first == asked.name && at.repeats(row, other.second);
          }))
        continue;
      if (row >= 0) named.emplace_back(asked.name, row);
      gives.shortages.push_back(
          {.kind = asked.kind,
           .phase = asked.has_phase ? at.program.problem().phases()[asked.phase].name : "",
           .term = asked.name,
           .component = asked.component,
           .side = side,
           .amount = amount,
           .nominal = nominal * unit,
           .time = at.program.time_of(asked.points[held], &at.w),
           .value = value * unit,
           .bound = (is_low ? lower : upper) * unit,
           .is_exact = lower == upper,
           .is_certain = is_certain});
    }
  }
  std::ranges::stable_sort(gives.shortages, std::ranges::greater{},
                           [](const Explanation::Shortage& s) { return s.amount / s.nominal; });
  return gives;
}

}  // namespace saltus
