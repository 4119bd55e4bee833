// Solves a batch of programs with the structured solver, so that compare_instructions.py can count
// the instructions:
//
//     riccati_instructions cold|fixed-sizes|warm
//
// It prints the compiler and the number of iterations.
#include <fmt/format.h>

#include <cstdlib>
#include <string>

#include "saltus/core/random.hpp"
#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "tests/support/random_qp.hpp"

namespace {

using namespace saltus;  // NOLINT(google-build-using-namespace): a program of one file

constexpr int programs = 20;
constexpr int states = 8, inputs = 4;
constexpr qp::RiccatiKernel kernels[] = {qp::riccati_kernel<states, inputs, states>(),
                                         qp::riccati_kernel<0, inputs, states>(),
                                         qp::riccati_kernel<states, inputs, 0>()};

// A regular program of the largest sizes that random_qp() draws.
testing::RandomQp program(int seed) {
  testing::RandomQpOptions options;
  options.min_intervals = options.max_intervals = 15;
  options.free_start = options.varying_sizes = options.semidefinite = 0.0;
  options.degenerate = options.rank_deficient = options.tight = options.large_multipliers = 0.0;
  return testing::random_qp(seed, options);
}

int run(const std::string& batch) {
  const bool warm = batch == "warm", fixed_sizes = batch == "fixed-sizes";
  int iterations = 0;
  Random random(1);
  for (int seed = 1, solved = 0; solved < programs; ++seed) {
    testing::RandomQp instance = program(seed);
    qp::StageQp& qp = instance.qp;
    if (qp.stages.front().nx != states || qp.stages.front().nu != inputs) continue;
    ++solved;
    const auto solver =
        qp::make_riccati_solver(qp, {},
                                fixed_sizes ? std::span<const qp::RiccatiKernel>(kernels)
                                            : std::span<const qp::RiccatiKernel>());
    qp::StagePoint point(qp);
    if (warm) {
      point = instance.optimum;
      for (qp::Stage& s : qp.stages)
        for (double& slope : s.q) slope += 0.1 * random.uniform(-1.0, 1.0);
    }
    const qp::QpResult result = solver->solve(qp, point, warm);
    if (result.status != qp::QpStatus::optimal) return -1;
    iterations += result.iterations;
  }
  return iterations;
}

}  // namespace

int main(int count, char** arguments) {
  const int iterations = count == 2 ? run(arguments[1]) : -1;
  fmt::print("gcc {}\n{} iterations\n", __GNUC__, iterations);
  return iterations < 0 ? EXIT_FAILURE : EXIT_SUCCESS;
}
