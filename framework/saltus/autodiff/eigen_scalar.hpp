// Lets Eigen vectors and matrices hold active scalars and mix with matrices of doubles.
#pragma once

#include "saltus/autodiff/scalar.hpp"
#include "saltus/core/types.hpp"

// types.hpp must precede all other Eigen headers.
// Formulas may contain cross products and inverses. All of <Eigen/Geometry> takes a twentieth of
// the time to compile a first program; include it for rotations.
#include <Eigen/LU>
#if EIGEN_VERSION_AT_LEAST(3, 4, 90)
#include <Eigen/Geometry>
#else
#include <Eigen/src/Geometry/OrthoMethods.h>
#endif

namespace Eigen {

template <saltus::ActiveScalar S>
struct NumTraits<S> : NumTraits<double> {
  using Real = S;
  using NonInteger = S;
  using Nested = S;
  using Literal = double;  // `2.0 * v` multiplies by a double, not by a dual constant
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = !std::is_trivially_default_constructible_v<S>,
    ReadCost = 1,
    AddCost = 1,
    MulCost = 1
  };
};

template <saltus::ActiveScalar S, class Operation>
struct ScalarBinaryOpTraits<S, double, Operation> {
  using ReturnType = S;
};
template <saltus::ActiveScalar S, class Operation>
struct ScalarBinaryOpTraits<double, S, Operation> {
  using ReturnType = S;
};

namespace internal {

// Computes products coefficient by coefficient for every size. For 8 rows or more, Eigen would use
// its numerical kernels, which compare scalars, convert one factor or allocate.
template <class Lhs, class Rhs>
  requires(saltus::ActiveScalar<typename traits<typename remove_all<Lhs>::type>::Scalar> ||
           saltus::ActiveScalar<typename traits<typename remove_all<Rhs>::type>::Scalar>)
struct product_type<Lhs, Rhs> {
  enum {
    rows = int(traits<typename remove_all<Lhs>::type>::RowsAtCompileTime) == 1 ? 1 : int(Small),
    depth = int(traits<typename remove_all<Lhs>::type>::ColsAtCompileTime) == 1 ? 1 : int(Small),
    cols = int(traits<typename remove_all<Rhs>::type>::ColsAtCompileTime) == 1 ? 1 : int(Small),
    ret = product_type_selector<rows, cols, depth>::ret,
    value = ret
  };
};

}  // namespace internal
}  // namespace Eigen
