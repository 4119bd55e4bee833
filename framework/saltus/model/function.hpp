// A user's formula after type erasure: value, Jacobian and weighted Hessian with fixed sparsity.
// All code beyond the template layer uses this type only.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/core/sparsity.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

struct FormulaSteps;

// Layout of the argument z of a model function: time, state, input and parameters.

/// z = (t | x | u | p) with 1 + nx + nu + np entries.
struct Arguments {
  int nx = 0;  ///< states
  int nu = 0;  ///< inputs
  int np = 0;  ///< parameters

  /// Index of the time.
  constexpr int t() const { return 0; }
  /// Index of state i.
  constexpr int x(int i = 0) const { return 1 + i; }
  /// Index of input i.
  constexpr int u(int i = 0) const { return 1 + nx + i; }
  /// Index of parameter i.
  constexpr int p(int i = 0) const { return 1 + nx + nu + i; }
  /// Total number of entries.
  constexpr int size() const { return 1 + nx + nu + np; }

  friend bool operator==(const Arguments&, const Arguments&) = default;
};

/// Terms included in a Hessian. Gauss-Newton keeps J' W J of least-squares terms and the full
/// Hessian of other costs. It drops the curvature of constraints and dynamics.
enum class Curvature { exact, gauss_newton };

/// Implementation of a Function: y = f(z) with `inputs` entries of z and `outputs` entries of y.
///
/// Derive from it to use a function that is not a C++ formula, for example generated code. A
/// derived class sets both patterns in its constructor and implements value(), jacobian() and
/// hessian(). A pattern holds every entry that is nonzero for any z (and any weights), in rows with
/// ascending columns, and an evaluation writes all of its entries. The Hessian pattern is a lower
/// triangle. An entry that the patterns omit counts as zero: solvers then converge slowly or not at
/// all. check_derivatives() (saltus/model/derivative_check.hpp) compares patterns and entries with
/// differences. Outputs need second derivatives where z is a state, input, unknown or free time.
///
/// Evaluation does not throw by itself. Several threads may evaluate one body concurrently if
/// is_reentrant(). All bodies of this library are, except interval_function(). A body that needs a
/// workspace creates it at construction (WorkspacePool). Evaluation then allocates only if another
/// thread evaluates the same body at that time. Use separate() to avoid this.
class FunctionBody {
 public:
  /// Sets the number of inputs and outputs.
  FunctionBody(int inputs, int outputs) : inputs_(inputs), outputs_(outputs) {}
  virtual ~FunctionBody() = default;
  FunctionBody(const FunctionBody&) = delete;
  FunctionBody& operator=(const FunctionBody&) = delete;

  /// Number of inputs.
  int inputs() const { return inputs_; }
  /// Number of outputs.
  int outputs() const { return outputs_; }
  /// Sparsity of the Jacobian, outputs x inputs.
  const SparsityPattern& jacobian_pattern() const { return jacobian_pattern_; }
  /// Sparsity of the Hessian of any weighted sum of outputs, inputs x inputs, lower triangle.
  const SparsityPattern& hessian_pattern() const { return hessian_pattern_; }

  /// Degree of an output as a polynomial in the flagged inputs, with the other inputs fixed: 0, 1
  /// or 2, or 3 for everything else. Never too small. Set-up only.
  virtual int degree(int output, const std::vector<char>& variable) const;

  /// True if the value may depend on the input, even if its derivative is not computed.
  virtual bool reads(int input) const;

  /// Elementary steps of the formula that the function evaluates. Null if it is not a formula.
  virtual const FormulaSteps* steps() const { return nullptr; }

  /// Computes y at z.
  virtual void value(const double* z, double* y) const = 0;
  /// Computes y and the Jacobian entries in the order of jacobian_pattern().
  virtual void jacobian(const double* z, double* y, double* entries) const = 0;
  /// Computes the entries of sum_i weights[i] d2 y_i / dz2 in the order of hessian_pattern().
  virtual void hessian(const double* z, const double* weights, double* entries,
                       Curvature curvature) const = 0;
  /// Computes both at once, for functions whose derivatives share work.
  virtual void derivatives(const double* z, const double* weights, double* y,
                           double* jacobian_entries, double* hessian_entries,
                           Curvature curvature) const;

  /// True if several threads may evaluate this body concurrently. False unless overridden. Objects
  /// that contain a non-re-entrant body serve one thread at a time.
  virtual bool is_reentrant() const { return false; }
  /// A copy of the function with a separate workspace, for one thread at a time. Null if the
  /// function needs no workspace or cannot be copied.
  virtual std::shared_ptr<const FunctionBody> separate() const { return nullptr; }

 protected:
  SparsityPattern jacobian_pattern_;  ///< outputs x inputs
  SparsityPattern
      hessian_pattern_;  ///< inputs x inputs, lower triangle, of any weighted sum of outputs

 private:
  int inputs_;
  int outputs_;
};

/// Handle with value semantics to an immutable body. Empty until assigned. Copy operations are
/// compiled once, because problem definitions copy and destroy many functions.
class Function {
 public:
  Function() = default;
  Function(const Function& other);
  Function(Function&& other) noexcept;
  Function& operator=(const Function& other);
  Function& operator=(Function&& other) noexcept;
  ~Function();
  /// A handle to this body, shared with other handles.
  explicit Function(std::shared_ptr<const FunctionBody> body) : body_(std::move(body)) {}
  /// Takes ownership of the body. Compiled once, unlike std::make_shared for each formula type.
  explicit Function(std::unique_ptr<const FunctionBody> body);

  /// True if the handle has a body.
  explicit operator bool() const { return body_ != nullptr; }
  /// Number of inputs.
  int inputs() const { return body_->inputs(); }
  /// Number of outputs.
  int outputs() const { return body_->outputs(); }
  /// Sparsity of the Jacobian, outputs x inputs.
  const SparsityPattern& jacobian_pattern() const { return body_->jacobian_pattern(); }
  /// Sparsity of the Hessian of any weighted sum of outputs, inputs x inputs, lower triangle.
  const SparsityPattern& hessian_pattern() const { return body_->hessian_pattern(); }
  /// Degree of an output as a polynomial in the marked variables. 3 if it is not a polynomial of
  /// degree 0 to 2.
  int degree(int output, const std::vector<char>& variable) const {
    return body_->degree(output, variable);
  }

  /// True if any output depends on this input.
  bool reads(int input) const { return body_->reads(input); }
  /// Elementary steps of the formula that the function evaluates. Null if it is not a formula.
  const FormulaSteps* steps() const { return body_->steps(); }
  /// Equal for handles to the same body, different otherwise.
  const void* identity() const { return body_.get(); }
  /// True if both are handles to the same body.
  bool is(const Function& other) const { return body_ == other.body_; }

  /// Computes y at z.
  void value(const double* z, double* y) const { body_->value(z, y); }
  /// Computes y and the Jacobian entries in the order of the pattern.
  void jacobian(const double* z, double* y, double* entries) const {
    body_->jacobian(z, y, entries);
  }
  /// Computes the Hessian entries of the weighted sum of outputs in the order of the pattern.
  void hessian(const double* z, const double* weights, double* entries,
               Curvature curvature = Curvature::exact) const {
    body_->hessian(z, weights, entries, curvature);
  }
  /// Computes values, Jacobian and Hessian at once.
  void derivatives(const double* z, const double* weights, double* y, double* jacobian_entries,
                   double* hessian_entries, Curvature curvature) const {
    body_->derivatives(z, weights, y, jacobian_entries, hessian_entries, curvature);
  }
  /// True if several threads may evaluate it concurrently.
  bool is_reentrant() const { return body_->is_reentrant(); }
  /// The same function with an exclusive workspace, for one thread at a time. Its evaluation never
  /// allocates. Empty if the body is not re-entrant and cannot be copied.
  Function separate() const;

  // Convenience functions for tests and set-up code. They allocate. They throw DefinitionError if
  // the handle is empty or z is too short.
  /// Returns the values as a vector.
  VectorXd operator()(const VectorRef& z) const;
  /// Returns the Jacobian as a dense matrix, outputs x inputs.
  MatrixXd dense_jacobian(const VectorRef& z) const;
  /// Returns the Hessian as a dense symmetric matrix with both triangles.
  MatrixXd dense_hessian(const VectorRef& z, const VectorRef& weights,
                         Curvature curvature = Curvature::exact) const;

 private:
  std::shared_ptr<const FunctionBody> body_;
};

}  // namespace saltus
