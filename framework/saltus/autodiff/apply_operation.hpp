// The elementary operations of recorded formulas, for numbers, dual numbers and tracers.
#pragma once

#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/autodiff/math.hpp"
#include "saltus/autodiff/tracer.hpp"

namespace saltus::detail {

/// Result of the operation. Inputs and constants are no operations: 0.
template <class S>
S apply(Operation operation, const S& a, const S& b, const S& c) {
  switch (operation) {
    case Operation::input:
    case Operation::constant:
      break;
    case Operation::add:
      return a + b;
    case Operation::subtract:
      return a - b;
    case Operation::multiply:
      return a * b;
    case Operation::divide:
      return a / b;
    case Operation::negate:
      return -a;
    case Operation::sin:
      return sin(a);
    case Operation::cos:
      return cos(a);
    case Operation::tan:
      return tan(a);
    case Operation::asin:
      return asin(a);
    case Operation::acos:
      return acos(a);
    case Operation::atan:
      return atan(a);
    case Operation::sinh:
      return sinh(a);
    case Operation::cosh:
      return cosh(a);
    case Operation::tanh:
      return tanh(a);
    case Operation::exp:
      return exp(a);
    case Operation::log:
      return log(a);
    case Operation::sqrt:
      return sqrt(a);
    case Operation::abs:
      return abs(a);
    case Operation::min:
      return min(a, b);
    case Operation::max:
      return max(a, b);
    case Operation::atan2:
      return atan2(a, b);
    case Operation::hypot:
      return hypot(a, b);
    case Operation::pow:
      return pow(a, b);
    case Operation::select:
      return select(a, b, c);
  }
  return S(0.0);
}

}  // namespace saltus::detail
