#include "saltus/solve/sensitivities.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/transcription/quantities.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {
namespace {

using Kind = ProblemChange::Kind;
using Side = ProblemChange::Side;

constexpr double worth_noting = 1e-9;       // multipliers in nominal values are of order one
constexpr double difference_step = 1e-4;    // central differences of smooth functions: error 1e-8
constexpr double size_of_zero_data = 1e-2;  // relative to the nominal value

class Sensitivities {
 public:
  Sensitivities(const OptimalControlProblem& problem, LeastRelaxation& relaxed,
                const std::function<bool()>& is_late)
      : problem_(problem), relaxed_(relaxed), is_late_(is_late) {}

  std::vector<Candidate> run() {
    ask_terms();
    ask_phases();
    ask_start();
    ask_data();
    return std::move(candidates_);
  }

 private:
  using NameAndEntry = std::set<std::pair<std::string, int>>;

  void add(ProblemChange change, double slope, double nominal) {
    add_candidate(problem_, std::move(change), slope, nominal, relaxed_.amount, candidates_);
  }

  void add_sides(const ProblemChange& change, const HoldingForce& force, double nominal) {
    ProblemChange c = change;
    c.side = Side::upper;
    if (force.is_value) return add(c, force.lower - force.upper, nominal);
    if (force.upper * nominal > worth_noting) add(c, -force.upper, nominal);
    c.side = Side::lower;
    if (force.lower * nominal > worth_noting) add(c, force.lower, nominal);
  }

  void ask_terms() {
    for (int k = 0; k < static_cast<int>(relaxed_.asked.size()); ++k) {
      const NegotiableConstraint& asked = relaxed_.asked[k];
      if (!asked.change) continue;
      HoldingForce force = relaxed_.force_of(k);
      force.upper /= asked.unit;
      force.lower /= asked.unit;
      add_sides({*asked.change, asked.phase, asked.name, asked.component}, force,
                asked.group.nominal * asked.unit);
    }
  }

  void ask_variables(const ProblemChange& change, const std::vector<int>& variables,
                     double nominal) {
    HoldingForce force{.is_value = false};
    for (const int v : variables) {
      const double z = relaxed_.result.point.z[v];
      force.upper += std::max(z, 0.0) / nominal;
      force.lower += std::max(-z, 0.0) / nominal;
    }
    add_sides(change, force, nominal);
  }

  void ask_inputs(int j) {
    const ShootingProgram& program = relaxed_.shooting->program();
    const PhaseDefinition& phase = problem_.phases()[j];
    std::set<int> bounded;
    for (const PhaseDefinition::ComponentBounds& b : phase.input_bounds)
      if (!b.bounds.is_equality()) bounded.insert(b.component);  // equal bounds stay equal
    const int coefficients = program.integrators()[j]->arguments().nc;
    for (const int i : bounded) {
      std::vector<int> variables;
      for (int k = 0; k < program.grid().intervals(j); ++k)
        for (int c = i; c < coefficients; c += phase.sizes.nu)
          if (!program.grid().interval(j, k).is_empty())
            variables.push_back(program.layout().input(j, k) + c);
      ask_variables({Kind::input, j, {}, i}, variables, phase.nominal_input[i]);
    }
  }

  void ask_phases() {
    const Layout& layout = relaxed_.shooting->layout();
    NameAndEntry unknowns;
    for (int j = 0; j < static_cast<int>(problem_.phases().size()); ++j) {
      ask_inputs(j);
      const PhaseDefinition& phase = problem_.phases()[j];
      if (layout.duration(j) >= 0)
        ask_variables({Kind::duration, j}, {layout.duration(j)}, phase.nominal_duration);
      int p = 0;
      for (const PhaseDefinition::ParameterBlock& block : phase.parameters)
        for (int i = 0; i < block.value.size(); ++i, ++p)
          if (block.unknown && unknowns.insert({block.name, i}).second)
            ask_variables({Kind::parameter, j, block.name, i}, {layout.parameter(j, p)},
                          block.nominal[i]);
    }
  }

  void ask_start() {
    const int row = relaxed_.shooting->program().start_row();
    const PhaseDefinition& first = problem_.phases().front();
    for (int i = 0; i < first.sizes.nx; ++i) {
      const double force = relaxed_.multiplier(row + i) / first.nominal_state[i];
      add_sides(
          {Kind::start, 0, {}, i},
          {std::max(force, 0.0), std::max(-force, 0.0), problem_.start_bounds()[i].is_equality()},
          first.nominal_state[i]);
    }
  }

  // Sum of multipliers times (rows - sides) at the point with the current data. Its derivative is
  // that of the relaxation (envelope theorem). NaN if a side has vanished.
  double held() {
    ShootingProgram& program = relaxed_.shooting->editable_program();
    const VectorXd w = relaxed_.point();
    VectorXd g(program.rows());
    if (!program.constraints(w.data(), g.data())) return std::nan("");
    double sum = 0.0;
    const auto hold = [&](double force, double value, double lower, double upper) {
      if (std::abs(force) > worth_noting) sum += force * (value - (force > 0.0 ? upper : lower));
    };
    for (int r = 0; r < program.rows(); ++r)
      hold(relaxed_.multiplier(r), g[r], program.row_lower()[r], program.row_upper()[r]);
    const std::vector<ElasticGroup>& groups = relaxed_.program->groups();
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const std::vector<int> rows = relaxed_.program->rows_of(static_cast<int>(k));
      for (std::size_t i = 0; i < groups[k].variables.size(); ++i) {
        const int v = groups[k].variables[i];
        hold(relaxed_.multiplier(rows[groups[k].rows.size() + i]), w[v], program.lower()[v],
             program.upper()[v]);
      }
    }
    for (int v = 0; v < program.variables(); ++v)
      if (relaxed_.program->upper()[v] < infinity || relaxed_.program->lower()[v] > -infinity)
        hold(relaxed_.result.point.z[v], w[v], program.lower()[v], program.upper()[v]);
    return std::isfinite(sum) ? sum : std::nan("");
  }

  template <class Edit>
  double rate_along(double h, Edit&& edit) {
    ShootingProgram& program = relaxed_.shooting->editable_program();
    const ProblemData before = program.data();
    double ends[2] = {};
    for (const int side : {0, 1}) {
      ProblemData data = before;
      edit(data, side == 0 ? -h : h);
      try {
        program.commit(data);
        ends[side] = held();
      } catch (const DefinitionError&) {
        ends[side] = std::nan("");  // the bounds would cross
      }
    }
    program.commit(before);
    return (ends[1] - ends[0]) / (2.0 * h);
  }

  void ask_data() {
    NameAndEntry seen;
    for (int j = 0; j < static_cast<int>(problem_.phases().size()); ++j) {
      const PhaseDefinition& phase = problem_.phases()[j];
      if (!phase.has_free_duration()) {
        const double T = phase.duration.lower;
        add({Kind::duration, j},
            rate_along(difference_step * T,
                       [&](ProblemData& data, double d) { data.durations[j] += d; }),
            T);
      }
      for (const PhaseDefinition::ParameterBlock& block : phase.parameters)
        for (int i = 0; i < block.value.size(); ++i)
          if (!block.unknown && seen.insert({block.name, i}).second && !is_late_())
            add_entry_candidate(j, block, i);
    }
  }

  // Blocks with one name are one parameter in all phases.
  void add_entry_candidate(int j, const PhaseDefinition::ParameterBlock& block, int i) {
    const auto move = [&](ProblemData& data, double d) {
      for (std::size_t other = 0; other < problem_.phases().size(); ++other) {
        int first = 0;
        for (const PhaseDefinition::ParameterBlock& b : problem_.phases()[other].parameters) {
          if (b.name == block.name && i < b.value.size()) data.parameters[other][first + i] += d;
          first += static_cast<int>(b.value.size());
        }
      }
    };
    const double size = datum_magnitude(block.value[i], block.nominal[i], size_of_zero_data);
    add({Kind::parameter, j, block.name, i}, rate_along(difference_step * size, move),
        std::max(std::abs(block.value[i]), block.nominal[i]));
  }

  const OptimalControlProblem& problem_;
  LeastRelaxation& relaxed_;
  const std::function<bool()>& is_late_;
  std::vector<Candidate> candidates_;
};

}  // namespace

bool Candidate::is_credible() const {
  constexpr double most_effort = 20.0;
  const bool turns_round = change.kind == Kind::parameter && before * (before + change.by) < 0.0;
  return effort() <= most_effort && !turns_round;
}

void add_candidate(const OptimalControlProblem& problem, ProblemChange change, double slope,
                   double nominal, double relaxation, std::vector<Candidate>& candidates) {
  if (!std::isfinite(slope) || std::abs(slope) * nominal < worth_noting) return;
  const double before = value_before(problem, change);
  if (!std::isfinite(before)) return;
  Candidate candidate{std::move(change), slope};
  candidate.before = before;
  candidate.scale = before == 0.0 ? nominal : std::max(std::abs(before), 1e-3 * nominal);
  candidate.change.by = -relaxation / slope;
  if (candidate.is_credible()) candidates.push_back(std::move(candidate));
}

std::vector<Candidate> find_candidates(const OptimalControlProblem& problem,
                                       LeastRelaxation& relaxed,
                                       const std::function<bool()>& is_late) {
  return Sensitivities(problem, relaxed, is_late).run();
}

}  // namespace saltus
