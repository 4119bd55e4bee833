// Negotiable constraints of a problem, as groups of rows and bounds of its program.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "saltus/solve/explain.hpp"
#include "saltus/solver/elastic_program.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// A row of a hard term, link or integral or of the closing, or the bounds of a state, at all its
/// nodes.
struct NegotiableConstraint {
  const char* kind = "term";                       ///< kind as in Shortage
  std::optional<ProblemChange::Kind> change = {};  ///< empty: no datum of the problem changes it
  int phase = 0;          ///< links: phase of the latest end; constraints of the whole problem: 0
  bool has_phase = true;  ///< true if its name includes the phase
  std::string name;       ///< name of the term; of a state "state 1"
  int component = 0;      ///< row of the term, or state
  double unit = 1.0;      ///< unit of the term divided by that of the rows
  bool gives = true;      ///< true if it is negotiable
  ElasticGroup group;     ///< its rows and variables
  std::vector<shooting::GridPoint> points;  ///< nodes of the rows, then of the variables
};

/// All constraints, with nominal values at w. Those that `is_negotiable` rejects stay hard (empty:
/// all are negotiable).
std::vector<NegotiableConstraint> negotiable_constraints(
    ShootingProgram& program, const VectorXd& w,
    const std::function<bool(const NegotiableConstraint&)>& is_negotiable = {});

}  // namespace saltus
