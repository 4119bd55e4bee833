#include "benchmarks/suite/qp_problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "benchmarks/data_file.hpp"
#include "benchmarks/point_shift.hpp"
#include "benchmarks/recorded_sequence.hpp"
#include "benchmarks/step_recovery_batches.hpp"
#include "benchmarks/suite/closed_loops.hpp"
#include "benchmarks/suite/flat_qp.hpp"
#include "benchmarks/suite/sized_kernels.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus::bench {
namespace {

QpInstance in_stages(qp::StageQp qp, const qp::StagePoint& guess) {
  QpInstance instance;
  instance.flat = flatten(qp);
  instance.guess = flatten(qp, guess).w;
  instance.stages = std::move(qp);
  return instance;
}

// Cold starts at the static wrench and the resulting states.
qp::RiccatiOptions standing_start() {
  qp::RiccatiOptions options;
  options.start = qp::QpOptions::Start::guess;
  options.roll_out = true;
  return options;
}

QpProblem recipe(const Batch& batch) {
  QpProblem problem{.name = batch.name,
                    .about = "step recovery of a humanoid, random pushes",
                    .horizon = batch.options.intervals,
                    .kernels = sized_kernels()};
  problem.instance = [batch](int number) {
    qp::StageQp qp = step_recovery_qp(batch.options, random_start(number, batch.push));
    const qp::StagePoint guess = standing_guess(qp);
    return in_stages(std::move(qp), guess);
  };
  return problem;
}

// The warm start of tick k is the optimum of tick k - 1, one stage earlier, for all solvers.
QpProblem recorded_recovery() {
  const auto sequence = std::make_shared<const RecordedSequence>(
      read_sequence(data_file("step_recovery_sequence.json")));
  QpProblem problem{.name = "sequence",
                    .about = "step recovery in closed loop, recorded",
                    .instances = static_cast<int>(sequence->problems.size()) - 1,
                    .horizon = sequence->intervals,
                    .has_warm_start = true,
                    .kernels = sized_kernels()};
  problem.instance = [sequence](int number) {
    const qp::StageQp before = sequence->program(number - 1);
    qp::StagePoint solution = standing_guess(before);
    const auto solver = qp::make_riccati_solver(before, standing_start(), sized_kernels());
    solver->solve(before, solution, /*warm=*/false);
    qp::StageQp qp = sequence->program(number);
    qp::StagePoint guess = standing_guess(qp),
                   shifted(step_recovery_qp({sequence->intervals, 0}, nominal_start()));
    shift_by_one_stage(before, solution, qp, guess, shifted);
    QpInstance instance = in_stages(std::move(qp), guess);
    instance.warm = flatten(*instance.stages, shifted);
    return instance;
  };
  return problem;
}

// Program and warm start of tick k, from the plan of tick k - 1.
QpProblem closed_loop(ClosedLoop loop, const std::string& about,
                      std::span<const qp::RiccatiKernel> kernels) {
  QpProblem problem{.name = loop.name,
                    .about = about,
                    .instances = loop.ticks,
                    .horizon = loop.intervals,
                    .has_warm_start = true,
                    .kernels = kernels};
  problem.instance = [loop](int number) {
    ClosedLoop::Tick tick = loop.tick(number);
    QpInstance instance;
    instance.flat = flatten(tick.qp);
    instance.warm = flatten(tick.qp, tick.warm);
    instance.stages = std::move(tick.qp);
    return instance;
  };
  return problem;
}

}  // namespace

std::vector<QpProblem> qp_problems() {
  std::vector<QpProblem> problems;
  for (const Batch& batch : step_recovery_batches())
    if (batch.options.intervals < 1000) problems.push_back(recipe(batch));
  problems.push_back(recorded_recovery());
  problems.push_back(
      closed_loop(chain_loop(), "hanging chain in closed loop, linearised", chain_sizes()));
  problems.push_back(
      closed_loop(car_loop(), "car that changes lanes in closed loop, linearised", car_sizes()));
  return problems;
}

const QpProblem& find_problem(const std::vector<QpProblem>& problems, const std::string& name) {
  const auto at = std::find_if(problems.begin(), problems.end(),
                               [&](const QpProblem& p) { return p.name == name; });
  if (at != problems.end()) return *at;
  std::vector<std::string> names;
  for (const QpProblem& p : problems) names.push_back(p.name);
  const std::string meant = nearest_name(name, names);
  throw InputError(
      meant.empty()
          ? fmt::format("there is no problem '{}'; the problems are {}", name, join_names(names))
          : fmt::format("there is no problem '{}'; did you mean '{}'?", name, meant));
}

}  // namespace saltus::bench
