// The hanging chain: time of the linearisation and of the quadratic programs.
#include <algorithm>

#include "benchmarks/cases.hpp"
#include "benchmarks/chain_sqp.hpp"
#include "benchmarks/data_file.hpp"
#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {
namespace {

const std::string whole_name = "chain/solve", linearisation_name = "chain/linearisation",
                  qp_name = "chain/qp";

std::vector<CaseResult> run(const Selection& selection) {
  constexpr int nx = HangingChain::nx, nu = HangingChain::nu;
  static constexpr qp::RiccatiKernel kernels[] = {qp::riccati_kernel<nx, nu, nx>(),
                                                  qp::riccati_kernel<0, nu, nx>(),
                                                  qp::riccati_kernel<nx, 0, 0>()};
  TrackingProgram program = chain_program(read_chain(data_file("hanging_chain.json")));
  // The last SQP steps are far below the tolerance of the nonlinear program.
  qp::RiccatiOptions options;
  options.tolerance = 0.1 * accepted_residual;
  const auto solver = qp::make_riccati_solver(program.qp(), options, kernels);

  Measurement whole(whole_name), linearisation(linearisation_name), qp(qp_name);
  solve_chain(program, *solver);  // cold caches
  // One solve contains several programs, so fewer solves are needed.
  const int solves = std::max(1, selection.solves / 5);
  for (int i = 1; i <= solves; ++i) {
    const ChainSolve solve = solve_chain(program, *solver);
    qp::QpResult total;
    total.status = qp::QpStatus::optimal;
    double microseconds = solve.last_linearisation;
    linearisation.count(solve.last_linearisation, total, 0.0, i);
    for (const ChainSolve::Step& step : solve.steps) {
      microseconds += step.linearisation + step.qp;
      linearisation.count(step.linearisation, total, 0.0, i);
      qp.count(step.qp, step.result, step.qp_residual, i);
    }
    for (const ChainSolve::Step& step : solve.steps) {
      total.iterations += step.result.iterations;
      if (step.result.status != qp::QpStatus::optimal) total.status = step.result.status;
    }
    whole.count(microseconds, total, solve.residual, i);
    whole.detail("SQP steps", static_cast<double>(solve.steps.size()));
  }
  std::vector<CaseResult> results;
  for (const Measurement* m : {&whole, &linearisation, &qp})
    if (selection.wants(m->name())) results.push_back(m->result());
  return results;
}

}  // namespace

std::vector<CaseGroup> chain_cases() { return {{{whole_name, linearisation_name, qp_name}, run}}; }

}  // namespace saltus::bench
