// A simulation or closed form with known answers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "problems/library/checked_value.hpp"
#include "saltus/simulation/loop_log.hpp"

namespace saltus {

/// A sampled motion.
struct Motion {
  std::string name;  ///< name of its files, for example "crossing"; empty if the case has only one
  Recording recording;
  std::string failure = {};  ///< one sentence; empty if the motion reached its end
  std::string integrator = {};
  /// Columns to draw against each other, for example "y1" and "y2"; empty: only against time.
  std::vector<std::string> plane = {};
  bool logarithmic_time = false;
};

struct SimulationCase {
  std::string id;            ///< short and stable, for example "D01"
  std::string name;          ///< name of its file in problems/library: "van_der_pol_stiff"
  std::string summary = {};  ///< one sentence that states the problem
  std::string exercises;     ///< features of the framework that the case tests
  std::string source;        ///< source of the statement and the answers
  /// All known values, each with its tolerance. A value that could not be computed is NaN.
  std::function<std::vector<CheckedValue>()> run;
  /// The motions of the case, for tables and pictures, by the given scheme or by that of the case.
  std::function<std::vector<Motion>(const IntegratorChoice& scheme)> motions = {};
};

}  // namespace saltus
