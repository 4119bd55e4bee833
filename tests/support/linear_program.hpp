// Solves a linear program by an interior-point method, for tests that need an answer independent of
// closed forms.
#pragma once

#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus::testing {

/// Minimises cost.x subject to bounds on x and on the rows sum_j value_j x_column_j.
struct LinearProgram {
  struct Entry {
    int column;
    double value;
  };
  struct Row {
    std::vector<Entry> entries;
    Bounds bounds;
  };
  VectorXd cost;
  std::vector<Bounds> variables;
  std::vector<Row> rows;

  /// Adds a variable and returns its column.
  int variable(const Bounds& bounds, double cost_coefficient = 0.0);
  void row(std::vector<Entry> entries, const Bounds& bounds);
};

struct LinearProgramResult {
  bool optimal = false;
  double objective = 0.0;
  VectorXd x;
};

LinearProgramResult solve(const LinearProgram& program);

}  // namespace saltus::testing
