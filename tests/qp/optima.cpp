// Prints optima of random programs by the structured solver with all digits, for compare_widths.py.
// One executable is built per vector width.
#include <fmt/format.h>

#include <cstdlib>

#include "saltus/qp/stage_qp.hpp"
#include "tests/support/random_qp.hpp"

int main(int count, char** words) {
  using namespace saltus;  // NOLINT(google-build-using-namespace): a program of one file
  const int programs = count > 1 ? std::atoi(words[1]) : 500;
  for (int seed = 1; seed <= programs; ++seed) {
    const testing::RandomQp random = testing::random_qp(seed, {});
    qp::StagePoint point(random.qp);
    const qp::QpResult result =
        qp::make_riccati_solver(random.qp)->solve(random.qp, point, /*warm=*/false);
    fmt::print("{} {} {} {}", seed, static_cast<int>(result.status), result.iterations,
               result.objective);
    for (const qp::StagePoint::AtStage& stage : point.stages)
      for (const double x : stage.x) fmt::print(" {}", x);
    fmt::print("\n");
  }
}
