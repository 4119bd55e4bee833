// The vector and matrix types of user formulas and of the framework.
#pragma once

#include <type_traits>

// Replaces the text of Eigen's static assertions about sizes with readable sentences. This has no
// effect if Eigen was included earlier. If there is advice on a name x, SALTUS_ADVICE_x is a comma
// followed by the text.
/// \cond
#ifndef EIGEN_STATIC_ASSERT
#define SALTUS_WRONG_NUMBER_OF_ENTRIES                                                     \
  "a vector is given more or fewer entries than it has rows: Vec<S, n>{...} takes n; the " \
  "dynamics of a Phase<nx, nu> must return Vec<S, nx>, one row per state"
#define SALTUS_DIFFERENT_SIZES                                                                  \
  "vectors or matrices of different sizes are added, assigned or returned as one another; the " \
  "dynamics of a Phase<nx, nu> must return Vec<S, nx>, one row per state"
#define SALTUS_ADVICE_THIS_METHOD_IS_ONLY_FOR_VECTORS_OF_A_SPECIFIC_SIZE \
  , SALTUS_WRONG_NUMBER_OF_ENTRIES
#define SALTUS_ADVICE_FLOATING_POINT_ARGUMENT_PASSED__INTEGER_WAS_EXPECTED \
  , SALTUS_WRONG_NUMBER_OF_ENTRIES
#define SALTUS_ADVICE_YOU_MIXED_MATRICES_OF_DIFFERENT_SIZES , SALTUS_DIFFERENT_SIZES
#define SALTUS_ADVICE_YOU_MIXED_VECTORS_OF_DIFFERENT_SIZES , SALTUS_DIFFERENT_SIZES
#define SALTUS_SECOND_OF(first, second, ...) second
#define SALTUS_SECOND(...) SALTUS_SECOND_OF(__VA_ARGS__)
#define EIGEN_STATIC_ASSERT(condition, name) \
  static_assert(condition, SALTUS_SECOND(SALTUS_ADVICE_##name, #name, ));
#if !defined(EIGEN_PLAINOBJECTBASE_PLUGIN) && !defined(EIGEN_MATRIX_PLUGIN)
#define EIGEN_PLAINOBJECTBASE_PLUGIN "saltus/core/eigen_plain_object.hpp"
#define EIGEN_MATRIX_PLUGIN "saltus/core/eigen_plain_object.hpp"
#define SALTUS_INSIDE_PLAIN_OBJECT
#endif
#endif
#include <Eigen/Core>
#ifdef SALTUS_INSIDE_PLAIN_OBJECT
#undef SALTUS_INSIDE_PLAIN_OBJECT
#undef EIGEN_PLAINOBJECTBASE_PLUGIN
#undef EIGEN_MATRIX_PLUGIN
#endif
/// \endcond

// Eigen's default alignment, and so the layout of its types, depends on -march.
static_assert(
    EIGEN_MAX_ALIGN_BYTES == 16,
    "Saltus and all code that uses it must be built with EIGEN_MAX_ALIGN_BYTES=16: link to "
    "saltus::core in CMake, or pass -DEIGEN_MAX_ALIGN_BYTES=16");
#ifdef SALTUS_EIGEN_ALIGN_BYTES  // set by an installed library
static_assert(EIGEN_DEFAULT_ALIGN_BYTES == SALTUS_EIGEN_ALIGN_BYTES,
              "this installation of Saltus was built for another vector width, which changes the "
              "alignment of Eigen: let saltus::core set -march, or build Saltus with "
              "-D SALTUS_MARCH=... for your processor");
#endif

namespace saltus {

/// Column vector of n entries of scalar type S (double, a dual number, a sparsity tracer).
template <class S, int n>
using Vec = Eigen::Matrix<S, n, 1>;

/// Matrix of fixed size with entries of scalar type S.
template <class S, int rows, int cols>
using Mat = Eigen::Matrix<S, rows, cols>;

/// Column vector whose size is known at run time.
using VectorXd = Eigen::VectorXd;
/// Matrix whose size is known at run time.
using MatrixXd = Eigen::MatrixXd;
/// Read-only view of a vector. Contiguous arguments are not copied.
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
/// Writable view of a vector.
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

// A primal-dual point: the result of a solver and the input of a warm start.

/// Point of a program in variables w with rows J w (or g(w)). The Lagrangian is cost + lambda' rows
/// + z' w.
struct PrimalDualPoint {
  VectorXd w;       ///< variables
  VectorXd lambda;  ///< row multipliers, positive at an active upper side
  VectorXd z;       ///< bound multipliers, positive at the upper bound, negative at the lower
};

// The skew-symmetric matrix of a cross product. For the product of two vectors use Eigen's
// a.cross(b), which works with every scalar type.

/// Skew-symmetric matrix with skew(a) b = a x b.
template <class S>
Mat<S, 3, 3> skew(const Vec<S, 3>& a) {
  Mat<S, 3, 3> matrix;
  matrix << S(0.0), -a[2], a[1], a[2], S(0.0), -a[0], -a[1], a[0], S(0.0);
  return matrix;
}

}  // namespace saltus
