// The jump between two phases: x+ = g(t, x-, p). The dimension may change. A jump from the last
// phase to the first one makes the problem periodic (close()).
#pragma once

#include <string>
#include <utility>

#include "saltus/model/make_function.hpp"

namespace saltus {

/// Maps z = (t | x- | p) of the ending phase to x+ of the next phase. Without a function, the jump
/// is the identity and the state sizes must agree.
struct Jump {
  std::string name = "identity";  ///< name for messages
  Function map;                   ///< function of (t, x, p) before the event; empty: identity
  int nx = 0, np = 0;             ///< sizes that the map takes; np = 0: no parameters

  /// The argument z of the map. p may be longer than the map needs.
  VectorXd argument(double t, const VectorXd& x, const VectorXd& p) const {
    VectorXd z(map.inputs());
    z[0] = t;
    z.segment(1, x.size()) = x;
    z.tail(z.size() - 1 - x.size()) = p.head(z.size() - 1 - x.size());
    return z;
  }
  /// Returns x+.
  VectorXd apply(double t, const VectorXd& x, const VectorXd& p) const {
    return map ? map(argument(t, x, p)) : x;
  }
};

/// A jump from a phase with nx states and np parameters. `formula` is a callable of (t, x) or (t,
/// x, u, p) with an empty u. It returns the first state of the next phase.
template <int nx, int np = 0, class F>
Jump jump(std::string name, F formula) {
  Function map = make_function<nx, 0, np>(std::move(formula), {{}, "jump", name});
  return {std::move(name), std::move(map), nx, np};
}

}  // namespace saltus
