// What the parts of the Python extension share.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/model/function.hpp"
#include "saltus/model/integrator.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus::python {

namespace py = pybind11;
using namespace py::literals;

void add_formulas(py::module_& m);     ///< expressions, functions
void add_definitions(py::module_& m);  ///< bounds, phases, problems
void add_solves(py::module_& m);       ///< options, solvers, results
void add_searches(py::module_& m);     ///< several starts, sequences of modes
void add_loops(py::module_& m);        ///< controllers, plants, closed loops

/// Sizes of the arguments of a formula. The algebraic states z come after x.
struct FormulaSizes {
  int nx = 0, nu = 0, np = 0, nz = 0;
};

/// The Function of a Python formula: a callable that is traced once, a Function, or a function of
/// CasADi. `where` begins messages: "phase 'flight', term 'speed'".
Function function_of(const py::object& formula, const FormulaSizes& sizes,
                     const std::string& where);

/// Throws DefinitionError unless the function has this number of rows. `rule` is a sentence.
void require_rows(const Function& function, int rows, const std::string& where, const char* rule);

/// An integrator, which several phases may share.
struct Integrator {
  IntegratorChoice choice;  ///< the scheme
};

/// A solver whose ownership Python shares.
class SharedSolver final : public Solver {
 public:
  explicit SharedSolver(std::shared_ptr<Solver> solver) : solver_(std::move(solver)) {}
  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) override {
    if (!observer().should_stop) return solver_->solve(program, start, warm);
    struct Restore {
      Solver& solver;
      SolveObserver own;
      ~Restore() { solver.set_observer(own); }
    } restore{*solver_, solver_->observer()};
    SolveObserver both = restore.own;
    both.should_stop = [&] { return observer().wants_stop() || restore.own.wants_stop(); };
    solver_->set_observer(both);
    return solver_->solve(program, start, warm);
  }
  void set_deadline(WallClock::time_point deadline) override { solver_->set_deadline(deadline); }
  double tolerance() const override { return solver_->tolerance(); }
  bool keeps_stages() const override { return solver_->keeps_stages(); }
  std::string name() const override { return solver_->name(); }

 private:
  std::shared_ptr<Solver> solver_;
};

/// A vector from a number or a sequence.
using Numbers = std::variant<double, VectorXd>;
/// The vector; a number fills `size` entries.
inline VectorXd vector_of(const Numbers& numbers, int size = 1) {
  if (const double* number = std::get_if<double>(&numbers))
    return VectorXd::Constant(size, *number);
  return std::get<VectorXd>(numbers);
}

// Structs with fields that Python sets by keywords. Every struct is described once, by its fields.

/// Fields of a struct by name.
template <class T>
class Fields {
 public:
  using Set = std::function<void(T&, py::handle)>;

  static Fields& instance() {
    static Fields fields;
    return fields;
  }
  void add(const char* name, Set set) { all_.emplace_back(name, std::move(set)); }
  /// Sets the field. Returns false if there is none with this name.
  bool set(T& value, const std::string& name, py::handle to) const {
    for (const auto& [known, setter] : all_)
      if (known == name) {
        try {
          setter(value, to);
        } catch (const py::cast_error&) {
          throw py::type_error(name + ": " + py::repr(to).cast<std::string>() +
                               " has the wrong type; help() of this function lists the types");
        }
        return true;
      }
    return false;
  }
  /// Names of all fields, for messages.
  std::string names() const {
    std::string text;
    for (const auto& [name, setter] : all_) text += (text.empty() ? "" : ", ") + name;
    return text;
  }

 private:
  std::vector<std::pair<std::string, Set>> all_;
};

/// Sets fields of several structs by keywords. Throws TypeError for a keyword that none of them
/// has.
template <class... Structs>
void set_fields(const py::kwargs& keywords, Structs&... structs) {
  for (const auto& [key, value] : keywords) {
    const auto name = key.template cast<std::string>();
    if (!(Fields<Structs>::instance().set(structs, name, value) || ...)) {
      std::string known;
      ((known += (known.empty() ? "" : ", ") + Fields<Structs>::instance().names()), ...);
      throw py::type_error("there is no option '" + name + "'; the options are " + known);
    }
  }
}

/// True if an assignment frees memory to which Python could still refer.
template <class M>
inline constexpr bool moves_memory =
    py::detail::is_eigen_dense_plain<M>::value || requires { typename M::allocator_type; };
template <class M>
inline constexpr bool moves_memory<std::optional<M>> = true;

/// Binds a struct whose fields can be read and written, with a constructor that takes keywords.
template <class T>
class Struct : public py::class_<T> {
 public:
  Struct(py::handle scope, const char* name, const char* doc) : py::class_<T>(scope, name, doc) {}

  template <class Member>
  Struct& field(const char* name, Member T::*member) {
    if constexpr (moves_memory<Member>)  // Python gets a copy
      this->def_property(
          name, [member](const T& value) { return Member(value.*member); },
          [member](T& value, const Member& to) { value.*member = to; });
    else
      this->def_readwrite(name, member);
    Fields<T>::instance().add(
        name, [member](T& value, py::handle to) { value.*member = to.cast<Member>(); });
    return *this;
  }
  /// A field that Python gives in another form.
  Struct& field(const char* name, typename Fields<T>::Set set) {
    Fields<T>::instance().add(name, std::move(set));
    return *this;
  }
  /// Adds the constructor. The attribute `_fields` names the keywords, for stubs.
  Struct& from_keywords() {
    this->def(py::init([](const py::kwargs& keywords) {
      T value{};
      set_fields(keywords, value);
      return value;
    }));
    this->attr("_fields") = Fields<T>::instance().names();
    return *this;
  }
};

}  // namespace saltus::python
