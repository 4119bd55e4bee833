// Solves the programs of step recovery with the structured solver. compare_instructions.py counts
// the instructions:
//
//     recipe_instructions kI=7|no-impact|kI=0|binding|run-time-sizes|warm|one-foot|two-feet
//
// The last two are ticks of push recovery. Changes of the wrenches have a cost, so the previous
// wrenches are states. Capture points may leave the hull at a cost. The program prints the
// compiler, then the numbers of solves and iterations.
#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/point_shift.hpp"
#include "benchmarks/step_recovery_kernels.hpp"
#include "benchmarks/step_recovery_qp.hpp"
#include "saltus/core/random.hpp"

namespace {

using namespace saltus;         // NOLINT(google-build-using-namespace): a program of one file
using namespace saltus::bench;  // NOLINT(google-build-using-namespace)

constexpr int instances = 10, intervals = 15;

struct Count {
  int solves = 0, iterations = 0;
  bool failed = false;
  void add(const qp::QpResult& result, const qp::StageQp& qp, const qp::StagePoint& point) {
    ++solves;
    iterations += result.iterations;
    failed = failed || result.status != qp::QpStatus::optimal ||
             !(kkt_residual(qp, point).largest() <= 1e-8);
  }
};

Count cold(const std::string& batch) {
  const int landing = batch == "no-impact" ? intervals + 1 : batch == "kI=0" ? 0 : 7;
  const Bounds push = batch == "binding" ? binding_push : between(0.2, 0.3);
  const std::span<const qp::RiccatiKernel> kernels =
      batch == "run-time-sizes" ? std::span<const qp::RiccatiKernel>() : step_recovery_kernels;
  const qp::StageQp capacity = step_recovery_qp({intervals, landing}, nominal_start());
  const auto solver = qp::make_riccati_solver(capacity, from_standing(), kernels);
  Count count;
  for (int seed = 1; seed <= instances; ++seed) {
    const qp::StageQp qp = step_recovery_qp({intervals, landing}, random_start(seed, push));
    qp::StagePoint point = standing_guess(qp);
    count.add(solver->solve(qp, point, /*warm=*/false), qp, point);
  }
  return count;
}

// The recorded sequence without its first, cold solve. The count includes that solve, one of 60.
Count warm() {
  std::ifstream file(SALTUS_BENCHMARK_DATA "/step_recovery_sequence.json");
  const nlohmann::json problems = nlohmann::json::parse(file).at("problems");
  const qp::StageQp capacity = step_recovery_qp({intervals, 0}, nominal_start());
  const auto solver = qp::make_riccati_solver(capacity, from_standing(), step_recovery_kernels);
  qp::StagePoint point(capacity), shifted(capacity);
  qp::StageQp before(std::vector<qp::StageCapacity>{});
  Count count;
  for (const nlohmann::json& problem : problems) {
    CentroidalState start;
    for (int i = 0; i < start.size(); ++i) start[i] = problem.at("start")[i].get<double>();
    qp::StageQp qp = step_recovery_qp({intervals, problem.at("landing").get<int>()}, start);
    const qp::StagePoint guess = standing_guess(qp);
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

// Same settings as make_tick_controller() in robots/saltus/robots/walking/planner.cpp.
constexpr qp::RiccatiKernel tick_kernels[] = {
    qp::riccati_kernel<0, 6, 15, true>(),   qp::riccati_kernel<15, 6, 15, true>(),
    qp::riccati_kernel<15, 6, 9>(),         qp::riccati_kernel<0, 12, 21, true>(),
    qp::riccati_kernel<21, 12, 21, true>(), qp::riccati_kernel<21, 12, 9>(),
    qp::riccati_kernel<9, 0, 0>()};

// Adds the cost weight/2 |u_k - u_(k-1)|^2 with u_(k-1) as additional states, and makes rows on
// states soft. `applied` is the input before the first one.
qp::StageQp as_tick(const qp::StageQp& plain, double weight, const VectorXd& applied) {
  const int N = plain.intervals();
  std::vector<qp::StageCapacity> capacity;
  for (int k = 0; k <= N; ++k) {
    const qp::Stage& s = plain.stages[k];
    const int before = k > 0 ? plain.stages[k - 1].nu : 0;
    qp::StageCapacity& c = capacity.emplace_back(qp::StageCapacity{s.nx + before, s.nu, {}});
    for (const qp::RowGroup& g : s.groups)
      c.groups.push_back({g.rows, static_cast<int>(g.columns.size()), g.columns.back() < s.nx});
  }
  qp::StageQp qp(capacity);
  qp.start = plain.start;
  for (int k = 0; k <= N; ++k) {
    const qp::Stage& from = plain.stages[k];
    qp::Stage& s = qp.stages[k];
    const int nx = from.nx, nu = from.nu, before = s.nx - nx;
    s.Q.topLeftCorner(nx, nx) = from.Q;
    s.R = from.R;
    s.q.head(nx) = from.q;
    s.r = from.r;
    s.constant = from.constant;
    if (k < N) {
      s.A.topLeftCorner(nx, nx) = from.A;
      s.B.topRows(nx) = from.B;
      s.b.head(nx) = from.b;
      s.B.bottomRows(qp.stages[k + 1].nx - nx).leftCols(nu).setIdentity();
      const int changed = k == 0 ? nu : before;
      s.R.diagonal().head(changed).array() += weight;
      if (k == 0) s.r -= weight * applied.head(nu);
      if (k + 1 < N) s.R.diagonal().array() += weight;
      if (before > 0) s.S.rightCols(before).diagonal().setConstant(-weight);
    }
    for (std::size_t j = 0; j < s.groups.size(); ++j) {
      const qp::RowGroup& group = from.groups[j];
      qp::RowGroup& g = s.groups[j];
      const bool soft = g.soft;
      g = group;
      g.soft = soft;
      g.l1 = VectorXd::Constant(g.rows, 100.0);
      g.l2 = VectorXd::Constant(g.rows, 0.0);
      for (int& column : g.columns) column += column < nx ? 0 : before;
    }
  }
  return qp;
}

// Disturbed, warm-started ticks in sequence. The count includes the first tick, which is cold.
Count ticks(const std::string& batch) {
  constexpr double weight = 1.0;  // same as in push recovery, in units of 100 N
  const int landing = batch == "two-feet" ? 0 : intervals + 1;
  CentroidalState start = nominal_start();
  start.segment<3>(3) *= 0.5;
  const auto at = [&](const VectorXd& applied) {
    return as_tick(step_recovery_qp({intervals, landing}, start), weight, applied);
  };
  const qp::StageQp plain = step_recovery_qp({intervals, landing}, start);
  const qp::StagePoint guess = standing_guess(plain);
  qp::StageQp qp = at(guess.stages[0].u);
  const auto solver = qp::make_riccati_solver(qp, from_standing(), tick_kernels);
  qp::StagePoint point(qp);
  for (int k = 0; k < intervals; ++k) point.stages[k].u = guess.stages[k].u;
  Random random(1);
  Count count;
  for (int tick = 0; tick < instances; ++tick) {
    count.add(solver->solve(qp, point, /*warm=*/tick > 0), qp, point);
    const VectorXd applied = point.stages[0].u;
    start = point.stages[1].x.head<9>();
    for (int i = 0; i < 9; ++i) start[i] += random.uniform(-1.0, 1.0) * (i < 3 ? 1e-4 : 1e-3);
    qp = at(applied);  // warm start from the unshifted point, as with a fixed horizon
  }
  return count;
}

}  // namespace

int main(int arguments, char** argument) {
  if (arguments != 2) return EXIT_FAILURE;
  const std::string batch = argument[1];
  const bool is_tick = batch == "one-foot" || batch == "two-feet";
  const Count count = batch == "warm" ? warm() : is_tick ? ticks(batch) : cold(batch);
  fmt::print("gcc {}\n{} solves, {} iterations\n", __GNUC__, count.solves, count.iterations);
  return count.failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
