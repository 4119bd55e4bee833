// The quadratic programs of the benchmark suite by name: families of which an instance is a number.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "saltus/qp/riccati_solver.hpp"
#include "saltus/qp/sparse_qp.hpp"

namespace saltus::bench {

/// One program. What falls into stages has them, and a guess; `flat` is always there.
struct QpInstance {
  std::optional<StageQp> stages = {};
  StagePoint guess = {};                ///< of a cold start, where the program has stages
  std::optional<StagePoint> warm = {};  ///< primal and dual, of a warm start
  SparseQp flat = {};
};

struct QpProblem {
  std::string name = {};   ///< "recipe/kI=7"
  std::string about = {};  ///< one sentence
  int instances = 0;       ///< numbered from 1; 0: as many as one asks for
  int horizon = 0;         ///< intervals; 0: no stages
  bool has_warm_start = false;
  RiccatiOptions options = {};                      ///< how our own solver starts best
  std::span<const qp::RiccatiKernel> kernels = {};  ///< sizes known to the compiler
  std::function<QpInstance(int number)> instance = {};
};

/// All of them. Throws InputError if a file of recorded problems is missing.
std::vector<QpProblem> qp_problems();
/// Throws InputError with the nearest name.
const QpProblem& find_problem(const std::vector<QpProblem>& problems, const std::string& name);

}  // namespace saltus::bench
