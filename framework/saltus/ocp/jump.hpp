// The jump between two phases: x+ = g(t, x-, p), where dimensions may change. The same from the end
// of the last phase to the start of the first one closes the problem (close()).
#pragma once

#include <string>
#include <utility>

#include "saltus/model/make_function.hpp"

namespace saltus {

/// z = (t | x- | p) of the phase that ends -> x+ of the phase that begins. Without a function the
/// jump is the identity and the sizes must agree.
struct Jump {
  std::string name = "identity";  ///< for messages
  Function map;                   ///< of (t, x, p) before the event; empty: the state goes on
  int nx = 0, np = 0;  ///< states and parameters that the map takes; np = 0: it reads none

  /// The argument z of the map; p may be longer than what the map takes.
  VectorXd argument(double t, const VectorXd& x, const VectorXd& p) const {
    VectorXd z(map.inputs());
    z[0] = t;
    z.segment(1, x.size()) = x;
    z.tail(z.size() - 1 - x.size()) = p.head(z.size() - 1 - x.size());
    return z;
  }
  /// x+
  VectorXd apply(double t, const VectorXd& x, const VectorXd& p) const {
    return map ? map(argument(t, x, p)) : x;
  }
};

/// A jump from a phase with nx states and np parameters; `formula` is a callable of (t, x), or with
/// parameters of (t, x, no input, p), that returns the state with which the next phase begins.
template <int nx, int np = 0, class F>
Jump jump(std::string name, F formula) {
  Function map = make_function<nx, 0, np>(std::move(formula), {{}, "jump", name});
  return {std::move(name), std::move(map), nx, np};
}

}  // namespace saltus
