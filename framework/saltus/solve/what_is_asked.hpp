// What a problem asks for, as groups of rows and bounds of its program: each gives as one.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "saltus/solve/problem_change.hpp"
#include "saltus/solver/elastic_program.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// A row of a hard term, link, integral or of the closing, or the bounds of a state, wherever they
/// act.
struct AskedFor {
  const char* kind = "term";                       ///< as in Shortage
  std::optional<ProblemChange::Kind> change = {};  ///< empty: nothing that could be changed
  int phase = 0;          ///< of links that where the latest end is, of the whole 0
  bool has_phase = true;  ///< whether its name says so
  std::string name;       ///< of the term; of a state "state 1"
  int component = 0;      ///< row of the term, or state
  double unit = 1.0;      ///< of the term over that of the rows
  bool gives = true;      ///< whether it is negotiable
  ElasticGroup group;     ///< its rows and variables
  std::vector<shooting::GridPoint> points;  ///< where they act, rows first
};

/// All of it; nominal values as at w. What `is_negotiable` denies does not give (empty: all does).
std::vector<AskedFor> what_is_asked(ShootingProgram& program, const VectorXd& w,
                                    const std::function<bool(const AskedFor&)>& is_negotiable = {});

}  // namespace saltus
