// What a closed loop missed of the problem that its controller solves: ends, path constraints and
// bounds, judged by the motion of the plant and in the units of the terms.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "saltus/model/event_integrator.hpp"
#include "saltus/ocp/problem.hpp"

namespace saltus {

/// A hard constraint that the motion did not meet: the largest miss of each.
struct LoopMiss {
  std::string phase;       ///< name of the phase
  std::string term;        ///< its name; "state 2", "input 0", "duration" or "total time"
  double time = 0.0;       ///< where the miss is largest, s
  double amount = 0.0;     ///< beyond the bound, in the unit of the term; infinite: no number
  double tolerance = 0.0;  ///< in the unit of the term: a smaller miss is none
  bool at_end = false;     ///< asked for at the end or the start of a phase, not along the way
};

/// Largest miss that counts as none, per row: `relative` times the largest of 1, the finite bounds
/// of the row and its nominal value; for a term of a name in `of_term` the number given there.
struct MissTolerance {
  double relative = 1e-6;                      ///< see above
  std::map<std::string, double> of_term = {};  ///< in the units of the terms
  /// For a row of this term.
  double of(const std::string& term, const Bounds& bounds, double nominal = 1.0) const;
};

/// Follows a motion through the phases of a problem. Formulas that throw count as missed by
/// infinity.
class MissRecord {
 public:
  /// `problem` must outlive the record; `parameters` gives p of a phase as it is then. `recedes`:
  /// the horizon moves along, so that no phase ends and windows count from each instant.
  MissRecord(const OptimalControlProblem& problem, MissTolerance tolerance,
             std::function<VectorXd(int phase)> parameters, bool recedes);

  /// The first phase begins.
  void begin(double t, const VectorXd& state, const VectorXd& input);
  /// Along a piece of constant input: bounds and path constraints.
  void look(double t, const VectorXd& state, const VectorXd& input);
  /// The phase ends before the event; the next one, if any, begins behind it.
  void end_phase(const HybridEvent& event, const VectorXd& input);
  /// Whether the last phase has ended.
  bool is_over() const { return is_over_; }

  /// What is missed by more than its tolerance, the worst relative to its tolerance first.
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
  double begin_ = 0.0, entered_ = 0.0;  // s
  std::vector<LoopMiss> largest_;
};

/// One clause: "phase 'swing up', 'upright' is missed by 0.33 at t = 1.9 s (tolerance 3e-06)".
std::string describe(const LoopMiss& miss);

}  // namespace saltus
