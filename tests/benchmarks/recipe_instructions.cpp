// Solves the step recovery's programs with the structured solver, for compare_instructions.py to
// count what that takes:
//
//     recipe_instructions kI=7|no-impact|kI=0|binding|run-time-sizes|warm
//
// It prints the compiler, then how many solves and iterations there were.
#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "benchmarks/point_shift.hpp"
#include "benchmarks/step_recovery_kernels.hpp"
#include "benchmarks/step_recovery_qp.hpp"

namespace {

using namespace saltus;         // NOLINT(google-build-using-namespace): a program of one file
using namespace saltus::bench;  // NOLINT(google-build-using-namespace)

constexpr int instances = 10, intervals = 15;

struct Count {
  int solves = 0, iterations = 0;
  bool failed = false;
  void add(const QpResult& result, const StageQp& qp, const StagePoint& point) {
    ++solves;
    iterations += result.iterations;
    failed = failed || result.status != QpStatus::optimal ||
             !(kkt_residual(qp, point).largest() <= 1e-8);
  }
};

Count cold(const std::string& batch) {
  const int landing = batch == "no-impact" ? intervals + 1 : batch == "kI=0" ? 0 : 7;
  const Bounds push = batch == "binding" ? binding_push : between(0.2, 0.3);
  const std::span<const qp::RiccatiKernel> kernels =
      batch == "run-time-sizes" ? std::span<const qp::RiccatiKernel>() : step_recovery_kernels;
  const StageQp capacity = step_recovery_qp({intervals, landing}, nominal_start());
  const auto solver = make_riccati_solver(capacity, from_standing(), kernels);
  Count count;
  for (int seed = 1; seed <= instances; ++seed) {
    const StageQp qp = step_recovery_qp({intervals, landing}, random_start(seed, push));
    StagePoint point = standing_guess(qp);
    count.add(solver->solve(qp, point, /*warm=*/false), qp, point);
  }
  return count;
}

// The recorded sequence without its first, cold solve: that one is counted too, as one of 60.
Count warm() {
  std::ifstream file(SALTUS_BENCHMARK_DATA "/step_recovery_sequence.json");
  const nlohmann::json problems = nlohmann::json::parse(file).at("problems");
  const StageQp capacity = step_recovery_qp({intervals, 0}, nominal_start());
  const auto solver = make_riccati_solver(capacity, from_standing(), step_recovery_kernels);
  StagePoint point(capacity), shifted(capacity);
  StageQp before(std::vector<StageCapacity>{});
  Count count;
  for (const nlohmann::json& problem : problems) {
    CentroidalState start;
    for (int i = 0; i < start.size(); ++i) start[i] = problem.at("start")[i].get<double>();
    StageQp qp = step_recovery_qp({intervals, problem.at("landing").get<int>()}, start);
    const StagePoint guess = standing_guess(qp);
    const bool first = before.stages.empty();
    if (first) {
      for (std::size_t k = 0; k < guess.stages.size(); ++k)
        point.stages[k].u.head(guess.stages[k].u.size()) = guess.stages[k].u;
    } else {
      shift_by_one_stage(before, point, qp, guess, shifted);
      std::swap(point, shifted);
    }
    count.add(solver->solve(qp, point, /*warm=*/!first), qp, point);
    before = std::move(qp);
  }
  return count;
}

}  // namespace

int main(int arguments, char** argument) {
  if (arguments != 2) return EXIT_FAILURE;
  const std::string batch = argument[1];
  const Count count = batch == "warm" ? warm() : cold(batch);
  fmt::print("gcc {}\n{} solves, {} iterations\n", __GNUC__, count.solves, count.iterations);
  return count.failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
