#include "tests/qp/vector_width_checks.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "saltus/qp/packed_qp.hpp"
#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "tests/support/random_qp.hpp"

namespace saltus::testing {
WidthReport solve_random_programs(int programs, bool fixed_sizes) {
  static constexpr qp::RiccatiKernel fixed[] = {
      qp::riccati_kernel<5, 3, 5>(), qp::riccati_kernel<0, 3, 5>(), qp::riccati_kernel<5, 0, 0>(),
      qp::riccati_kernel<5, 3, 0>()};
  WidthReport report{qp::lanes};
  for (int seed = 1; report.programs < programs; ++seed) {
    RandomQpOptions options;
    if (fixed_sizes) options.varying_sizes = 0.0;
    const RandomQp random = random_qp(seed, options);
    const qp::Stage& first = random.qp.stages.front();
    if (fixed_sizes && (first.nx != 5 || first.nu != 3)) continue;
    ++report.programs;
    qp::StagePoint point(random.qp);
    const auto solver =
        qp::make_riccati_solver(random.qp, {},
                                fixed_sizes ? std::span<const qp::RiccatiKernel>(fixed)
                                            : std::span<const qp::RiccatiKernel>());
    const qp::QpResult result = solver->solve(random.qp, point, /*warm=*/false);
    report.worst_cost = std::max(report.worst_cost, std::abs(result.objective - random.cost) /
                                                        std::max(1.0, std::abs(random.cost)));
    report.worst_residual =
        std::max(report.worst_residual,
                 kkt_residual(random.qp, point).largest() / multiplier_scale(random.optimum));
    if (result.status == qp::QpStatus::optimal) continue;
    if (report.failed++ == 0) report.first_failed = seed;
  }
  return report;
}

namespace {

// The cost 1/2 |u - w|^2 makes the inputs follow the previous inputs w, and the inputs are bounded.
qp::StageQp with_previous_inputs(int seed) {
  constexpr int intervals = 4;
  Random random(seed);
  const int own = 1 + seed % 11, nu = 1 + seed % 7;
  std::vector<qp::StageCapacity> capacity;
  for (int k = 0; k <= intervals; ++k)
    capacity.push_back({own + (k > 0 ? nu : 0), k < intervals ? nu : 0, {}});
  qp::StageQp qp(capacity);
  qp.fixed_start = seed % 3 > 0;
  qp.start = random.vector(own);
  for (qp::Stage& s : qp.stages) {
    s.Q.diagonal().setOnes();
    s.q = random.vector(s.nx);
    if (s.nu == 0) continue;
    s.A.topLeftCorner(own, own) = random.matrix(own, own);
    s.B.topRows(own) = random.matrix(own, nu);
    s.B.bottomRows(nu).setIdentity();
    s.R.diagonal().setConstant(2.0);
    s.r = random.vector(nu);
    if (s.nx > own) s.S.rightCols(nu).diagonal().setConstant(-1.0);
    s.u_lower.setConstant(-0.3);
    s.u_upper.setConstant(0.3);
  }
  return qp;
}

}  // namespace

// Some of the programs have these sizes: 2 states and 6 inputs, 9 and 7.
WidthReport solve_with_previous_inputs(int programs) {
  static constexpr qp::RiccatiKernel kernels[] = {
      qp::riccati_kernel<0, 6, 8, true>(), qp::riccati_kernel<8, 6, 8, true>(),
      qp::riccati_kernel<0, 7, 16, true>(), qp::riccati_kernel<16, 7, 16, true>()};
  WidthReport report{qp::lanes};
  for (int seed = 1; seed <= programs; ++seed) {
    const qp::StageQp program = with_previous_inputs(seed);
    ++report.programs;
    qp::PackedQp packed(program, kernels);
    bool good = packed.pack(program);
    for (int k = 1; k + 1 < static_cast<int>(program.stages.size()); ++k) {
      const qp::SweepStage& s = packed.stages[k].sweep;
      good = good && s.dense < s.next && s.zero_end >= s.zero_begin;
      const bool is_known =
          s.nx == s.next && ((s.nx == 8 && s.nu == 6) || (s.nx == 16 && s.nu == 7));
      good = good && packed.stages[k].kernel->copies_inputs == is_known;
    }
    qp::StagePoint point(program);
    const qp::QpResult result =
        qp::make_riccati_solver(program, {}, kernels)->solve(program, point, /*warm=*/false);
    report.worst_residual = std::max(report.worst_residual, kkt_residual(program, point).largest());
    if (good && result.status == qp::QpStatus::optimal) continue;
    if (report.failed++ == 0) report.first_failed = seed;
  }
  return report;
}

double worst_product_error() {
  Random random(1);
  double worst = 0.0;
  for (int rows = 1; rows <= 20; ++rows)
    for (int columns = 1; columns <= 9; ++columns) {
      const int depth = 1 + (rows + columns) % 7, ld = qp::padded(rows);
      qp::AlignedArray A(ld * depth), B(depth * columns), out(ld * columns), y(ld);
      for (int j = 0; j < depth; ++j)
        for (int i = 0; i < rows; ++i) A[i + j * ld] = random.uniform(-1.0, 1.0);
      for (int i = 0; i < depth * columns; ++i) B[i] = random.uniform(-1.0, 1.0);
      qp::multiply(rows, columns, depth, A.data(), ld, B.data(), 1, depth, out.data(), ld);
      qp::multiply_vector<qp::Update::set>(rows, depth, A.data(), ld, B.data(), y.data());
      for (int j = 0; j < columns; ++j)
        for (int i = 0; i < rows; ++i) {
          double sum = 0.0;
          for (int l = 0; l < depth; ++l) sum += A[i + l * ld] * B[l + j * depth];
          worst = std::max(worst, std::abs(sum - out[i + j * ld]));
          if (j == 0) worst = std::max(worst, std::abs(sum - y[i]));
        }
    }
  return worst;
}

}  // namespace saltus::testing
