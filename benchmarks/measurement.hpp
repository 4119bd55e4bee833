// Times solves, and checks each of them against the data of its problem.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/statistics.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// KKT residual above which a solve counts as failed, whatever the status of its solver.
inline constexpr double accepted_residual = 1e-8;

struct Failure {
  std::uint64_t seed = 0;  ///< instance of the case
  qp::QpStatus status = qp::QpStatus::invalid_problem;
  double residual = 0.0;
};

/// Another value of a case, for example the mean number of active rows.
struct Detail {
  std::string name;
  double value = 0.0;
};

struct CaseResult {
  std::string name;
  int n = 0;
  Spread microseconds;
  double iterations_mean = 0.0;
  int iterations_max = 0;
  double kkt_max = 0.0;
  std::vector<Failure> failures;
  std::vector<Detail> details;
};

class Measurement {
 public:
  explicit Measurement(std::string name) { result_.name = std::move(name); }

  const std::string& name() const { return result_.name; }
  /// Solves and counts the solve. Only the time of the solver is measured.
  void solve(qp::StageQpSolver& solver, const qp::StageQp& qp, qp::StagePoint& point, bool warm,
             std::uint64_t seed);
  /// Counts a solve that was timed elsewhere.
  void count(double microseconds, const qp::QpResult& result, double residual, std::uint64_t seed);
  /// Adds to a value whose mean over all solves is reported.
  void detail(const std::string& name, double value);

  CaseResult result() const;

 private:
  CaseResult result_;
  std::vector<double> times_;
  double iterations_ = 0.0;
};

/// Number of rows of a group, or bounds of the program, with a non-zero multiplier.
int binding_rows(const qp::StageQp& qp, const qp::StagePoint& point, int stage, int group);
int binding_bounds(const qp::StageQp& qp, const qp::StagePoint& point);

}  // namespace saltus::bench
