// A problem with a known answer: definition, solver options and expected values.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "problems/library/checked_value.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// Check of the derivatives of a small program of the case against central differences. The file of
/// the case gives the reason for other values.
struct DerivativeCheck {
  int intervals = 5;        ///< at most, per phase
  double radius = 0.05;     ///< distance of the point from the guess, in scaled variables
  double step = 1e-5;       ///< step of the differences, in scaled variables
  double tolerance = 1e-6;  ///< relative to 1 + |entry|
  /// Used if the integrator of the case is unstable on so few intervals; empty: that of the case.
  IntegratorChoice integrator = {};
};

struct ReferenceCase {
  std::string id;            ///< short and stable, for example "B01"
  std::string name;          ///< name of its file in problems/library: "bryson_denham"
  std::string summary = {};  ///< one sentence that states the problem
  /// With units, for tables and pictures: "height [m]".
  std::vector<std::string> states = {}, inputs = {};
  std::string exercises;  ///< features of the framework that the case tests
  std::string source;     ///< source of the statement and the optimum

  std::function<OptimalControlProblem()> problem;  ///< with its guess
  ShootingOptions options;

  double optimum = 0.0;  ///< minimum of the cost; the negative value for maximisation
  int digits = 0;        ///< known digits of the optimum
  /// tolerance of the cost, relative to 1 + |optimum|; the file gives the reason
  double tolerance = 0.0;
  /// Ends of all phases but the last, s; empty if they are given or unknown.
  std::vector<double> switching_times = {};
  /// s; larger than the tolerance of the cost, which is flat in the switching times
  double switching_tolerance = 1e-4;

  /// Permitted violation of path constraints between the nodes, in their units.
  double between_nodes = 1e-6;
  /// Other known values of the solution: states, inputs, multipliers.
  std::function<std::vector<CheckedValue>(const Solution&)> more = {};
  /// Permitted distance of the plan from its replay by CVODES at 1e-12, relative to
  /// max(nominal, |state|). The fixed steps of the cases are accurate to 1e-10.
  double replay = 1e-8;
  /// False if the flow is so unstable that only single intervals are replayed; the file gives the
  /// reason.
  bool replay_from_start = true;
  DerivativeCheck derivatives = {};
  /// Iteration limit; the file gives the reason for another value.
  int max_iterations = 500;
};

}  // namespace saltus
