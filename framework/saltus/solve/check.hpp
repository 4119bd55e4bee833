// Checks a problem before it is used: one page with a verdict per line.
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

/// A page of verdicts on a problem, made before it is solved.
struct ProblemCheck {
  /// Verdict of one line of a check.
  enum class Verdict {
    good,
    doubtful,  ///< the aspect needs attention; the text says why
    unknown    ///< could not be checked; the text says why
  };

  /// One aspect of a problem: "start", "derivatives", "sparsity", "jumps", "bounds", "scaling",
  /// "ranks", "integration", "reach", "definition".
  struct Line {
    std::string aspect;               ///< aspect that was checked
    Verdict verdict = Verdict::good;  ///< verdict of the aspect
    std::string text;                 ///< a sentence with phase, term and time
  };

  std::string problem;      ///< name of the problem
  std::vector<Line> lines;  ///< one per aspect

  /// True if no line is doubtful.
  bool ok() const;
  /// The line of the given aspect.
  const Line& line(const std::string& aspect) const;
  /// All lines with their verdicts.
  std::string text() const;
};

/// Checks these aspects:
/// - definition: definitions that solvers reject, and valid ones that look like mistakes;
/// - start: formulas and their derivatives are finite at the guess;
/// - derivatives and sparsity: first and second derivatives, and entries outside the patterns,
///   compared with differences near the guess (formulas in C++ are exact; an external Function may
///   be wrong);
/// - jumps: maps between phases, the closing and resets are finite at the end of the guess, and
///   their derivatives are correct;
/// - bounds: bounds that contradict each other, a start outside its bounds;
/// - scaling: quantities without a nominal magnitude whose size is far from one;
/// - ranks: equations that follow from others or contradict them;
/// - integration: the integration error of the grid along a first solution;
/// - reach: a first solve by the native solver satisfies the constraints.
///
/// `options` as for MultipleShooting; the default integrator is Runge-Kutta 4 in two steps, as in
/// solve(). Takes about as long as a solve. Errors of the problem never throw.
ProblemCheck check(const OptimalControlProblem& problem, ShootingOptions options = {});

}  // namespace saltus
