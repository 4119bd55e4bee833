// A simulation or closed form with known answers: what runs and what has to come out.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "problems/library/checked_value.hpp"
#include "saltus/simulation/recording.hpp"

namespace saltus {

/// A motion to be looked at.
struct Motion {
  std::string name;  ///< of files: "crossing"; empty where the case has one only
  Recording recording;
  std::string failure = {};  ///< a sentence; empty: it reached its end
  std::string integrator = {};
  /// Columns to draw against one another, "y1" and "y2"; empty: against time only.
  std::vector<std::string> plane = {};
  bool logarithmic_time = false;
};

struct SimulationCase {
  std::string id;            ///< short and stable, as in the literature list: "D01"
  std::string name;          ///< of the file in problems/library: "van_der_pol_stiff"
  std::string summary = {};  ///< one sentence on what moves
  std::string exercises;     ///< what of the framework it puts to the test
  std::string source;        ///< where the statement and the answers come from
  /// Everything that is known, each with its own tolerance. What could not be computed is NaN.
  std::function<std::vector<CheckedValue>()> run;
  /// The motions of the case, for tables and pictures: by the scheme given, or by its own if none
  /// is.
  std::function<std::vector<Motion>(const IntegratorChoice& scheme)> motions = {};
};

}  // namespace saltus
