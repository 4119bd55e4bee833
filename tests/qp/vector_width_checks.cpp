#include "tests/qp/vector_width_checks.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/qp/riccati_solver.hpp"
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
    const Stage& first = random.qp.stages.front();
    if (fixed_sizes && (first.nx != 5 || first.nu != 3)) continue;
    ++report.programs;
    StagePoint point(random.qp);
    const auto solver = make_riccati_solver(random.qp, {},
                                            fixed_sizes ? std::span<const qp::RiccatiKernel>(fixed)
                                                        : std::span<const qp::RiccatiKernel>());
    const QpResult result = solver->solve(random.qp, point, /*warm=*/false);
    report.worst_cost = std::max(report.worst_cost, std::abs(result.objective - random.cost) /
                                                        std::max(1.0, std::abs(random.cost)));
    report.worst_residual =
        std::max(report.worst_residual,
                 kkt_residual(random.qp, point).largest() / multiplier_scale(random.optimum));
    if (result.status == QpStatus::optimal) continue;
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
