// Solvers on the same instances, each with its own measurement.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "benchmarks/cases.hpp"
#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

struct Contender {
  Measurement measurement;
  std::unique_ptr<qp::StageQpSolver> solver;
};

class Contenders {
 public:
  explicit Contenders(const Selection& selection) : selection_(&selection) {}

  /// Omitted unless selected.
  void add(const std::string& name, const qp::StageQp& capacity, const qp::RiccatiOptions& options,
           std::span<const qp::RiccatiKernel> kernels) {
    if (selection_->wants(name))
      all_.push_back({Measurement(name), qp::make_riccati_solver(capacity, options, kernels)});
  }
  bool empty() const { return all_.empty(); }

  /// Cold solves from the guess by all solvers. `about(measurement, point)` adds details.
  template <class About>
  void solve(const qp::StageQp& qp, const qp::StagePoint& guess, std::uint64_t seed,
             About&& about) {
    for (Contender& c : all_) {
      qp::StagePoint point = guess;
      // The first solve of a solver has cold caches and unmapped pages.
      if (first_) c.solver->solve(qp, point, false);
      point = guess;
      c.measurement.solve(*c.solver, qp, point, false, seed);
      about(c.measurement, point);
    }
    first_ = false;
  }

  std::vector<CaseResult> results() const {
    std::vector<CaseResult> results;
    for (const Contender& c : all_) results.push_back(c.measurement.result());
    return results;
  }

 private:
  const Selection* selection_;
  std::vector<Contender> all_;
  bool first_ = true;
};

}  // namespace saltus::bench
