// The Python extension saltus._core.
#include "core.hpp"
#include "saltus/core/error.hpp"

PYBIND11_MODULE(_core, m) {
  namespace py = pybind11;
#if PYBIND11_VERSION_HEX < 0x020C0000
  // Releases before 2.12 read the structures of NumPy 1.
  const auto version = py::module_::import("numpy").attr("__version__").cast<std::string>();
  if (version.rfind("1.", 0) != 0)
    throw py::import_error(
        "saltus._core was built with a release of pybind11 before 2.12, which needs NumPy 1, but "
        "NumPy " +
        version + " is installed: install it with pip install ./python");
#endif
  m.doc() = "Modelling, solves and control loops of Saltus.";
  py::register_exception<saltus::DefinitionError>(m, "DefinitionError", PyExc_ValueError);
  py::register_exception<saltus::InputError>(m, "InputError", PyExc_RuntimeError);
  saltus::python::add_formulas(m);
  saltus::python::add_definitions(m);
  saltus::python::add_solves(m);
  saltus::python::add_searches(m);
  saltus::python::add_loops(m);
}
