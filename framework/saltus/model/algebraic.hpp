// Semi-explicit DAEs of index 1: x' = f(t, x, z, u, p), 0 = g(t, x, z, u, p) with a regular g_z. z
// is eliminated: a function of (t, x, z, u, p) becomes a function of (t, x, u, p) with exact
// derivatives. Code that takes dynamics, terms and guards therefore also works for DAEs.
// framework/design/dae.md has the derivation and the limits.
//
// Functions that read z take it after x, as part of the state: (t | x z | u | p).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/core/dense_lu.hpp"
#include "saltus/core/types.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

// Adapts a formula of (t, x, z, u, p) to make_function(), which expects z appended to x.

/// Takes (x z) as one vector and calls the formula as f(t, x, z, u, p), f(t, x, z, u), f(t, x, z)
/// or f(t, x).
template <int nx, int nz, class F>
struct FormulaWithAlgebraic {
  F formula;  ///< the user's formula

  /// Splits xz into x and z and calls the formula.
  template <class S, class U, class P>
  auto operator()(const S& t, const Vec<S, nx + nz>& xz, const U& u, const P& p) const {
    Vec<S, nx> x;
    Vec<S, nz> z;
    for (int i = 0; i < nx; ++i) x.data()[i] = xz.data()[i];
    for (int j = 0; j < nz; ++j) z.data()[j] = xz.data()[nx + j];
    if constexpr (requires { formula(t, x, z, u, p); }) {
      return formula(t, x, z, u, p);
    } else if constexpr (requires { formula(t, x, z, u); }) {
      return formula(t, x, z, u);
    } else if constexpr (requires { formula(t, x, z); }) {
      return formula(t, x, z);
    } else if constexpr (requires { formula(t, x); }) {
      return formula(t, x);
    } else {
      static_assert(
          requires { formula(t, x); },
          "a formula with algebraic states must be callable through a const operator() "
          "as f(t, x), f(t, x, z), f(t, x, z, u) or f(t, x, z, u, p), with t a scalar S "
          "and x, z, u, p vectors Vec<S, n> of the declared sizes, for every scalar S");
      return t;
    }
  }
};

/// The equations 0 = g(t, x, z, u, p), one for each entry of z. z is the solution that damped
/// Newton iterations reach from a given start. It depends on (t, x, u, p) only, not on earlier
/// calls.
class AlgebraicEquations {
 public:
  /// Outcome of a solve for the algebraic states.
  enum class Status {
    solved,
    not_finite,   ///< an equation is infinite or NaN
    singular,     ///< an equation does not determine z given the others: the index exceeds 1
    no_solution,  ///< Newton's method does not converge to a root
  };

  /// z at one argument and the data for its derivatives. Created by
  /// AlgebraicEquations::new_solution().
  struct Solution {
    /// Allocates for these numbers of equations, arguments and Jacobian entries.
    Solution(int equations, int arguments, int entries);

    std::vector<double> argument;  ///< (t | x z | u | p)
    std::vector<double> entries;   ///< Jacobian of g at the argument
    detail::DenseLu slope;         ///< factors of g_z, after AlgebraicEquations::factor()
    std::vector<double> direct;    ///< dz / d (t | x | u | p), row-major, after differentiate()
    int equation = -1;             ///< index of the equation that failed, or -1

    // Workspace of Newton's method and of compositions with it.
    std::vector<double> residual, step, next_step, before;  ///< one number per equation
    std::vector<double> largest;                            ///< largest |z| so far
  };

  /// `sizes` are those of (t | x | u | p). The entries of `start` are also the magnitudes of z,
  /// with 1 in place of zero. Throws DefinitionError with the equation if the sizes do not match or
  /// if g_z is structurally singular (index above 1).
  AlgebraicEquations(const Arguments& sizes, Function equations, VectorXd start);

  /// Number of equations, equal to the number of algebraic states.
  int count() const { return static_cast<int>(start_.size()); }
  /// Sizes of the formulas without z: t, x, u, p.
  const Arguments& sizes() const { return sizes_; }
  /// The same sizes with the algebraic states appended to x.
  Arguments extended() const { return {sizes_.nx + count(), sizes_.nu, sizes_.np}; }
  /// g(t, (x, z), u, p), zero at the solution.
  const Function& equations() const { return equations_; }
  /// Start of the Newton iteration.
  const VectorXd& start() const { return start_; }
  /// True if entry j of z may depend on this entry of (t | x | u | p).
  bool depends(int j, int argument) const { return depends_[j][argument] != 0; }

  /// Allocates a solution. solve(), factor() and differentiate() then do not allocate.
  Solution new_solution() const {
    return {count(), extended().size(), equations_.jacobian_pattern().entries()};
  }
  /// The same equations with a separate() function. Returns the argument if its function needs no
  /// workspace, and null if the function cannot be separated.
  static std::shared_ptr<const AlgebraicEquations> separate(
      const std::shared_ptr<const AlgebraicEquations>& equations);
  /// Solves for z at (t | x | u | p), to rounding error.
  Status solve(const double* argument, Solution& solution) const;
  /// Factors g_z. Call it after solve().
  Status factor(Solution& solution) const;
  /// Computes dz / d (t | x | u | p). Call it after factor().
  void differentiate(Solution& solution) const;

 private:
  void find_dependencies();
  bool evaluate(Solution& solution) const;
  double size_of(const std::vector<double>& step, const Solution& solution) const;
  bool is_last(const Solution& solution) const;  // the step of each z converged

  Arguments sizes_;
  Function equations_;
  VectorXd start_, nominal_;
  bool affine_ = false;  // g is affine in z
  std::vector<std::vector<char>> depends_;
};

/// The DAE behind an eliminated problem, for integrators that treat z as unknowns.
struct AlgebraicPart {
  Function dynamics;                                    ///< f of (t | x z | u | p), nx outputs
  std::shared_ptr<const AlgebraicEquations> equations;  ///< empty for an ODE

  /// True if there are algebraic equations.
  explicit operator bool() const { return equations != nullptr; }
};

/// Turns a function of (t | x z | u | p) into one of (t | x | u | p), with the sparsity of the
/// composition. The result is NaN where z cannot be found.
Function eliminate(Function extended, std::shared_ptr<const AlgebraicEquations> equations);

/// z as a function of (t | x | u | p).
Function algebraic_states(std::shared_ptr<const AlgebraicEquations> equations);
/// z[entry] as a function of (t, x, u, p). Derivatives follow from the implicit function theorem.
Function algebraic_state(std::shared_ptr<const AlgebraicEquations> equations, int entry);

/// Algebraic states consistent with one argument (t | x | u | p).
struct ConsistentStart {
  AlgebraicEquations::Status status = AlgebraicEquations::Status::solved;  ///< outcome of the solve
  VectorXd z;           ///< the solution, or the last iterate
  VectorXd residual;    ///< g at z
  int equation = -1;    ///< the equation that fails, or -1
  std::string message;  ///< one sentence, including the distance of z from the given start

  /// True if consistent states were found.
  bool found() const { return status == AlgebraicEquations::Status::solved; }
};
/// Solves the equations at `argument`. Allocates. Throws DefinitionError if the size is wrong.
ConsistentStart consistent_start(const AlgebraicEquations& equations, const VectorRef& argument);

// Recovers the DAE behind an eliminated function, for integrators that treat the algebraic states
// as unknowns.

/// The function of (t | x z | u | p) and the equations from which eliminate() made `function`.
/// Empty for any other function.
AlgebraicPart dae_before_elimination(const Function& function);

}  // namespace saltus
