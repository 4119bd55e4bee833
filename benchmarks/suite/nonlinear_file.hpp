// Nonlinear programs that are files of the format `saltus-nlp 1` (scripts/nonlinear_program.py).
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/suite/timed.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/block_program.hpp"

namespace saltus::bench {

/// A program read from a file, with its start.
class NonlinearFile : public BlockProgram {
 public:
  /// Throws InputError with the name of the file and the mistake.
  explicit NonlinearFile(const std::filesystem::path& file);

  std::string describe_variable(int i) const override;
  std::string describe_row(int i) const override;

  struct Solved {
    NlpResult result;  ///< Result of the last solve, with the iterations of all.
    SolveTimes times;  ///< The set-up is that of the solver.
  };
  /// Solves cold from the start of the file. A program with pairs is solved for products of at most
  /// 1, 0.1, ..., 1e-9, each from the previous point, and then with the smaller entry of each pair
  /// fixed at 0.
  Solved solve(SolverChoice choice, double tolerance);

 private:
  /// Two variables, one of which is 0 at a solution, and the row that bounds their product.
  struct Pair {
    int first, second, product;
  };

  NlpResult solve_once(Solver& solver);
  NlpResult solve_pairs(Solver& solver);

  VectorXd start_;
  std::vector<Pair> pairs_;
};

/// A function with these steps and its derivatives. Throws DefinitionError if a step is invalid.
Function function_of(FormulaSteps steps);

}  // namespace saltus::bench
