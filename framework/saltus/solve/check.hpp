// A problem looked at before it is relied on: one page with a verdict per line.
//
//     std::cout << check(car).text();
//
// The same for problems by name: `saltus check P`.
#pragma once

#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// Of one line of a check.
enum class CheckVerdict {
  good,
  doubtful,  ///< what the line says should be looked at
  unknown    ///< could not be looked at, and the line says why
};

/// One aspect of a problem: "start", "derivatives", "sparsity", "jumps", "bounds", "scaling",
/// "ranks", "integration", "reach", "definition".
struct CheckLine {
  std::string aspect;                         ///< what was looked at
  CheckVerdict verdict = CheckVerdict::good;  ///< of it
  std::string text;                           ///< a sentence, with phase, term and time
};

/// A page of verdicts on a problem before it is solved.
struct ProblemCheck {
  std::string problem;           ///< its name
  std::vector<CheckLine> lines;  ///< one per aspect

  /// Whether nothing is doubtful.
  bool ok() const;
  /// By its aspect.
  const CheckLine& line(const std::string& aspect) const;
  /// All lines, each with its verdict.
  std::string text() const;
};

/// Looks at:
/// - definition: what is refused, and what is sound and yet looks like a mistake;
/// - start: are all formulas and their derivatives finite at the guess;
/// - derivatives and sparsity: first and second derivatives, and entries outside the patterns,
///   against differences near the guess (what formulas of C++ have is exact; an external Function's
///   may be wrong);
/// - jumps: are maps between phases, the closing and resets finite where the guess ends, and their
///   derivatives right?
/// - bounds: sides that exclude one another, a start that is outside;
/// - scaling: sizes far from one of what nobody gave a nominal magnitude;
/// - ranks: equations that follow from others or contradict them;
/// - integration: what the grid leaves of the differential equation along a first solution;
/// - reach: does a first solve, by our own solver, meet the constraints?
///
/// `options` as for MultipleShooting; without an integrator Runge-Kutta 4 in two steps, as solve()
/// has it. Takes about as long as a solve. Throws nothing for what is wrong with the problem.
ProblemCheck check(const OptimalControlProblem& problem, ShootingOptions options = {});

}  // namespace saltus
