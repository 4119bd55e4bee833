// The recorded recovery: time of warm and of cold solves.
#include "benchmarks/cases.hpp"
#include "benchmarks/data_file.hpp"
#include "benchmarks/point_shift.hpp"
#include "benchmarks/recorded_sequence.hpp"
#include "benchmarks/step_recovery_kernels.hpp"

namespace saltus::bench {
namespace {

const std::string warm_name = "sequence/warm", cold_name = "sequence/cold";

std::vector<CaseResult> run(const Selection& selection) {
  const RecordedSequence sequence = read_sequence(data_file("step_recovery_sequence.json"));
  const int ticks = static_cast<int>(sequence.problems.size());
  // With both feet from the start every stage has its largest size.
  const qp::StageQp capacity = step_recovery_qp({sequence.intervals, 0}, nominal_start());
  const auto warm_solver =
      qp::make_riccati_solver(capacity, from_standing(), step_recovery_kernels);
  const auto cold_solver =
      qp::make_riccati_solver(capacity, from_standing(), step_recovery_kernels);
  Measurement warm(warm_name), cold(cold_name);
  qp::StagePoint point(capacity), cold_point(capacity), shifted(capacity);
  const auto take_inputs = [](const qp::StagePoint& from, qp::StagePoint& to) {
    for (std::size_t k = 0; k < from.stages.size(); ++k)
      to.stages[k].u.head(from.stages[k].u.size()) = from.stages[k].u;
  };
  const int rounds = (selection.solves + ticks - 2) / (ticks - 1);
  for (int round = 0; round < rounds; ++round) {
    qp::StageQp before = sequence.program(0);
    take_inputs(standing_guess(before), point);
    warm_solver->solve(before, point, /*warm=*/false);  // cold, not counted
    for (int tick = 1; tick < ticks; ++tick) {
      qp::StageQp qp = sequence.program(tick);
      const qp::StagePoint guess = standing_guess(qp);
      shift_by_one_stage(before, point, qp, guess, shifted);
      std::swap(point, shifted);
      warm.solve(*warm_solver, qp, point, /*warm=*/true, tick);
      if (selection.wants(cold_name)) {
        take_inputs(guess, cold_point);
        cold.solve(*cold_solver, qp, cold_point, /*warm=*/false, tick);
      }
      before = std::move(qp);
    }
  }
  std::vector<CaseResult> results;
  if (selection.wants(warm_name)) results.push_back(warm.result());
  if (selection.wants(cold_name)) results.push_back(cold.result());
  return results;
}

}  // namespace

std::vector<CaseGroup> sequence_cases() { return {{{warm_name, cold_name}, run}}; }

}  // namespace saltus::bench
