// A problem with a known answer: how it is solved and what has to come out.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "problems/library/checked_value.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// How the derivatives of a small program of the case are checked against central differences. What
/// differs from these figures has its reason in the file of the case.
struct DerivativeCheck {
  int intervals = 5;        ///< at most, per phase
  double radius = 0.05;     ///< distance of the point from the guess, in scaled variables
  double step = 1e-5;       ///< of the differences, in scaled variables
  double tolerance = 1e-6;  ///< relative to 1 + |entry|
  /// Where the case's own leaves its stability on so few intervals; empty: that one.
  IntegratorChoice integrator = {};
};

struct ReferenceCase {
  std::string id;            ///< short and stable, as in the literature list: "B01"
  std::string name;          ///< of the file in problems/library: "bryson_denham"
  std::string summary = {};  ///< one sentence on what is to be done
  /// With units, for tables and pictures: "height [m]".
  std::vector<std::string> states = {}, inputs = {};
  std::string exercises;  ///< what of the framework it puts to the test
  std::string source;     ///< where the statement and the optimum come from

  std::function<OptimalControlProblem()> problem;  ///< with its guess
  ShootingOptions options;

  double optimum = 0.0;  ///< of the cost that is minimised; its negative where a value is maximised
  int digits = 0;        ///< of the optimum that are known
  double tolerance = 0.0;  ///< on the cost, relative to 1 + |optimum|, and its reason in the file
  /// Ends of all phases but the last, s; empty where they are given or unknown.
  std::vector<double> switching_times = {};
  double switching_tolerance = 1e-4;  ///< s; the cost is flat in them, so that digits are lost

  /// How far path constraints may be missed between the nodes, in their own units.
  double between_nodes = 1e-6;
  /// What else is known of the solution: states, inputs, multipliers.
  std::function<std::vector<CheckedValue>(const Solution&)> more = {};
  /// How far the plan may be from its replay by CVODES at 1e-12, relative to max(nominal, |state|);
  /// the fixed steps of the cases are good to 1e-10.
  double replay = 1e-8;
  /// False where the flow is too unstable to replay more than single intervals; why is in the file.
  bool replay_from_start = true;
  DerivativeCheck derivatives = {};
  /// Where the usual limit does not do, with its reason in the file.
  int max_iterations = 500;
};

}  // namespace saltus
