// A link: a constraint or a cost that couples ends of phases through their states, times, durations
// and parameters.
#pragma once

#include <concepts>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "saltus/model/make_function.hpp"
#include "saltus/ocp/phase.hpp"
#include "saltus/ocp/term.hpp"

namespace saltus {

// The jump between two phases: x+ = g(t, x-, p). The dimension may change. A jump from the last
// phase to the first one makes the problem periodic (close()).

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

/// Values at one end of a phase, as the formula of a link receives them.
template <class S, int nx, int np>
struct EndValues {
  S t;           ///< absolute time, s
  S duration;    ///< duration of the phase, s
  Vec<S, nx> x;  ///< state at that end
  Vec<S, np> p;  ///< parameters of that phase
};

/// The start of a phase (after the jump) or its end (before the next jump).
template <int nx, int np>
struct PhaseEnd {
  std::string phase;   ///< name of the phase, unique in the problem
  bool is_end = true;  ///< true: end of the phase, false: start
};
/// The start of a phase.
template <int nx, int nu, int np, int nz>
PhaseEnd<nx, np> start_of(const Phase<nx, nu, np, nz>& phase) {
  return {phase.definition().name, false};
}
/// The end of a phase.
template <int nx, int nu, int np, int nz>
PhaseEnd<nx, np> end_of(const Phase<nx, nu, np, nz>& phase) {
  return {phase.definition().name, true};
}

/// A link after type erasure.
struct Link {
  /// One end of a phase, with sizes at run time.
  struct End {
    std::string phase;   ///< name of the phase
    bool is_end = true;  ///< true: end of the phase, false: start
    int nx = 0, np = 0;  ///< states and parameters

    /// Number of values that the link reads there: time, duration, x, p.
    int size() const { return 2 + nx + np; }
  };
  std::string name;       ///< name for messages
  std::vector<End> ends;  ///< the ends whose values the function reads, in this order
  Function function;      ///< z = (nothing | t duration x p of the first end | of the second | ...)
  Limits limits;          ///< limits of the function's rows
  bool is_cost = false;   ///< true: the function is a scalar that is added to the cost
};

namespace detail {

template <int... sizes>
inline constexpr int sum_of = (0 + ... + sizes);

// Splits x = (t duration x p | ...) into the arguments of the formula.
template <class F, int... nx>
struct Joined {
  template <int... np>
  struct With {
    F formula;

    template <class S>
    auto operator()(const S&, const Vec<S, sum_of<(2 + nx + np)...>>& all) const {
      int next = 0;
      // Brace initialisation reads the ends in order.
      const std::tuple<EndValues<S, nx, np>...> ends{read<S, nx, np>(all, next)...};
      if constexpr (std::is_invocable_v<const F&, const EndValues<S, nx, np>&...>) {
        return std::apply(formula, ends);
      } else {
        static_assert(std::is_invocable_v<const F&, const EndValues<S, nx, np>&...>,
                      "the formula of a link must be callable through a const operator() with one "
                      "EndValues per end, in the order of the ends: f(const auto& a, const auto& "
                      "b), which may read a.t, a.duration, a.x and a.p");
        return all[0];
      }
    }
    template <class S, int n, int m, class All>
    static EndValues<S, n, m> read(const All& all, int& next) {
      EndValues<S, n, m> end;
      end.t = all[next++];
      end.duration = all[next++];
      for (int i = 0; i < n; ++i) end.x[i] = all[next++];
      for (int i = 0; i < m; ++i) end.p[i] = all[next++];
      return end;
    }
  };
};

}  // namespace detail

/// `formula` takes one EndValues per end, in order, and returns a scalar or a vector. It may also
/// be a Function with the argument of Link::function.
template <class F, int... nx, int... np>
Link make_link(std::string name, F formula, Limits limits, PhaseEnd<nx, np>... ends) {
  Function function = [&] {
    constexpr int values = detail::sum_of<(2 + nx + np)...>;
    const FormulaName what{{}, "link", name};
    if constexpr (std::same_as<F, Function>) {
      return make_function<values, 0, 0>(std::move(formula), what);
    } else {
      using Formula = typename detail::Joined<F, nx...>::template With<np...>;
      return make_function<values, 0, 0>(Formula{std::move(formula)}, what);
    }
  }();
  return {std::move(name),
          {Link::End{std::move(ends.phase), ends.is_end, nx, np}...},
          std::move(function),
          std::move(limits),
          false};
}

}  // namespace saltus
