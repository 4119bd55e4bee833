// A formula as a graph of sums of products and elementary functions, with its local derivatives.
//
// Every node is an input, a constant, a sum  sum_k scale_k a_k b_k  or an elementary function f(a)
// or f(a, b), where a and b are earlier nodes. A linear term of a sum multiplies by node 0, the
// number 1. Equal nodes are stored once, constants are folded, and sums absorb the sums in them
// that nothing else uses. A quotient a / b is the product of a and 1 / b.
//
// Derivatives of a node with respect to its arguments are nodes again, so that values and all
// derivatives share subexpressions. At points without a finite derivative they equal those of dual
// numbers (math.hpp).
#pragma once

#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "saltus/autodiff/formula_steps.hpp"

namespace saltus::detail {

/// Elementary functions of a graph.
enum class Elementary {
  none,             ///< not a function
  inverse,          ///< 1 / a
  inverse_or_zero,  ///< 1 / a, or 0 if |a| <= parameter
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  sinh,
  cosh,
  tanh,
  exp,
  log,
  sqrt,
  abs,
  sign,           ///< -1, 0 or 1
  power,          ///< a ^ parameter
  power_or_zero,  ///< a ^ parameter, or 0 if a is 0 and the parameter is negative
  atan2,          ///< angle of the point (b, a)
  hypot           ///< sqrt(a a + b b)
};

/// Value of an elementary function.
double evaluate(Elementary function, double parameter, double a, double b);

/// A multiple of a node.
struct Scaled {
  double scale = 0.0;  ///< factor
  int node = 0;        ///< node; 0 is the number 1

  /// True if it is a number.
  bool is_constant() const { return node == 0; }
  /// True if it is the number 0.
  bool is_zero() const { return node == 0 && scale == 0.0; }
};

/// The product scale a b of two nodes, a >= b.
struct Product {
  double scale = 0.0;  ///< factor
  int a = 0;           ///< first node
  int b = 0;           ///< second node; 0 for a linear term

  friend bool operator==(const Product&, const Product&) = default;
};

/// One node of a graph.
struct ExpressionNode {
  int input = -1;                          ///< index of the input, or -1
  Elementary function = Elementary::none;  ///< elementary function, if it is one
  double parameter = 0.0;                  ///< parameter of the function
  int a = -1;                              ///< first argument of the function
  int b = -1;                              ///< second argument, or -1
  std::vector<Product> sum;                ///< products of a sum, in ascending order of nodes

  friend bool operator==(const ExpressionNode&, const ExpressionNode&) = default;
};

/// Derivative of a node with respect to an argument.
struct Partial {
  int argument = 0;   ///< argument
  Scaled derivative;  ///< value of the derivative
};
/// Second derivative of a node with respect to two arguments.
struct SecondPartial {
  int first = 0;      ///< argument
  int second = 0;     ///< argument, <= first
  Scaled derivative;  ///< value of the derivative
};

/// The graph. Nodes are appended only, so arguments precede their users.
class ExpressionGraph {
 public:
  ExpressionGraph();

  /// Number of nodes.
  int size() const { return static_cast<int>(nodes_.size()); }
  /// A node by index.
  const ExpressionNode& operator[](int node) const { return nodes_[node]; }
  /// The node of an input.
  Scaled input(int index);
  /// A sum of products. Returns a multiple of an existing node if possible.
  Scaled sum(std::vector<Product> products);
  /// The product of two multiples.
  Scaled product(const Scaled& a, const Scaled& b);
  /// An elementary function.
  Scaled apply(Elementary function, const Scaled& a, const Scaled& b = {1.0, -1},
               double parameter = 0.0);
  /// A node with the value of the multiple.
  int node_of(const Scaled& a);

  /// Appends the steps of a formula. Returns the nodes of its outputs, or an empty vector if it has
  /// a step that the graph does not represent: min, max, select or a power with an exponent that is
  /// not constant. Their unused branches may be NaN, which the graph would multiply by zero.
  std::vector<int> append(const FormulaSteps& steps);

  /// Derivatives of a node with respect to its arguments. Appends nodes.
  std::vector<Partial> partials(int node);
  /// Second derivatives that may be non-zero. Appends nodes.
  std::vector<SecondPartial> second_partials(int node);

 private:
  struct Hash {
    std::size_t operator()(const ExpressionNode& node) const;
  };
  int add(ExpressionNode node);
  int constant(double value);
  Scaled power(const Scaled& a, double exponent, bool or_zero);
  std::pair<Scaled, Scaled> angle_partials(const ExpressionNode& node, Scaled& inverse_length);

  std::vector<ExpressionNode> nodes_;
  std::unordered_map<ExpressionNode, int, Hash> known_;
};

}  // namespace saltus::detail
