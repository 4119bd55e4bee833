// The least relaxation of a problem: solved, with what it is about, and read.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "saltus/solve/explanation.hpp"
#include "saltus/solve/what_is_asked.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// A relaxation, or a part of one, that counts: what a good solution of the problem itself leaves.
inline constexpr double worth_naming = 1e-6;

/// How hard something holds at the optimum: sums of its multipliers.
struct HoldingForce {
  double upper = 0.0, lower = 0.0;  ///< at upper and at lower sides, positive
  bool is_value = true;             ///< both sides are one, wherever it acts
};

/// What an elastic program of the problem came to.
struct LeastRelaxation {
  std::unique_ptr<MultipleShooting> shooting;  ///< of the problem
  std::vector<AskedFor> asked;                 ///< of it
  std::vector<int> group;                      ///< of each of these in `program`; -1: it holds
  std::unique_ptr<ElasticProgram> program;     ///< of `shooting`
  NlpResult result;                            ///< of `program`
  double amount = infinity;                    ///< sum of amounts over nominal values

  /// Whether it is the least, near where it began.
  bool ok() const { return is_success(result.status); }
  /// Whether something has to give.
  bool is_needed() const { return amount > worth_naming; }
  /// As a point of the problem's own program.
  VectorXd point() const;
  /// The motion.
  Trajectory trajectory() const;
  /// Of a row of `program`.
  double multiplier(int row) const { return result.point.lambda[row]; }
  /// How hard asked[k] holds.
  HoldingForce force_of(int k) const;
};

/// Solves the elastic program, from the trajectory or else from the problem's own guess. Throws
/// DefinitionError where the problem or the options are wrong.
LeastRelaxation least_relaxation(const OptimalControlProblem& problem,
                                 const ShootingOptions& options, Solver& solver,
                                 const Trajectory* guess = nullptr,
                                 const std::function<bool(const AskedFor&)>& is_negotiable = {});

/// What gives, read from a relaxation.
struct WhatGives {
  std::vector<Shortage> shortages;     ///< the largest first, relative to nominal values
  std::vector<ProblemChange> changes;  ///< by which bounds would have to move
  bool can_change = true;              ///< whether `changes` has all of it: a closing cannot
};
/// A row that repeats another one, as hulls of fixed size have, is named once.
WhatGives what_gives(LeastRelaxation& relaxed);

}  // namespace saltus
