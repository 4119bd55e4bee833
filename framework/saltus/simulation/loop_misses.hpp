// Violations of the controller's problem by a closed-loop run: ends, path constraints and bounds,
// evaluated on the motion of the plant in the units of the terms.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "saltus/model/event_integrator.hpp"
#include "saltus/ocp/problem.hpp"

namespace saltus {

/// True if the window is open at time t of a phase that begins at `phase_start`, s.
bool is_in_force(const Window& window, const Schedule& schedule, double phase_start, double t);

/// A violated hard constraint with its largest violation.
struct LoopMiss {
  std::string phase;       ///< name of the phase
  std::string term;        ///< its name; "state 2", "input 0", "duration" or "total time"
  double time = 0.0;       ///< time in seconds of the largest violation
  double amount = 0.0;     ///< beyond the bound, in the unit of the term; infinite: not a number
  double tolerance = 0.0;  ///< in the unit of the term; smaller violations are ignored
  bool at_end = false;     ///< constraint at the start or end of a phase, not along it
};

/// Tolerances per row: `relative` times the largest of 1, the finite bounds of the row and its
/// nominal value. `of_term` overrides the tolerance of named terms.
struct MissTolerance {
  double relative = 1e-6;                      ///< relative tolerance
  std::map<std::string, double> of_term = {};  ///< tolerances of named terms, in their units
  /// Tolerance of a row of this term.
  double of(const std::string& term, const Bounds& bounds, double nominal = 1.0) const;
};

/// Follows a motion through the phases of a problem and records violations. Formulas that throw
/// count as an infinite violation.
class MissRecord {
 public:
  /// `problem` must outlive the record. `parameters` returns the current p of a phase. With
  /// `recedes` the horizon moves along: no phase ends, and windows count from each instant.
  MissRecord(const OptimalControlProblem& problem, MissTolerance tolerance,
             std::function<VectorXd(int phase)> parameters, bool recedes);

  /// Starts the first phase.
  void begin(double t, const VectorXd& state, const VectorXd& input);
  /// Checks bounds and path constraints at an instant with this input.
  void look(double t, const VectorXd& state, const VectorXd& input);
  /// Ends the phase before the event and starts the next one, if any, after it.
  void end_phase(const HybridEvent& event, const VectorXd& input);
  /// True if the last phase has ended.
  bool is_over() const { return is_over_; }

  /// Violations beyond their tolerances, largest ratio first.
  std::vector<LoopMiss> misses() const;

 private:
  const PhaseDefinition& definition() const { return problem_.phases()[phase_]; }
  bool is_in_force(const Window& window, double t) const;
  void judge(const std::string& term, double t, double value, const Bounds& bounds, double nominal,
             bool at_end);
  void judge(const Term& term, double t, const VectorXd& z, bool at_end);
  VectorXd argument(double t, const VectorXd& state, const VectorXd& input) const;
  void judge_once(TermDomain domain, double t, const VectorXd& state, const VectorXd& input);

  const OptimalControlProblem& problem_;
  MissTolerance tolerance_;
  std::function<VectorXd(int)> parameters_;
  bool recedes_;
  int phase_ = 0;
  bool is_over_ = false;
  double begin_ = 0.0, entered_ = 0.0;  // in seconds
  std::vector<LoopMiss> largest_;
};

/// Describes a miss in one clause: "phase 'swing up', 'upright' is missed by 0.33 at t = 1.9 s
/// (tolerance 3e-06)".
std::string describe(const LoopMiss& miss);

}  // namespace saltus
