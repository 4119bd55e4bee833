// A phase as the user defines it: dynamics, terms, bounds and guesses, with sizes in the type.
#pragma once

#include <concepts>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "saltus/model/algebraic.hpp"
#include "saltus/model/automaton.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/model/named_parameters.hpp"
#include "saltus/model/switching_system.hpp"
#include "saltus/ocp/phase_definition.hpp"

namespace saltus {

// Short forms for state-triggered events inside a phase.

/// Makes the phase's dynamics active where guard < 0 and `above` where guard > 0. Throws
/// DefinitionError if the phase already has a surface, because the four regions would be ambiguous.
void add_surface(PhaseDefinition& phase, const std::string& event, Function guard, Function above);

/// Adds the jump x+ = reset(z) where the guard crosses zero, in all present and later modes of the
/// phase.
void add_reset(PhaseDefinition& phase, const std::string& event, Function guard, Crossing direction,
               Function reset);

/// One continuous mode with nx states, nu inputs and np parameters. Formulas are callables of (t,
/// x), (t, x, u) or (t, x, u, p), templates over the scalar. Their types are erased immediately.
/// Every method returns the phase, so calls can be chained.
///
/// With nz algebraic states z, every formula takes them after x: f(t, x, z), f(t, x, z, u) or f(t,
/// x, z, u, p), or f(t, x) alone.
///
/// Every method also takes a Function (saltus/model/function.hpp) in place of a formula, with the
/// argument (t | x | u | p), or (t | x z | u | p) if there are algebraic states.
template <int nx, int nu, int np = 0, int nz = 0>
class Phase {
 public:
  /// `dynamics` returns dx/dt with nx entries. `duration` is in seconds; exactly(T) fixes it.
  template <class Dynamics>
    requires(nz == 0)
  Phase(std::string name, Dynamics dynamics, Bounds duration) {
    static_assert(returns_rows<Dynamics, nx>,
                  "the dynamics of a Phase<nx, nu> must return Vec<S, nx>, one row per state");
    begin(d_, std::move(name), {nx, nu, np},
          make_function<nx, nu, np>(std::move(dynamics), {name, "the dynamics"}), duration);
  }
  /// A DAE of index 1: x' = dynamics(t, x, z, u, p), 0 = equations(t, x, z, u, p) with nz entries.
  /// If several z solve the equations, z is the one that Newton's method reaches from `guess`. The
  /// guess also sets the magnitude of z; see framework/design/dae.md.
  template <class Dynamics, class Equations>
    requires(nz > 0)
  Phase(std::string name, Dynamics dynamics, Equations equations, const Vec<double, nz>& guess,
        Bounds duration) {
    static_assert(returns_rows<Dynamics, nx>,
                  "the dynamics of a Phase<nx, nu> must return Vec<S, nx>, one row per state");
    static_assert(returns_rows<Equations, nz>,
                  "the algebraic equations must return Vec<S, nz>, one row per algebraic state");
    begin(d_, std::move(name), {nx, nu, np}, {}, duration);
    add_algebraic(d_, extended("the dynamics", {}, std::move(dynamics)),
                  extended("the algebraic equations", {}, std::move(equations)), guess);
  }
  /// Several modes with state-triggered events inside one phase. The mode at the start of each
  /// interval follows from the state (framework/design/events.md).
  Phase(std::string name, const Automaton<nx, nu, np, nz>& automaton, Bounds duration) {
    begin(d_, std::move(name), {nx, nu, np},
          make_function<nx, nu, np>(NoDynamics{}, {name, "the dynamics"}), duration);
    d_.switching = automaton.system();
    d_.algebraic = automaton.algebraic();
    if (!d_.switching.modes.empty()) d_.dynamics = d_.switching.modes.front().dynamics;
  }

  // --- events inside the phase -------------------------------------------------------------
  /// The phase's dynamics are active where the guard is negative, `above` where it is positive. If
  /// both fields point towards the surface, the state slides on it (Filippov).
  template <class Guard, class Field>
  Phase& switch_at(const std::string& event, Guard guard, Field above) {
    static_assert(returns_rows<Guard, 1>,
                  "a guard must return a scalar, which is zero at the event");
    static_assert(returns_rows<Field, nx>,
                  "the dynamics of switch_at() must return Vec<S, nx>, one row per state");
    Function function = erased("the guard of event", event, std::move(guard));
    add_surface(d_, event, std::move(function),
                erased("the dynamics above event", event, std::move(above)));
    return *this;
  }
  /// Resets the state to reset(t, x, ...) where the guard crosses zero. The phase continues.
  template <class Guard, class Reset>
  Phase& on(const std::string& event, Guard guard, Crossing crossing, Reset reset) {
    static_assert(returns_rows<Guard, 1>,
                  "a guard must return a scalar, which is zero at the event");
    static_assert(returns_rows<Reset, nx>,
                  "a reset must return the state after the event, Vec<S, nx>");
    Function function = erased("the guard of event", event, std::move(guard));
    add_reset(d_, event, std::move(function), crossing,
              erased("the reset of event", event, std::move(reset)));
    return *this;
  }

  // --- constraints -------------------------------------------------------------------------
  /// Bounds input i within a window.
  Phase& bound_input(int i, Bounds bounds, Window window = {}) {
    add_bounds(d_.input_bounds, i, bounds, std::move(window));
    return *this;
  }
  /// Bounds state i at the nodes within a window.
  Phase& bound_state(int i, Bounds bounds, Window window = {}) {
    add_bounds(d_.state_bounds, i, bounds, std::move(window));
    return *this;
  }
  /// Bounds input i softly: a violation is allowed and penalised.
  Phase& bound_input(int i, Bounds bounds, Window window, Penalty penalty) {
    add_soft_bounds(d_, "input", d_.sizes.u(), nu, i, bounds, std::move(window),
                    std::move(penalty));
    return *this;
  }
  /// Bounds state i softly: a violation is allowed and penalised.
  Phase& bound_state(int i, Bounds bounds, Window window, Penalty penalty) {
    add_soft_bounds(d_, "state", d_.sizes.x(), nx, i, bounds, std::move(window),
                    std::move(penalty));
    return *this;
  }
  /// Bounds algebraic state i at the nodes within a window, optionally as a soft constraint.
  Phase& bound_algebraic(int i, Bounds bounds, Window window = {},
                         std::optional<Penalty> penalty = std::nullopt)
    requires(nz > 0)
  {
    add_algebraic_bounds(d_, i, bounds, std::move(window), std::move(penalty));
    return *this;
  }
  /// Keeps the formula within bounds during the window. One Bounds applies to all rows.
  template <class F>
  Phase& keep(std::string name, F formula, Bounds bounds, Window window = {}) {
    add_constraint(d_, std::move(name), Term::Domain::running,
                   erased("term", name, std::move(formula)), {bounds}, std::move(window),
                   std::nullopt);
    return *this;
  }
  /// Same as above with one Bounds per row.
  template <class F>
  Phase& keep(std::string name, F formula, std::vector<Bounds> bounds, Window window = {}) {
    add_constraint(d_, std::move(name), Term::Domain::running,
                   erased("term", name, std::move(formula)), std::move(bounds), std::move(window),
                   std::nullopt);
    return *this;
  }
  /// Soft constraint: a violation is allowed and penalised at the nodes, per second
  /// (ocp/term.hpp). The solution reports the largest violation.
  template <class F>
  Phase& keep(std::string name, F formula, Bounds bounds, Window window, Penalty penalty) {
    add_constraint(d_, std::move(name), Term::Domain::running,
                   erased("term", name, std::move(formula)), {bounds}, std::move(window),
                   std::move(penalty));
    return *this;
  }
  /// Same as above with one Bounds per row.
  template <class F>
  Phase& keep(std::string name, F formula, std::vector<Bounds> bounds, Window window,
              Penalty penalty) {
    add_constraint(d_, std::move(name), Term::Domain::running,
                   erased("term", name, std::move(formula)), std::move(bounds), std::move(window),
                   std::move(penalty));
    return *this;
  }
  /// Sets tolerances of the path constraint `term` in its units. solve() reports a grid as too
  /// coarse if a plan violates the term by more than `between_nodes` between the nodes. `at_nodes`
  /// is the tolerance at the nodes (0: the default, GridAccuracy::rows). The term is the name given
  /// to keep(), or "bounds of state 0".
  Phase& allow(std::string term, double between_nodes, double at_nodes = 0.0) {
    add_allowance(d_, std::move(term), between_nodes, at_nodes);
    return *this;
  }
  /// Constraint at the end of the phase (before the jump). If soft, a violation is charged once.
  template <class F>
  Phase& reach(std::string name, F formula, Bounds bounds,
               std::optional<Penalty> penalty = std::nullopt) {
    add_constraint(d_, std::move(name), Term::Domain::phase_end,
                   erased("term", name, std::move(formula)), {bounds}, {}, std::move(penalty));
    return *this;
  }
  /// Same as above with one Bounds per row.
  template <class F>
  Phase& reach(std::string name, F formula, std::vector<Bounds> bounds,
               std::optional<Penalty> penalty = std::nullopt) {
    add_constraint(d_, std::move(name), Term::Domain::phase_end,
                   erased("term", name, std::move(formula)), std::move(bounds), {},
                   std::move(penalty));
    return *this;
  }
  /// Constraint at the start of the phase (after the jump).
  template <class F>
  Phase& begin_with(std::string name, F formula, Bounds bounds,
                    std::optional<Penalty> penalty = std::nullopt) {
    return begin_with(std::move(name), std::move(formula), std::vector<Bounds>{bounds},
                      std::move(penalty));
  }
  /// Same as above with one Bounds per row.
  template <class F>
  Phase& begin_with(std::string name, F formula, std::vector<Bounds> bounds,
                    std::optional<Penalty> penalty = std::nullopt) {
    add_constraint(d_, std::move(name), Term::Domain::phase_start,
                   erased("term", name, std::move(formula)), std::move(bounds), {},
                   std::move(penalty));
    return *this;
  }
  /// Limits the integral of the scalar formula, evaluated at the end of the phase. The same name in
  /// several phases is one integral that continues from phase to phase. Each phase limits the value
  /// accumulated up to its end. `magnitude` scales it.
  template <class F>
  Phase& bound_integral(std::string name, F formula, Limits limits, double magnitude = 1.0) {
    static_assert(returns_rows<F, 1>, "the formula of bound_integral() must return a scalar");
    add_integral(d_, std::move(name), erased("integral", name, std::move(formula)),
                 std::move(limits), magnitude);
    return *this;
  }

  /// Ends the phase where the guard crosses zero in the given direction. The guard is a scalar of
  /// (t, x) and may read parameters. This is a terminal constraint guard = 0 that determines the
  /// free duration.
  template <class F>
  Phase& ends_when(std::string event, F guard, Crossing crossing) {
    static_assert(returns_rows<F, 1>, "a guard must return a scalar, which is zero at the event");
    add_end_guard(d_, std::move(event), erased("the guard of event", event, std::move(guard)),
                  crossing);
    return *this;
  }

  // --- costs -------------------------------------------------------------------------------
  /// Adds the integral of the scalar formula over the window to the cost. With
  /// costs(CostRule::nodes) (saltus/ocp/problem.hpp) it is a sum at the nodes instead.
  template <class F>
  Phase& minimise(std::string name, F formula, Window window = {}) {
    static_assert(returns_rows<F, 1>,
                  "a cost must return a scalar; track() takes a vector and squares it");
    add_cost(d_, std::move(name), Term::Domain::running, erased("term", name, std::move(formula)),
             std::move(window));
    return *this;
  }
  /// Adds the scalar formula at the end of the phase to the cost.
  template <class F>
  Phase& minimise_at_end(std::string name, F formula) {
    static_assert(returns_rows<F, 1>,
                  "a cost must return a scalar; track_at_end() takes a vector and squares it");
    add_cost(d_, std::move(name), Term::Domain::phase_end, erased("term", name, std::move(formula)),
             {});
    return *this;
  }
  /// Adds the scalar formula at the start of the phase (after the jump) to the cost.
  template <class F>
  Phase& minimise_at_start(std::string name, F formula) {
    static_assert(returns_rows<F, 1>,
                  "a cost must return a scalar; track_at_start() takes a vector and squares it");
    add_cost(d_, std::move(name), Term::Domain::phase_start,
             erased("term", name, std::move(formula)), {});
    return *this;
  }
  /// Adds the integral of 1/2 |residual - reference|^2_W over the window, W = diag(weights).
  /// CostRule applies as in minimise().
  template <class F>
  Phase& track(std::string name, F residual, const VectorXd& weights, Window window = {},
               Reference reference = {}) {
    add_least_squares(d_, std::move(name), Term::Domain::running,
                      erased("term", name, std::move(residual)), weights, std::move(window),
                      std::move(reference));
    return *this;
  }
  /// Adds 1/2 |residual - reference|^2_W at the end of the phase.
  template <class F>
  Phase& track_at_end(std::string name, F residual, const VectorXd& weights,
                      Reference reference = {}) {
    add_least_squares(d_, std::move(name), Term::Domain::phase_end,
                      erased("term", name, std::move(residual)), weights, {}, std::move(reference));
    return *this;
  }
  /// Adds 1/2 |residual - reference|^2_W at the start of the phase (after the jump).
  template <class F>
  Phase& track_at_start(std::string name, F residual, const VectorXd& weights,
                        Reference reference = {}) {
    add_least_squares(d_, std::move(name), Term::Domain::phase_start,
                      erased("term", name, std::move(residual)), weights, {}, std::move(reference));
    return *this;
  }
  /// Adds 1/2 |u_k - u_(k-1)|^2_W between neighbouring intervals. The first interval is compared
  /// with the input applied before the horizon. Each change is weighted by the nominal length
  /// divided by the mean length of the two intervals. It is a sum over changes with either
  /// CostRule. Inputs fixed by their bounds are not charged.
  Phase& penalise_change(const VectorXd& weights) {
    d_.input_change_weight = weights;
    return *this;
  }

  // --- inputs, parameters, scaling, guesses --------------------------------------------------
  /// Shape of the inputs over an interval: piecewise_constant (default), piecewise_linear or
  /// piecewise_linear_continuous. Phases with linear inputs integrate their running costs with
  /// either CostRule.
  Phase& inputs(InputParametrisation parametrisation) {
    d_.input_parametrisation = parametrisation;
    return *this;
  }
  /// Declares that groups of inputs act on the state only through a common resultant, like wrenches
  /// of several contacts. Group i consists of inputs i to i + size - 1, for each i of `firsts`. Any
  /// group could replace any other. Costs and rows of different groups are separate. Solvers may
  /// exploit this.
  Phase& common_resultant(std::vector<int> firsts, int size) {
    d_.resultants = std::move(firsts);
    d_.resultant_size = size;
    return *this;
  }
  /// Adds a block of data to p, in order of declaration. Its value is set before each solve. The
  /// same name in several phases is the same data.
  Phase& data(std::string name, const VectorXd& value) {
    add_parameter(d_, std::move(name), value, {});
    return *this;
  }
  /// Adds a block of data with a name for every entry (saltus/model/named_parameters.hpp).
  template <NamedParameters Block>
  Phase& data(std::string name, const Block& value) {
    add_parameter(d_, std::move(name), packed(value), entries_of<Block>());
    return *this;
  }
  /// Adds a parameter that the solver determines. The same name in several phases is the same
  /// unknown, within the bounds of all of them and with the guess of the last. `magnitude` scales
  /// its entries.
  Phase& unknown(std::string name, const VectorXd& guess, Bounds bounds, double magnitude = 1.0) {
    add_parameter(d_, std::move(name), guess, {});
    make_unknown(d_, bounds, magnitude);
    return *this;
  }
  /// Adds a block of unknowns with the same bounds for every entry.
  template <NamedParameters Block>
  Phase& unknown(std::string name, const Block& guess, Bounds bounds, double magnitude = 1.0) {
    data(std::move(name), guess);
    make_unknown(d_, bounds, magnitude);
    return *this;
  }
  /// Magnitudes that scale variables and defects, all positive. A magnitude of 1 counts as
  /// declared.
  Phase& nominal(const VectorXd& state, const VectorXd& input) {
    d_.nominal_state = state;
    d_.nominal_input = input;
    d_.has_nominal = true;
    return *this;
  }
  /// Magnitude of a free duration in seconds, positive.
  Phase& nominal_duration(double seconds) {
    d_.nominal_duration = seconds;
    d_.has_nominal_duration = true;
    return *this;
  }
  /// Initial guess of the states.
  Phase& guess_state(Guess guess) {
    d_.state_guess = std::move(guess);
    return *this;
  }
  /// Initial guess of the inputs.
  Phase& guess_input(Guess guess) {
    d_.input_guess = std::move(guess);
    return *this;
  }
  /// Initial guess of a free duration, s.
  Phase& guess_duration(double seconds) {
    d_.duration_guess = seconds;
    return *this;
  }

  /// The definition with all declarations so far.
  const PhaseDefinition& definition() const { return d_; }

 private:
  struct NoDynamics {
    template <class S>
    Vec<S, nx> operator()(const S&, const Vec<S, nx>&) const {
      return Vec<S, nx>::Zero();
    }
  };
  template <class F, int rows>
  static constexpr bool returns_rows = ReturnsRows<
      std::conditional_t<nz == 0 || std::same_as<F, Function>, F, FormulaWithAlgebraic<nx, nz, F>>,
      rows, nx + nz, nu, np>;
  // Functions that take name and formula take the name by reference, so it is still valid here.
  template <class F>
  Function erased(const char* what, const std::string& name, F formula) {
    if constexpr (nz == 0) {
      return make_function<nx, nu, np>(std::move(formula), {d_.name, what, name});
    } else {
      if constexpr (std::same_as<F, Function>)
        if (formula && formula.inputs() == Arguments{nx, nu, np}.size())
          return make_function<nx, nu, np>(std::move(formula), {d_.name, what, name});
      return eliminate(extended(what, name, std::move(formula)), d_.algebraic.equations);
    }
  }
  // The formula as a function of (t | x z | u | p).
  template <class F>
  Function extended(const char* what, const std::string& name, F formula) {
    if constexpr (std::same_as<F, Function>)
      return make_function<nx + nz, nu, np>(std::move(formula), {d_.name, what, name});
    else
      return make_function<nx + nz, nu, np>(FormulaWithAlgebraic<nx, nz, F>{std::move(formula)},
                                            {d_.name, what, name});
  }

  PhaseDefinition d_;
};

}  // namespace saltus
