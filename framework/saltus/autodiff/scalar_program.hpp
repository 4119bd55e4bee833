// Evaluates nodes of an expression graph one after the other.
#pragma once

#include <vector>

#include "saltus/autodiff/expression_graph.hpp"

namespace saltus::detail {

/// A list of instructions that compute nodes of a graph into slots of a workspace. It has two
/// parts, so that nodes of the second part can be left out.
class ScalarProgram {
 public:
  ScalarProgram() = default;
  /// Computes the nodes of `first` in part 0 and those of `second` in part 1, and everything that
  /// they need. The graph has inputs 0 to inputs - 1.
  ScalarProgram(const ExpressionGraph& graph, int inputs, const std::vector<int>& first,
                const std::vector<int>& second);

  /// Number of slots of a workspace.
  int slots() const { return slots_; }
  /// Slot of an input.
  static int slot_of_input(int input) { return 1 + input; }
  /// Slot of a node that the program computes.
  int slot_of(int node) const { return slot_[node]; }
  /// Number of operations of a part; an elementary function counts as several.
  int operations(int part) const { return operations_[part]; }

  /// Writes the constants. Call it once for each workspace.
  void prepare(double* slots) const;
  /// Evaluates a part. The inputs must be in their slots, and part 1 needs part 0.
  void run(int part, double* slots) const;

 private:
  struct Row {
    Elementary function;  // none: a sum of products
    int to, end;          // destination; end of the products, or of the functions
  };
  struct Call {
    int a, b;
    double parameter;
  };
  struct Constant {
    int to;
    double value;
  };
  void add(const ExpressionGraph& graph, const std::vector<int>& roots, int part);

  int slots_ = 1;
  int operations_[2] = {0, 0};
  int end_[2] = {0, 0};  // rows of part 0 and of both parts
  std::vector<int> slot_;
  std::vector<Constant> constants_;
  std::vector<Row> rows_;
  std::vector<Product> products_;  // with slots in place of nodes
  std::vector<Call> calls_;
  int first_product_[2] = {0, 0};
  int first_call_[2] = {0, 0};
};

/// Cost of an elementary function in products.
inline constexpr int function_cost = 15;

}  // namespace saltus::detail
