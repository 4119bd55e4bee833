#include "saltus/transcription/integration_failure.hpp"

#include <fmt/format.h>

namespace saltus {

std::string name_integration_failure(const ShootingProgram& program, const VectorXd& w) {
  std::string along_the_way;
  for (int j = 0; j < program.grid().phases(); ++j) {
    const PhaseDefinition& phase = program.problem().phases()[j];
    Integrator& integrator = *program.integrators()[j];
    if (const std::string recent = integrator.failure(); !recent.empty())
      along_the_way = fmt::format("phase '{}', along the way: {}", phase.name, recent);
    const IntervalArguments a = integrator.arguments();
    const VectorXd p = program.parameters_of(j, &w);
    const double start = program.start_of(j, &w), T = program.duration_of(j, &w);
    VectorXd argument(a.size()), end(integrator.outputs()), c(a.nc);
    for (int k = 0; k < program.grid().intervals(j); ++k) {
      for (int i = 0; i < a.nc; ++i)
        c[i] = w[program.layout().input(j, k) + i] * phase.nominal_input[i % phase.sizes.nu];
      const GridInterval& interval = program.grid().interval(j, k);
      argument << w.segment(program.layout().state(j, k), a.nx).cwiseProduct(phase.nominal_state),
          c, p, start + interval.offset(T), interval.length(T);
      const IntegrationStatus status = integrator.value(argument.data(), end.data());
      if (status == IntegrationStatus::success) continue;
      std::string why = integrator.failure();
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
