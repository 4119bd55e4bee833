// The batches of the recipe: time of a cold solve of the step recovery.
#include "benchmarks/cases.hpp"
#include "benchmarks/contenders.hpp"
#include "benchmarks/step_recovery_batches.hpp"
#include "benchmarks/step_recovery_kernels.hpp"

namespace saltus::bench {
namespace {

std::string with_run_time_sizes(const std::string& name) { return name + ",run-time-sizes"; }

std::vector<CaseResult> run(const Batch& batch, const Selection& selection) {
  const qp::StageQp capacity = step_recovery_qp(batch.options, nominal_start());
  Contenders contenders(selection);
  contenders.add(batch.name, capacity, from_standing(), step_recovery_kernels);
  if (batch.with_run_time_sizes)
    contenders.add(with_run_time_sizes(batch.name), capacity, from_standing(), {});
  const int solves = std::max(1, selection.solves / batch.fewer);
  for (int seed = 1; seed <= solves && !contenders.empty(); ++seed) {
    const qp::StageQp qp = step_recovery_qp(batch.options, random_start(seed, batch.push));
    contenders.solve(qp, standing_guess(qp), seed,
                     [&](Measurement& m, const qp::StagePoint& point) {
                       // The group of capture-point rows follows those of the feet.
                       int binding = 0;
                       for (int k = std::max(batch.options.landing, 1); k < qp.intervals(); ++k)
                         binding += binding_rows(qp, point, k, 2);
                       if (batch.options.landing <= qp.intervals())
                         binding += binding_rows(qp, point, qp.intervals(), 0);
                       m.detail("binding capture-point rows", binding);
                     });
  }
  return contenders.results();
}

}  // namespace

std::vector<CaseGroup> step_recovery_cases() {
  std::vector<CaseGroup> groups;
  for (const Batch& batch : step_recovery_batches()) {
    CaseGroup& group = groups.emplace_back();
    group.names = {batch.name};
    if (batch.with_run_time_sizes) group.names.push_back(with_run_time_sizes(batch.name));
    group.run = [batch](const Selection& selection) { return run(batch, selection); };
  }
  return groups;
}

}  // namespace saltus::bench
