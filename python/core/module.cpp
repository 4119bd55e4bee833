// The Python extension saltus._core.
#include "core.hpp"
#include "saltus/core/error.hpp"

PYBIND11_MODULE(_core, m) {
  namespace py = pybind11;
  m.doc() = "Modelling, solves and control loops of Saltus.";
  py::register_exception<saltus::DefinitionError>(m, "DefinitionError", PyExc_ValueError);
  py::register_exception<saltus::InputError>(m, "InputError", PyExc_RuntimeError);
  saltus::python::add_formulas(m);
  saltus::python::add_definitions(m);
  saltus::python::add_solves(m);
  saltus::python::add_loops(m);
}
