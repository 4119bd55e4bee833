// The jump between two phases: x+ = g(t, x-, p), where dimensions may change.
#pragma once

#include <string>
#include <utility>

#include "framework/model/make_function.hpp"

namespace saltus {

/// z = (t | x- | p) of the phase that ends -> x+ of the phase that begins. Without a function the
/// jump is the identity and the sizes must agree.
struct Jump {
  std::string name = "identity";
  Function map;
};

/// A jump from a phase with nx states and np parameters; `formula` is a callable of (t, x) that
/// returns the state with which the next phase begins.
template <int nx, int np = 0, class F>
Jump jump(std::string name, F formula) {
  return {std::move(name), make_function<nx, 0, np>(std::move(formula))};
}

}  // namespace saltus
