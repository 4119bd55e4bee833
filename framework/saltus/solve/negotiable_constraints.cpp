#include "saltus/solve/negotiable_constraints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/transcription/quantities.hpp"

namespace saltus {
namespace {

using Kind = ProblemChange::Kind;
using shooting::GridPoint;

bool has_side(double lower, double upper) { return lower > -infinity || upper < infinity; }

class Collector {
 public:
  explicit Collector(const ShootingProgram& program) : program_(program) {}

  std::vector<NegotiableConstraint> run() {
    take_terms();
    take_states();
    take_limits();
    take_closing();
    take_total_time();
    std::erase_if(all_, [](const NegotiableConstraint& a) { return a.points.empty(); });
    return std::move(all_);
  }

 private:
  int end_of(int phase) const { return program_.grid().intervals(phase); }
  GridPoint end() const {
    const int last = program_.grid().phases() - 1;
    return {.phase = last, .node = end_of(last)};
  }

  NegotiableConstraint& begin(const char* kind, std::optional<Kind> change, int phase,
                              const std::string& name, int component) {
    NegotiableConstraint& asked = all_.emplace_back();
    asked.kind = kind;
    asked.change = change;
    asked.phase = phase;
    asked.name = name;
    asked.component = component;
    asked.group.name = fmt::format("{} '{}', row {}", kind, name, component);
    return asked;
  }
  void take_row(NegotiableConstraint& asked, int row, const GridPoint& point) {
    if (!has_side(program_.row_lower()[row], program_.row_upper()[row])) return;
    asked.group.rows.push_back(row);
    asked.points.push_back(point);
  }

  void take_terms() {
    for (int j = 0; j < program_.grid().phases(); ++j) {
      const PhaseDefinition& phase = program_.problem().phases()[j];
      for (std::size_t t = 0; t < phase.terms.size(); ++t) {
        const Term& term = phase.terms[t];
        if (term.kind != Term::Kind::constraint || term.soft) continue;
        for (int i = 0; i < term.function.outputs(); ++i) {
          NegotiableConstraint& asked = begin("term", Kind::term, j, term.name, i);
          for (const shooting::RowInstance& instance : program_.row_instances())
            if (instance.phase == j && instance.term == static_cast<int>(t))
              take_row(asked, instance.first_row + i, instance.block.point);
        }
      }
    }
  }

  void take_states() {
    for (int j = 0; j < program_.grid().phases(); ++j) {
      const PhaseDefinition& phase = program_.problem().phases()[j];
      for (int i = 0; i < phase.sizes.nx; ++i) {
        NegotiableConstraint& asked = begin("state", Kind::state, j, fmt::format("state {}", i), i);
        asked.unit = phase.nominal_state[i];
        for (int node = 0; node <= end_of(j); ++node) {
          const int v = program_.layout().state(j, node) + i;
          if (!has_side(program_.lower()[v], program_.upper()[v])) continue;
          asked.group.variables.push_back(v);
          asked.points.push_back({.phase = j, .node = node});
        }
      }
    }
  }

  void take_limits() {
    const OptimalControlProblem& problem = program_.problem();
    for (const shooting::LimitInstance& instance : program_.limit_instances()) {
      if (program_.limits_of(instance).soft) continue;
      const bool is_link = instance.link >= 0;
      for (int i = 0; i < instance.count; ++i) {
        NegotiableConstraint& asked =
            is_link
                ? begin("link", Kind::link, instance.phase, problem.links()[instance.link].name, i)
                : begin("integral", Kind::integral, instance.phase,
                        problem.phases()[instance.phase].integrals[instance.integral].name, i);
        asked.has_phase = !is_link;
        take_row(asked, instance.first_row + i, instance.point);
      }
    }
  }

  void take_closing() {
    const int row = program_.closing_row();
    if (row < 0) return;
    const PhaseDefinition& first = program_.problem().phases().front();
    for (int i = 0; i < first.sizes.nx; ++i) {
      NegotiableConstraint& asked = begin("closing", {}, 0, "closing", i);
      asked.has_phase = false;
      asked.unit = first.nominal_state[i];
      take_row(asked, row + i, end());
    }
  }

  void take_total_time() {
    const int row = program_.total_time_row();
    if (row < 0) return;
    NegotiableConstraint& asked = begin("total time", Kind::total_time, 0, "total time", 0);
    asked.has_phase = false;
    take_row(asked, row, end());
  }

  const ShootingProgram& program_;
  std::vector<NegotiableConstraint> all_;
};

// Sizes of the variables: nominal ones or, if none are declared and the point and bounds show that
// all are small, those of the point and bounds. A zero among well-scaled values gives no size.
VectorXd sizes_of(ShootingProgram& program, const VectorXd& w) {
  constexpr double small = 1e-2;
  VectorXd sizes = VectorXd::Ones(program.variables());
  const Quantities undeclared = undeclared_quantities(program);
  ProgramSize known(program, undeclared);
  if (!known.look_at(w)) return sizes;
  const VectorXd told = known.to_one().variables.cwiseInverse();
  for (const std::vector<int>& quantity : undeclared)
    for (const int v : quantity)
      if (told[v] >= small) return sizes;
  return (told.array() < small).select(told, sizes);
}

// Largest derivative of each row at w, for variables of these sizes.
VectorXd steepest_of(ShootingProgram& program, const VectorXd& w, const VectorXd& sizes) {
  VectorXd steepest = VectorXd::Zero(program.rows());
  std::vector<double> entries(program.jacobian_pattern().entries());
  if (program.jacobian(w.data(), entries.data()))
    program.jacobian_pattern().for_each([&](int r, int c, int e) {
      if (std::isfinite(entries[e]))
        steepest[r] = std::max(steepest[r], sizes[c] * std::abs(entries[e]));
    });
  return steepest;
}

}  // namespace

std::vector<NegotiableConstraint> negotiable_constraints(
    ShootingProgram& program, const VectorXd& w,
    const std::function<bool(const NegotiableConstraint&)>& is_negotiable) {
  std::vector<NegotiableConstraint> all = Collector(program).run();
  const VectorXd sizes = sizes_of(program, w), steepest = steepest_of(program, w, sizes);
  for (NegotiableConstraint& asked : all) {
    double nominal = 0.0;
    for (const int r : asked.group.rows) nominal = std::max(nominal, steepest[r]);
    for (const int v : asked.group.variables) nominal = std::max(nominal, sizes[v]);
    asked.group.nominal = nominal > 0.0 ? nominal : 1.0;
    asked.gives = !is_negotiable || is_negotiable(asked);
  }
  return all;
}

}  // namespace saltus
