// A hybrid automaton as the user writes it: named modes and events between them.
#pragma once

#include <concepts>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/model/algebraic.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/model/switching_system.hpp"

namespace saltus {

/// Modes and events with nx states, nu inputs and np parameters. Formulas are callables of (t, x),
/// (t, x, u) or (t, x, u, p). Dynamics return dx/dt, a guard returns a scalar, a reset returns the
/// state after the event. Declare modes before the events that use them.
///
/// All modes share the equations of the nz algebraic states z. Formulas then take z after x: f(t,
/// x, z), f(t, x, z, u) or f(t, x, z, u, p), or f(t, x) alone. Like Phase, it also takes a Function
/// in place of a formula.
template <int nx, int nu = 0, int np = 0, int nz = 0>
class Automaton {
 public:
  Automaton()
    requires(nz == 0)
  = default;
  /// 0 = equations(t, x, z, u, p) with nz entries and index 1. `guess` starts the iteration for z
  /// and sets its magnitudes. Throws DefinitionError with the equation, as AlgebraicEquations does.
  template <class Equations>
  Automaton(Equations equations, const Vec<double, nz>& guess)
    requires(nz > 0)
  {
    static_assert(returns_rows<Equations, nz>,
                  "the algebraic equations must return Vec<S, nz>, one row per algebraic state");
    algebraic_.equations = std::make_shared<const AlgebraicEquations>(
        Arguments{nx, nu, np},
        extended("the algebraic equations of", "an automaton", std::move(equations)), guess);
  }

  /// Adds a mode with its dynamics.
  template <class Dynamics>
  Automaton& mode(std::string name, Dynamics dynamics) {
    static_assert(returns_rows<Dynamics, nx>,
                  "the dynamics of a mode must return Vec<S, nx>, one row per state");
    if constexpr (nz > 0)
      if (!algebraic_.dynamics) algebraic_.dynamics = extended("mode", name, dynamics);
    Function function = erased("mode", name, std::move(dynamics));
    system_.modes.push_back({std::move(name), std::move(function)});
    return *this;
  }
  /// Adds an event between two modes without a state jump.
  template <class Guard>
  Automaton& event(std::string name, const std::string& from, const std::string& to, Guard guard,
                   Crossing direction) {
    static_assert(returns_rows<Guard, 1>,
                  "a guard must return a scalar, which is zero at the event");
    Function function = erased("the guard of event", name, std::move(guard));
    return add(std::move(name), from, to, std::move(function), direction, {});
  }
  /// Adds an event with the state jump x+ = reset(t, x-, ...).
  template <class Guard, class Reset>
  Automaton& event(std::string name, const std::string& from, const std::string& to, Guard guard,
                   Crossing direction, Reset reset) {
    static_assert(returns_rows<Guard, 1>,
                  "a guard must return a scalar, which is zero at the event");
    static_assert(returns_rows<Reset, nx>,
                  "a reset must return the state after the event, Vec<S, nx>");
    Function function = erased("the guard of event", name, std::move(guard));
    Function map = erased("the reset of event", name, std::move(reset));
    return add(std::move(name), from, to, std::move(function), direction, std::move(map));
  }
  /// Adds a switching surface: `below` is active where guard < 0, `above` where guard > 0. The
  /// trajectory crosses the surface, or slides on it if both fields point towards it (Filippov).
  template <class Guard>
  Automaton& surface(const std::string& name, const std::string& below, const std::string& above,
                     Guard guard) {
    static_assert(returns_rows<Guard, 1>,
                  "a guard must return a scalar, which is zero at the event");
    const Function function = erased("the guard of surface", name, std::move(guard));
    add(name, below, above, function, Crossing::rising, {});
    return add(name, above, below, function, Crossing::falling, {});
  }

  /// Declares hysteresis: the mode does not follow from the state and is stored in state i. State i
  /// holds the index of the mode in order of declaration, from 0. Its start value is given as for
  /// any other state. Every formula returns the rate 0 for it. It changes at events that change the
  /// mode.
  Automaton& store_mode_in(int i) {
    system_.memory = i;
    return *this;
  }
  /// Deprecated name.
  [[deprecated("use store_mode_in; removed in 0.4")]] Automaton& remember_in(int i) {
    return store_mode_in(i);
  }

  /// The modes and events declared so far.
  const SwitchingSystem& system() const { return system_; }
  /// The algebraic equations with the dynamics of the first mode. Empty if there are none.
  const AlgebraicPart& algebraic() const { return algebraic_; }

 private:
  template <class F, int rows>
  static constexpr bool returns_rows = ReturnsRows<
      std::conditional_t<nz == 0 || std::same_as<F, Function>, F, FormulaWithAlgebraic<nx, nz, F>>,
      rows, nx + nz, nu, np>;
  template <class F>
  Function erased(const char* what, const std::string& name, F formula) const {
    if constexpr (nz == 0) {
      return make_function<nx, nu, np>(std::move(formula), {{}, what, name});
    } else {
      if constexpr (std::same_as<F, Function>)
        if (formula && formula.inputs() == Arguments{nx, nu, np}.size())
          return make_function<nx, nu, np>(std::move(formula), {{}, what, name});
      return eliminate(extended(what, name, std::move(formula)), algebraic_.equations);
    }
  }
  // The formula as a function of (t | x z | u | p).
  template <class F>
  static Function extended(const char* what, const std::string& name, F formula) {
    if constexpr (std::same_as<F, Function>)
      return make_function<nx + nz, nu, np>(std::move(formula), {{}, what, name});
    else
      return make_function<nx + nz, nu, np>(FormulaWithAlgebraic<nx, nz, F>{std::move(formula)},
                                            {{}, what, name});
  }
  Automaton& add(const std::string& name, const std::string& from, const std::string& to,
                 Function guard, Crossing direction, Function reset) {
    system_.add_transition(name, from, to, std::move(guard), direction, std::move(reset));
    return *this;
  }

  SwitchingSystem system_;
  AlgebraicPart algebraic_;
};

}  // namespace saltus
