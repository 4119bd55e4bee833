// The nonlinear problems of the suite: those of the library, each as the shooting program of our
// solvers and as a file for other solvers.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "benchmarks/suite/timed.hpp"
#include "problems/library/reference_case.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus::bench {

/// Prefix of the names: "library/brachistochrone".
inline constexpr const char* library_prefix = "library/";

/// A case, with its program after the first request.
class NonlinearProblem {
 public:
  explicit NonlinearProblem(const ReferenceCase& c);

  const ReferenceCase& reference() const { return case_; }
  MultipleShooting& shooting() { return shooting_; }
  bool is_linear_quadratic() { return shooting_.nlp().is_linear_quadratic(); }
  int intervals() const;

  /// The program as elementary steps, with values and derivatives at some points for comparison;
  /// nonlinear_program.py defines the format. Throws DefinitionError if the program cannot be
  /// written as steps.
  nlohmann::ordered_json file();

  struct Solved {
    NlpResult result;
    SolveTimes times;  ///< The set-up is not measured.
  };
  /// Solves cold from the guess of the case, without a time limit.
  Solved solve(SolverChoice choice, double tolerance);

 private:
  const ReferenceCase& case_;
  MultipleShooting shooting_;
};

/// Names of all nonlinear problems, with the prefix.
std::vector<std::string> nonlinear_names();
/// The case with this name, including the prefix. Throws InputError with the nearest name.
const ReferenceCase& nonlinear_case(const std::string& name);

}  // namespace saltus::bench
