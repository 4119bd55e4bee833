// A user's formula once its type is erased: value, Jacobian and weighted Hessian with fixed
// sparsity. Everything behind the template edge works with this type only.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/core/sparsity.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// Which second derivatives a Hessian carries. Gauss-Newton keeps J' W J of least-squares terms
/// and the full Hessian of general costs, and drops the curvature of constraints and dynamics.
enum class Curvature { exact, gauss_newton };

/// What stands behind a Function: y = f(z), z of `inputs` entries, y of `outputs` entries.
/// Evaluation does not throw by itself. Several threads may evaluate one body at once if
/// is_reentrant(), as all bodies of this library except interval_function(). A body that needs
/// working memory makes it at construction (WorkspacePool): evaluation then allocates only while
/// another thread evaluates the same body. Where that must not happen, take a separate() one.
class FunctionBody {
 public:
  /// How many numbers it takes and gives.
  FunctionBody(int inputs, int outputs) : inputs_(inputs), outputs_(outputs) {}
  virtual ~FunctionBody() = default;
  FunctionBody(const FunctionBody&) = delete;
  FunctionBody& operator=(const FunctionBody&) = delete;

  /// How many numbers it takes.
  int inputs() const { return inputs_; }
  /// How many numbers it gives.
  int outputs() const { return outputs_; }
  /// outputs x inputs: which entries of the Jacobian can be non-zero.
  const SparsityPattern& jacobian_pattern() const { return jacobian_pattern_; }
  /// inputs x inputs, lower triangle: which second derivatives can be non-zero.
  const SparsityPattern& hessian_pattern() const { return hessian_pattern_; }

  /// Degree of an output as a polynomial in the inputs with a flag, the others held: 0, 1, 2, or 3
  /// for everything else. Never too small. Set-up only.
  virtual int degree(int output, const std::vector<char>& variable) const;

  /// Whether the value can change with the input, differentiated or not.
  virtual bool reads(int input) const;

  /// Y (outputs) at z (inputs).
  virtual void value(const double* z, double* y) const = 0;
  /// Fills y and the entries of the Jacobian in the order of jacobian_pattern().
  virtual void jacobian(const double* z, double* y, double* entries) const = 0;
  /// Fills the entries of sum_i weights[i] d2 y_i / dz2 in the order of hessian_pattern().
  virtual void hessian(const double* z, const double* weights, double* entries,
                       Curvature curvature) const = 0;
  /// Both of the above at once, for functions that find one on the way to the other.
  virtual void derivatives(const double* z, const double* weights, double* y,
                           double* jacobian_entries, double* hessian_entries,
                           Curvature curvature) const;

  /// Whether several threads may evaluate this body at once. False for bodies of your own unless
  /// you override it: what contains them is then for one thread at a time.
  virtual bool is_reentrant() const { return false; }
  /// The same function with working memory of its own, for one thread at a time. Null: it needs
  /// none or cannot make any.
  virtual std::shared_ptr<const FunctionBody> separate() const { return nullptr; }

 protected:
  SparsityPattern jacobian_pattern_;  ///< outputs x inputs
  SparsityPattern
      hessian_pattern_;  ///< inputs x inputs, lower triangle, of any weighted sum of outputs

 private:
  int inputs_;
  int outputs_;
};

/// A handle with value semantics on an immutable body. Empty until assigned. Copies are compiled
/// once: what holds functions is copied and destroyed wherever a problem is written.
class Function {
 public:
  Function() = default;
  Function(const Function& other);
  Function(Function&& other) noexcept;
  Function& operator=(const Function& other);
  Function& operator=(Function&& other) noexcept;
  ~Function();
  /// Shares the body.
  explicit Function(std::shared_ptr<const FunctionBody> body) : body_(std::move(body)) {}
  /// Compiled once, unlike std::make_shared for the type of each formula.
  explicit Function(std::unique_ptr<const FunctionBody> body);

  /// Whether it is a function at all.
  explicit operator bool() const { return body_ != nullptr; }
  /// How many numbers it takes.
  int inputs() const { return body_->inputs(); }
  /// How many numbers it gives.
  int outputs() const { return body_->outputs(); }
  /// Outputs x inputs.
  const SparsityPattern& jacobian_pattern() const { return body_->jacobian_pattern(); }
  /// Inputs x inputs, lower triangle, of any weighted sum of outputs.
  const SparsityPattern& hessian_pattern() const { return body_->hessian_pattern(); }
  /// Of an output as a polynomial in the marked variables; above 2 where it is none.
  int degree(int output, const std::vector<char>& variable) const {
    return body_->degree(output, variable);
  }

  /// Whether any output depends on this input.
  bool reads(int input) const { return body_->reads(input); }
  /// The same for handles on one body, and for no others.
  const void* identity() const { return body_.get(); }
  /// Whether both are handles on one body.
  bool is(const Function& other) const { return body_ == other.body_; }

  /// Y (outputs) at z (inputs).
  void value(const double* z, double* y) const { body_->value(z, y); }
  /// Values and the entries of the Jacobian in the order of its pattern, at z.
  void jacobian(const double* z, double* y, double* entries) const {
    body_->jacobian(z, y, entries);
  }
  /// The entries of the Hessian of the sum of outputs with these weights, in the order of its
  /// pattern, at z.
  void hessian(const double* z, const double* weights, double* entries,
               Curvature curvature = Curvature::exact) const {
    body_->hessian(z, weights, entries, curvature);
  }
  /// Values, Jacobian and Hessian at once, as above.
  void derivatives(const double* z, const double* weights, double* y, double* jacobian_entries,
                   double* hessian_entries, Curvature curvature) const {
    body_->derivatives(z, weights, y, jacobian_entries, hessian_entries, curvature);
  }
  /// Whether several threads may evaluate it at once.
  bool is_reentrant() const { return body_->is_reentrant(); }
  /// The same function with working memory that no other Function uses, for one thread at a time:
  /// evaluation never allocates, whatever other threads do. Empty if the body is not re-entrant and
  /// knows no way to make one.
  Function separate() const;

  // Convenience for tests and set-up code; these allocate.
  /// Its values as a vector; allocates.
  VectorXd operator()(const VectorRef& z) const;
  /// Its Jacobian with all zeros, outputs x inputs; allocates.
  MatrixXd dense_jacobian(const VectorRef& z) const;
  /// Symmetric, both triangles.
  MatrixXd dense_hessian(const VectorRef& z, const VectorRef& weights,
                         Curvature curvature = Curvature::exact) const;

 private:
  std::shared_ptr<const FunctionBody> body_;
};

}  // namespace saltus
