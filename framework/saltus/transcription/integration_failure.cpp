#include "saltus/transcription/integration_failure.hpp"

#include <fmt/format.h>

#include <vector>

namespace saltus {
namespace {

// The quantities integrated along phase j besides the states: running costs, then integrals.
// Restores their selection in the destructor.
class IntegratedCosts {
 public:
  IntegratedCosts(const ShootingProgram& program, int j)
      : program_(program), phase_(j), costs_(program.integrated_costs()[j]) {
    const PhaseDefinition& phase = program.problem().phases()[j];
    if (!program.integrators()[j]->follows_running_costs()) return;
    const int integrals = static_cast<int>(phase.integrals.size());
    if (costs_.size() > integrals)
      for (const Term& term : phase.terms)
        if (term.kind != Term::Kind::constraint && term.domain == Term::Domain::running)
          items_.push_back({fmt::format("term '{}'", term.name), &term});
    for (const IntegralConstraint& integral : phase.integrals)
      items_.push_back({fmt::format("integral '{}'", integral.name), nullptr});
    for (std::size_t i = 0; i < items_.size(); ++i)
      items_[i].before = costs_.is_evaluated(static_cast<int>(i));
  }
  ~IntegratedCosts() {
    for (std::size_t i = 0; i < items_.size(); ++i)
      costs_.evaluate(static_cast<int>(i), items_[i].before);
  }
  IntegratedCosts(const IntegratedCosts&) = delete;
  IntegratedCosts& operator=(const IntegratedCosts&) = delete;

  // Selects the quantities whose windows contain interval k.
  void select(int k) {
    for (std::size_t i = 0; i < items_.size(); ++i) costs_.evaluate(static_cast<int>(i), in(k, i));
  }

  // Name of the quantity that prevents integration of interval k. Empty if the dynamics fail.
  std::string culprit(int k, const VectorXd& argument) {
    if (items_.empty() || !is_good_with(-1, argument)) return {};
    for (std::size_t i = 0; i < items_.size(); ++i)
      if (in(k, i) && !is_good_with(static_cast<int>(i), argument)) return items_[i].name;
    return {};
  }

 private:
  bool in(int k, std::size_t i) const {
    const Grid& grid = program_.grid();
    const Term* term = items_[i].term;
    return term == nullptr || grid.interval_in(phase_, k, grid.resolve(phase_, term->window));
  }
  bool is_good_with(int only, const VectorXd& argument) {
    for (std::size_t i = 0; i < items_.size(); ++i)
      costs_.evaluate(static_cast<int>(i), static_cast<int>(i) == only);
    Integrator& integrator = *program_.integrators()[phase_];
    VectorXd end(integrator.outputs());
    return integrator.value(argument.data(), end.data()) == IntegrationStatus::success;
  }

  struct Item {
    std::string name;
    const Term* term = nullptr;
    bool before = true;
  };
  const ShootingProgram& program_;
  int phase_;
  const SelectiveStack& costs_;
  std::vector<Item> items_;
};

}  // namespace

std::string describe_integration_failure(const ShootingProgram& program, const VectorXd& w) {
  std::string along_the_way;
  for (int j = 0; j < program.grid().phases(); ++j) {
    const PhaseDefinition& phase = program.problem().phases()[j];
    Integrator& integrator = *program.integrators()[j];
    if (const std::string recent = integrator.failure(); !recent.empty())
      along_the_way = fmt::format("phase '{}', during the solve: {}", phase.name, recent);
    const IntervalArguments a = integrator.arguments();
    const VectorXd p = program.parameters_of(j, &w);
    const double start = program.start_of(j, &w), T = program.duration_of(j, &w);
    VectorXd argument(a.size()), end(integrator.outputs()), c(a.nc);
    IntegratedCosts costs(program, j);
    for (int k = 0; k < program.grid().intervals(j); ++k) {
      for (int i = 0; i < a.nc; ++i)
        c[i] = w[program.layout().input(j, k) + i] * phase.nominal_input[i % phase.sizes.nu];
      const Grid::Interval& interval = program.grid().interval(j, k);
      argument << w.segment(program.layout().state(j, k), a.nx).cwiseProduct(phase.nominal_state),
          c, p, start + interval.offset(T), interval.length(T);
      costs.select(k);
      const IntegrationStatus status = integrator.value(argument.data(), end.data());
      if (status == IntegrationStatus::success) continue;
      std::string why = integrator.failure();
      if (const std::string cost = costs.culprit(k, argument); !cost.empty())
        return fmt::format("phase '{}', {} in interval {} has no finite value", phase.name, cost,
                           k);
      if (const AlgebraicPart& algebraic = phase.algebraic) {
        VectorXd at(phase.sizes.size());
        at << argument[a.t0()], argument.head(a.nx), c.head(phase.sizes.nu), p;
        const ConsistentStart found = consistent_start(*algebraic.equations, at);
        if (!found.found()) why = found.message;
      }
      return fmt::format("phase '{}', interval {} from t = {:.6g} s: {}", phase.name, k,
                         start + interval.offset(T), why.empty() ? describe(status) : why);
    }
  }
  return along_the_way;
}

}  // namespace saltus
