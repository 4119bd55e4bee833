// The quadratic programs of the benchmark suite by name: families of numbered instances.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// One program with its starting points. `flat` always exists.
struct QpInstance {
  std::optional<qp::StageQp> stages = {};
  std::optional<VectorXd> guess = {};        ///< variables of a cold start
  std::optional<PrimalDualPoint> warm = {};  ///< primal and dual warm start
  qp::SparseQp flat = {};
};

struct QpProblem {
  std::string name = {};   ///< "recipe/kI=7"
  std::string about = {};  ///< one sentence
  int instances = 0;       ///< numbered from 1; 0: unlimited
  int horizon = 0;         ///< intervals; 0: no stages
  bool has_warm_start = false;
  std::span<const qp::RiccatiKernel> kernels = {};  ///< sizes known to the compiler
  std::function<QpInstance(int number)> instance = {};
};

/// All families. Throws InputError if a file of recorded problems is missing.
std::vector<QpProblem> qp_problems();
/// The family of this name. Throws InputError with the nearest name.
const QpProblem& find_problem(const std::vector<QpProblem>& problems, const std::string& name);

}  // namespace saltus::bench
