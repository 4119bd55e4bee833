// Expressions that Python formulas compute with while they are traced, and the functions made from
// them.
#include <pybind11/operators.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>
#include <vector>

#include "core.hpp"
#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/autodiff/tracer.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/model/casadi_function.hpp"
#include "saltus/model/steps_of.hpp"

namespace saltus::python {
namespace {

// Number of the trace in progress; 0: none.
thread_local long trace_in_progress = 0;
std::atomic<long> traces = 0;  // of all threads, so that a number identifies one trace

// A number of a formula while it is traced.
struct Expression {
  Tracer value;
  long trace = 0;
};

const Tracer& current(const Expression& e) {
  if (e.trace != trace_in_progress)
    throw DefinitionError(
        "a number of another formula is used: a formula is traced once, and its numbers exist only "
        "in it");
  return e.value;
}

using Operand = std::variant<double, Expression>;
Tracer current(const Operand& operand) {
  if (const double* number = std::get_if<double>(&operand)) return {*number};
  return current(std::get<Expression>(operand));
}
Expression expression(Tracer value) { return {std::move(value), trace_in_progress}; }

template <Tracer (*f)(const Tracer&)>
Expression unary(const Expression& a) {
  return expression(f(current(a)));
}

template <class F>
void add_operator(py::class_<Expression>& c, const char* name, const char* reflected, F f) {
  c.def(
      name,
      [f](const Expression& a, const Expression& b) {
        return expression(f(current(a), current(b)));
      },
      py::is_operator());
  c.def(
      name, [f](const Expression& a, double b) { return expression(f(current(a), Tracer(b))); },
      py::is_operator());
  c.def(
      reflected,
      [f](const Expression& a, double b) { return expression(f(Tracer(b), current(a))); },
      py::is_operator());
}

template <class F>
void add_function(py::module_& m, const char* name, F f, const char* doc) {
  m.def(
      name,
      [f](const Operand& a, const Operand& b) { return expression(f(current(a), current(b))); },
      "a"_a, "b"_a, doc);
}

[[noreturn]] void refuse_branch(const Expression&, const py::object&) {
  throw DefinitionError(
      "a formula is traced once, so it cannot compare its numbers or branch on them: use "
      "saltus.select(condition, a, b), saltus.min or saltus.max");
}

// Records a callable of `inputs` expressions that returns a list of expressions and numbers.
Function record(int inputs, const py::function& formula, const std::string& where) {
  struct Scope {
    StepRecorder recorder;
    long outer = trace_in_progress;
    Scope() { trace_in_progress = ++traces; }
    ~Scope() { trace_in_progress = outer; }
  } scope;
  py::list z;
  for (int i = 0; i < inputs; ++i) z.append(expression(Tracer::input(i)));
  std::vector<Tracer> y;
  for (const Operand& row : formula(z).cast<std::vector<Operand>>()) y.push_back(current(row));
  FormulaSteps steps = scope.recorder.end(inputs, y);
  return saltus::function_of(std::move(steps), {{}, where});
}

// Shortest mean processor time of an evaluation, in seconds: value, Jacobian, Hessian.
std::vector<double> seconds(const Function& f, const VectorXd& z, const VectorXd& weights) {
  if (z.size() != f.inputs() || weights.size() != f.outputs())
    throw DefinitionError("seconds: z or weights has the wrong size");
  VectorXd y(f.outputs()), jacobian(f.jacobian_pattern().entries()),
      hessian(f.hessian_pattern().entries());
  const auto shortest = [](const auto& evaluate) {
    constexpr int rounds = 20, repetitions = 2000;
    double best = infinity;
    for (int i = 0; i < rounds; ++i) {
      const double begin = thread_microseconds();
      for (int k = 0; k < repetitions; ++k) evaluate();
      best = std::min(best, 1e-6 * (thread_microseconds() - begin) / repetitions);
    }
    return best;
  };
  return {shortest([&] { f.value(z.data(), y.data()); }),
          shortest([&] { f.jacobian(z.data(), y.data(), jacobian.data()); }),
          shortest([&] { f.hessian(z.data(), weights.data(), hessian.data()); })};
}

py::object dense(const SparsityPattern& pattern) {
  py::array_t<bool> all({pattern.rows(), pattern.cols()});
  auto entries = all.mutable_unchecked<2>();
  for (int i = 0; i < pattern.rows(); ++i)
    for (int j = 0; j < pattern.cols(); ++j) entries(i, j) = pattern.contains(i, j);
  return all;
}

}  // namespace

Function function_of(const py::object& formula, const FormulaSizes& sizes,
                     const std::string& where) {
  return py::module_::import("saltus._formulas")
      .attr("function")(formula, sizes.nx, sizes.nu, sizes.np, sizes.nz, where)
      .cast<Function>();
}

void require_rows(const Function& function, int rows, const std::string& where, const char* rule) {
  if (function.outputs() != rows)
    throw DefinitionError(where + ": " + rule + "; it returns " +
                          std::to_string(function.outputs()) +
                          (function.outputs() == 1 ? " row" : " rows"));
}

void add_formulas(py::module_& m) {
  py::class_<Expression> e(m, "Expression", "A number of a formula while it is traced.");
  add_operator(e, "__add__", "__radd__", [](const Tracer& a, const Tracer& b) { return a + b; });
  add_operator(e, "__sub__", "__rsub__", [](const Tracer& a, const Tracer& b) { return a - b; });
  add_operator(e, "__mul__", "__rmul__", [](const Tracer& a, const Tracer& b) { return a * b; });
  add_operator(e, "__truediv__", "__rtruediv__",
               [](const Tracer& a, const Tracer& b) { return a / b; });
  // Small whole powers are products, as users of C++ write them.
  add_operator(e, "__pow__", "__rpow__", [](const Tracer& a, const Tracer& b) {
    if (b.is_constant() && b.constant() == 2.0) return a * a;
    if (b.is_constant() && b.constant() == 3.0) return a * a * a;
    return pow(a, b);
  });
  e.def("__neg__", [](const Expression& a) { return expression(-current(a)); });
  e.def("__pos__", [](const Expression& a) { return a; });
  e.def("__abs__", &unary<&saltus::abs>);
  for (const char* name : {"__lt__", "__le__", "__gt__", "__ge__", "__eq__", "__ne__"})
    e.def(name, &refuse_branch);
  e.def("__bool__", [](const Expression& a) -> bool { refuse_branch(a, py::none()); });
  e.def("__float__", [](const Expression&) -> double {
    throw py::type_error(
        "a formula is traced once, so its numbers have no value: use numpy.sin or saltus.sin, not "
        "math.sin, and do not convert to float");
  });
  e.def("__hash__", [](const Expression&) -> long { return 0; });
  e.def("__repr__", [](const Expression&) { return "<Expression>"; });
  // numpy calls these methods for the entries of an array.
  e.def("sin", &unary<&saltus::sin>).def("cos", &unary<&saltus::cos>);
  e.def("tan", &unary<&saltus::tan>).def("arcsin", &unary<&saltus::asin>);
  e.def("arccos", &unary<&saltus::acos>).def("arctan", &unary<&saltus::atan>);
  e.def("sinh", &unary<&saltus::sinh>).def("cosh", &unary<&saltus::cosh>);
  e.def("tanh", &unary<&saltus::tanh>).def("exp", &unary<&saltus::exp>);
  e.def("log", &unary<&saltus::log>).def("sqrt", &unary<&saltus::sqrt>);
  e.def("conjugate", [](const Expression& a) { return a; });
  using Binary = Tracer (*)(const Tracer&, const Tracer&);
  add_function(m, "_min", static_cast<Binary>(&saltus::min), "The smaller one.");
  add_function(m, "_max", static_cast<Binary>(&saltus::max), "The larger one.");
  add_function(m, "_atan2", static_cast<Binary>(&saltus::atan2), "Angle of the point (b, a).");
  add_function(m, "_hypot", static_cast<Binary>(&saltus::hypot), "sqrt(a a + b b).");
  m.def("_select", [](const Operand& condition, const Operand& a, const Operand& b) {
    return expression(Tracer::select(current(condition), current(a), current(b)));
  });
  m.def("_record", &record);

  py::class_<Function>(m, "Function",
                       "A formula y = f(z) with exact derivatives and sparsity, accepted wherever "
                       "a formula is. The argument is z = (t | x | u | p).")
      .def_property_readonly("inputs", &Function::inputs, "Number of entries of z.")
      .def_property_readonly("outputs", &Function::outputs, "Number of entries of y.")
      .def(
          "__call__", [](const Function& f, const VectorXd& z) { return f(z); }, "z"_a,
          "The values at z.")
      .def(
          "jacobian", [](const Function& f, const VectorXd& z) { return f.dense_jacobian(z); },
          "z"_a, "The Jacobian at z, outputs x inputs.")
      .def(
          "hessian",
          [](const Function& f, const VectorXd& z, const VectorXd& weights) {
            return f.dense_hessian(z, weights);
          },
          "z"_a, "weights"_a, "The Hessian of the weighted sum of outputs at z.")
      .def("seconds", &seconds, "z"_a, "weights"_a,
           "Measured times of an evaluation in seconds: value, Jacobian, Hessian.")
      .def_property_readonly(
          "jacobian_pattern", [](const Function& f) { return dense(f.jacobian_pattern()); },
          "True for entries of the Jacobian that may be non-zero.")
      .def_property_readonly(
          "hessian_pattern", [](const Function& f) { return dense(f.hessian_pattern()); },
          "True for entries of the lower triangle that may be non-zero.");
  m.def(
      "load_casadi",
      [](const std::string& library, const std::string& name, int nx, int nu, int np) {
        return load_casadi(library, name, {nx, nu, np});
      },
      "library"_a, "name"_a, "nx"_a, "nu"_a = 0, "np"_a = 0,
      "Loads a function of CasADi's generated C code from a shared library.");
}

}  // namespace saltus::python
