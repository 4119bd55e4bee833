// The nonlinear problems of the suite: those of the library, each as the shooting program that our
// own solvers see, and as a file for solvers of others.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "problems/library/reference_case.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/solver/solver_choice.hpp"

namespace saltus::bench {

/// What stands before the name of a case: "library/brachistochrone".
inline constexpr const char* library_prefix = "library/";

/// A case, with its program once that was asked for.
class NonlinearProblem {
 public:
  explicit NonlinearProblem(const ReferenceCase& c);

  const ReferenceCase& reference() const { return case_; }
  MultipleShooting& shooting() { return shooting_; }
  bool is_linear_quadratic() { return shooting_.nlp().is_linear_quadratic(); }
  int intervals() const;

  /// The program as elementary steps, with values and derivatives at some points to compare with:
  /// the format is told in nonlinear_program.py. Throws DefinitionError, in a sentence, where it
  /// cannot be written so.
  nlohmann::ordered_json file();

  struct Solved {
    NlpResult result;
    double microseconds = 0.0;  ///< of the thread
  };
  /// Cold, from the case's guess: the second of two solves, so that memory is there.
  Solved solve(SolverChoice choice, double tolerance);

 private:
  const ReferenceCase& case_;
  MultipleShooting shooting_;
};

/// Names of all that are nonlinear, with the prefix.
std::vector<std::string> nonlinear_names();
/// The case of a name with the prefix. Throws InputError with the nearest name.
const ReferenceCase& nonlinear_case(const std::string& name);

}  // namespace saltus::bench
