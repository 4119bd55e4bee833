// Algebraic equations beside the dynamics, of index 1: x' = f(t, x, z, u, p), 0 = g(t, x, z, u, p)
// with g_z regular. z is eliminated: a function of (t, x, z, u, p) becomes one of (t, x, u, p) with
// exact derivatives, so that whatever takes dynamics, terms and guards takes them here too.
// framework/design/dae.md derives this and states its limits.
//
// Functions that read z take it behind x, as if it were a part of the state: (t | x z | u | p).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/core/dense_lu.hpp"
#include "saltus/core/types.hpp"
#include "saltus/model/arguments.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

/// How an iteration for algebraic states ended.
enum class AlgebraicStatus {
  solved,
  not_finite,   ///< an equation is infinite or NaN
  singular,     ///< an equation does not determine z beside the others: the index is above 1
  no_solution,  ///< Newton's method ends where the equations are not met
};

/// z at one argument, and what derivatives of it need. Made by AlgebraicEquations::new_solution().
struct AlgebraicSolution {
  /// Sized for so many equations, arguments and entries of their Jacobian; nothing is allocated
  /// afterwards.
  AlgebraicSolution(int equations, int arguments, int entries);

  std::vector<double> argument;  ///< (t | x z | u | p)
  std::vector<double> entries;   ///< of the Jacobian of g there
  DenseLu slope;                 ///< factors of g_z, after AlgebraicEquations::factor()
  std::vector<double> direct;    ///< dz / d (t | x | u | p), by rows, after differentiate()
  int equation = -1;             ///< that failed

  // For Newton's method, and for what is composed with it.
  std::vector<double> residual, step, next_step, before;  ///< one number per equation
  std::vector<double> largest;                            ///< |z| so far
};

/// 0 = g(t, x, z, u, p), an equation for each entry of z. z is the solution that Newton's method,
/// damped, reaches from a given start: a function of (t, x, u, p) alone, whatever was asked before.
class AlgebraicEquations {
 public:
  /// `sizes` are those of (t | x | u | p). The entries of `start` also are the magnitudes of z, 1
  /// where they are zero. Throws DefinitionError, naming the equation, where the sizes do not fit
  /// or g_z is singular whatever its numbers: the index is above 1.
  AlgebraicEquations(const Arguments& sizes, Function equations, VectorXd start);

  /// How many equations, as many as algebraic states.
  int count() const { return static_cast<int>(start_.size()); }
  /// Of the formulas that read them: t, x, u, p.
  const Arguments& sizes() const { return sizes_; }
  /// The same with the algebraic states behind x.
  Arguments extended() const { return {sizes_.nx + count(), sizes_.nu, sizes_.np}; }
  /// g(t, (x, z), u, p), 0 where z is right.
  const Function& equations() const { return equations_; }
  /// Where the first iteration begins.
  const VectorXd& start() const { return start_; }
  /// Whether entry j of z can change with an entry of (t | x | u | p), differentiated.
  bool depends(int j, int argument) const { return depends_[j][argument] != 0; }

  /// Memory for a solution; solve(), factor() and differentiate() then allocate nothing.
  AlgebraicSolution new_solution() const {
    return {count(), extended().size(), equations_.jacobian_pattern().entries()};
  }
  /// The same equations with a separate() function; these if the function needs no memory, null if
  /// it cannot be separated.
  static std::shared_ptr<const AlgebraicEquations> separate(
      const std::shared_ptr<const AlgebraicEquations>& equations);
  /// z at (t | x | u | p), to rounding.
  AlgebraicStatus solve(const double* argument, AlgebraicSolution& solution) const;
  /// Behind solve(): the factors of g_z.
  AlgebraicStatus factor(AlgebraicSolution& solution) const;
  /// Behind factor(): dz / d (t | x | u | p).
  void differentiate(AlgebraicSolution& solution) const;

 private:
  void find_dependencies();
  bool evaluate(AlgebraicSolution& solution) const;
  double size_of(const std::vector<double>& step, const AlgebraicSolution& solution) const;
  bool is_last(const AlgebraicSolution& solution) const;  // its step, as each z goes

  Arguments sizes_;
  Function equations_;
  VectorXd start_, nominal_;
  bool affine_ = false;  // in z
  std::vector<std::vector<char>> depends_;
};

/// What integrators may take in place of the dynamics from which z is eliminated.
struct AlgebraicPart {
  Function dynamics;                                    ///< f of (t | x z | u | p), nx outputs
  std::shared_ptr<const AlgebraicEquations> equations;  ///< empty if there are none

  /// Whether there are any.
  explicit operator bool() const { return equations != nullptr; }
};

/// A function of (t | x z | u | p) as one of (t | x | u | p), its sparsity that of the composition.
/// NaN where z cannot be found.
Function eliminate(Function extended, std::shared_ptr<const AlgebraicEquations> equations);

/// z itself, or one entry of it, as a function of (t | x | u | p).
Function algebraic_states(std::shared_ptr<const AlgebraicEquations> equations);
/// z[entry] as a function of (t, x, u, p), derivatives by the implicit function theorem.
Function algebraic_state(std::shared_ptr<const AlgebraicEquations> equations, int entry);

/// What was found at one argument (t | x | u | p).
struct ConsistentStart {
  AlgebraicStatus status = AlgebraicStatus::solved;  ///< how the search ended
  VectorXd z;                                        ///< the best that was found
  VectorXd residual;                                 ///< g there
  int equation = -1;                                 ///< the one that fails; -1: none
  std::string message;  ///< a sentence, also on how far z is from the start that was given

  /// Whether states were found that fit.
  bool found() const { return status == AlgebraicStatus::solved; }
};
/// Allocates.
ConsistentStart consistent_start(const AlgebraicEquations& equations, const VectorRef& argument);

}  // namespace saltus
