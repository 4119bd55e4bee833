// Phases, automata and jumps for Python, with the methods of C++ and sizes at run time.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core.hpp"
#include "saltus/core/error.hpp"
#include "saltus/model/algebraic.hpp"
#include "saltus/ocp/phase.hpp"
#include "saltus/ocp/problem.hpp"

namespace saltus::python {

using Rows = std::variant<Bounds, std::vector<Bounds>>;
inline std::vector<Bounds> list_of(const Rows& rows) {
  if (const Bounds* all = std::get_if<Bounds>(&rows)) return {*all};
  return std::get<std::vector<Bounds>>(rows);
}

using AnyGuess = std::variant<Guess, VectorXd>;
inline Guess guess_of(const AnyGuess& guess) {
  if (const Guess* given = std::get_if<Guess>(&guess)) return *given;
  return Guess::constant(std::get<VectorXd>(guess));
}

inline const char* const rule_of_guards =
    "a guard must return a scalar, which is zero at the event";
inline const char* const rule_of_resets =
    "a reset must return the state after the event, one row per state";

// Formulas of one phase or automaton, with the algebraic states eliminated.
struct Formulas {
  std::string where;  // "phase 'flight', "
  FormulaSizes sizes;
  AlgebraicPart algebraic = {};

  std::string place(const char* what, const std::string& name) const {
    return name.empty() ? where + what : fmt::format("{}{} '{}'", where, what, name);
  }
  Function extended(const char* what, const std::string& name, const py::object& formula) const {
    return function_of(formula, sizes, place(what, name));
  }
  Function erased(const char* what, const std::string& name, const py::object& formula,
                  int rows = -1, const char* rule = "") const {
    Function function = extended(what, name, formula);
    if (rows >= 0) require_rows(function, rows, place(what, name), rule);
    const Arguments plain{sizes.nx, sizes.nu, sizes.np};
    if (sizes.nz > 0 && function.inputs() != plain.size()) {
      check(function, {sizes.nx + sizes.nz, sizes.nu, sizes.np}, what, name);
      return eliminate(std::move(function), algebraic.equations);
    }
    check(function, plain, what, name);
    return function;
  }

 private:
  void check(const Function& function, const Arguments& arguments, const char* what,
             const std::string& name) const {
    detail::checked_function(function, arguments, {{}, place(what, name)});
  }
};

class Automaton {
 public:
  Automaton(int nx, int nu, int np, int nz, const py::object& equations,
            const std::optional<VectorXd>& guess)
      : formulas_{"", {nx, nu, np, nz}} {
    if (nz > 0 && guess)
      formulas_.algebraic.equations = std::make_shared<const AlgebraicEquations>(
          Arguments{nx, nu, np},
          formulas_.extended("the algebraic equations of", "an automaton", equations), *guess);
  }

  Automaton& mode(const std::string& name, const py::object& dynamics) {
    if (formulas_.sizes.nz > 0 && !formulas_.algebraic.dynamics)
      formulas_.algebraic.dynamics = formulas_.extended("mode", name, dynamics);
    system_.modes.push_back({name, formulas_.erased("mode", name, dynamics, formulas_.sizes.nx,
                                                    "the dynamics of a mode must return one row "
                                                    "per state")});
    return *this;
  }
  Automaton& event(const std::string& name, const std::string& from, const std::string& to,
                   const py::object& guard, Crossing direction, const py::object& reset) {
    Function crossing = formulas_.erased("the guard of event", name, guard, 1, rule_of_guards);
    Function map;
    if (!reset.is_none())
      map = formulas_.erased("the reset of event", name, reset, formulas_.sizes.nx, rule_of_resets);
    system_.add_transition(name, from, to, std::move(crossing), direction, std::move(map));
    return *this;
  }
  Automaton& surface(const std::string& name, const std::string& below, const std::string& above,
                     const py::object& guard) {
    const Function crossing =
        formulas_.erased("the guard of surface", name, guard, 1, rule_of_guards);
    system_.add_transition(name, below, above, crossing, Crossing::rising, {});
    system_.add_transition(name, above, below, crossing, Crossing::falling, {});
    return *this;
  }
  Automaton& store_mode_in(int i) {
    system_.memory = i;
    return *this;
  }

  const SwitchingSystem& system() const { return system_; }
  const Formulas& formulas() const { return formulas_; }

 private:
  Formulas formulas_;
  SwitchingSystem system_;
};

// A phase with its formulas. Methods have the names and defaults of saltus::Phase.
struct Phase {
  PhaseDefinition d;
  Formulas formulas;

  Phase(const std::string& name, const py::object& dynamics, const Bounds& duration, int nx, int nu,
        int np, int nz, const py::object& equations, const std::optional<VectorXd>& guess)
      : formulas{fmt::format("phase '{}', ", name), {nx, nu, np, nz}} {
    const char* rule = "the dynamics must return one row per state";
    const Arguments sizes{nx, nu, np};
    if (nz == 0) {
      begin(d, std::string(name), sizes, formulas.erased("the dynamics", "", dynamics, nx, rule),
            duration);
      return;
    }
    if (equations.is_none() || !guess)
      throw DefinitionError(formulas.where +
                            "with algebraic states it needs `equations` and `guess`");
    begin(d, std::string(name), sizes, {}, duration);
    Function field = formulas.extended("the dynamics", "", dynamics);
    require_rows(field, nx, formulas.place("the dynamics", ""), rule);
    Function zero = formulas.extended("the algebraic equations", "", equations);
    require_rows(zero, nz, formulas.place("the algebraic equations", ""),
                 "the algebraic equations must return one row per algebraic state");
    add_algebraic(d, std::move(field), std::move(zero), *guess);
    formulas.algebraic = d.algebraic;
  }
  Phase(const std::string& name, const Automaton& automaton, const Bounds& duration)
      : formulas(automaton.formulas()) {
    formulas.where = fmt::format("phase '{}', ", name);
    const FormulaSizes& sizes = formulas.sizes;
    if (automaton.system().modes.empty())
      throw DefinitionError(formulas.where + "its automaton has no mode");
    begin(d, std::string(name), {sizes.nx, sizes.nu, sizes.np},
          Function(automaton.system().modes.front().dynamics), duration);
    d.switching = automaton.system();
    d.algebraic = formulas.algebraic;
  }

  Function term(const std::string& name, const py::object& formula, int rows = -1,
                const char* rule = "") const {
    return formulas.erased("term", name, formula, rows, rule);
  }
  void constrain(Term::Domain domain, std::string name, const py::object& formula,
                 const Rows& bounds, Window window, std::optional<Penalty> penalty) {
    Function function = term(name, formula);
    add_constraint(d, std::move(name), domain, std::move(function), list_of(bounds),
                   std::move(window), std::move(penalty));
  }
  void minimise(Term::Domain domain, std::string name, const py::object& formula, Window window) {
    Function function = term(name, formula, 1,
                             "a cost must return a scalar; track() takes a vector and squares it");
    add_cost(d, std::move(name), domain, std::move(function), std::move(window));
  }
  void track(Term::Domain domain, std::string name, const py::object& residual,
             const Numbers& weights, Window window, Reference reference) {
    Function function = term(name, residual);
    const VectorXd all = vector_of(weights, function.outputs());
    add_least_squares(d, std::move(name), domain, std::move(function), all, std::move(window),
                      std::move(reference));
  }
};

// A jump whose sizes are those of the phase that it leaves.
struct PendingJump {
  std::string name;
  py::object formula;

  Jump after(const PhaseDefinition& phase) const {
    FormulaSizes sizes{phase.sizes.nx, 0, phase.sizes.np, 0};
    const std::string where = fmt::format("jump '{}'", name);
    if (py::isinstance<Function>(formula))
      sizes.np = formula.cast<Function>().inputs() - 1 - sizes.nx;
    Function map = function_of(formula, sizes, where);
    detail::checked_function(map, {sizes.nx, 0, sizes.np}, {{}, where});
    return {name, std::move(map), sizes.nx, sizes.np};
  }
};

}  // namespace saltus::python
