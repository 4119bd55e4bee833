/* An extension of Python with the controllers that are linked into it:
 *
 *     import cart_extension
 *     cart = cart_extension.create("cart")
 *     cart_extension.set_data(cart, "target", [1.0])
 *     provenance, input = cart_extension.tick(cart, 0.0, [0.0, 0.0])
 *     times, states, inputs = cart_extension.plan(cart) */
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <saltus/c/saltus_c.h>

enum { most = 64, most_rows = 1024 };

static void destroy(PyObject* capsule) {
  saltus_destroy((saltus_controller*)PyCapsule_GetPointer(capsule, "saltus_controller"));
}

static saltus_controller* controller_of(PyObject* capsule) {
  return (saltus_controller*)PyCapsule_GetPointer(capsule, "saltus_controller");
}

static int failed(saltus_status status, const saltus_controller* controller) {
  if (status != SALTUS_OK) PyErr_SetString(PyExc_RuntimeError, saltus_error(controller));
  return status != SALTUS_OK;
}

/* Copies a sequence of numbers. Returns their number, or -1 with an exception. */
static int numbers(PyObject* sequence, double* values) {
  PyObject* items = PySequence_Fast(sequence, "expected a sequence of numbers");
  if (items == NULL) return -1;
  Py_ssize_t count = PySequence_Fast_GET_SIZE(items);
  if (count > most) {
    PyErr_Format(PyExc_ValueError, "at most %d numbers", most);
    count = -1;
  }
  for (Py_ssize_t i = 0; i < count; ++i)
    values[i] = PyFloat_AsDouble(PySequence_Fast_GET_ITEM(items, i));
  Py_DECREF(items);
  return PyErr_Occurred() ? -1 : (int)count;
}

/* A list of `count` numbers. */
static PyObject* list_of(const double* values, int count) {
  PyObject* list = PyList_New(count);
  for (int i = 0; list != NULL && i < count; ++i)
    PyList_SET_ITEM(list, i, PyFloat_FromDouble(values[i]));
  return list;
}

/* A list of lists. */
static PyObject* table_of(const double* values, int rows, int columns) {
  PyObject* list = PyList_New(rows);
  for (int i = 0; list != NULL && i < rows; ++i)
    PyList_SET_ITEM(list, i, list_of(values + i * columns, columns));
  return list;
}

static PyObject* create(PyObject* self, PyObject* arguments) {
  (void)self;
  const char* name;
  saltus_controller* controller;
  saltus_sizes sizes;
  if (!PyArg_ParseTuple(arguments, "s", &name)) return NULL;
  const saltus_status status = saltus_create(name, &controller);
  if (failed(status, controller) || failed(saltus_read_sizes(controller, &sizes), controller)) {
    saltus_destroy(controller);
    return NULL;
  }
  if (sizes.plan_states > most || sizes.plan_inputs > most) {
    saltus_destroy(controller);
    return PyErr_Format(PyExc_ValueError, "at most %d states and inputs", most);
  }
  return PyCapsule_New(controller, "saltus_controller", destroy);
}

static PyObject* set_data(PyObject* self, PyObject* arguments) {
  (void)self;
  PyObject *capsule, *sequence;
  const char* name;
  double values[most];
  if (!PyArg_ParseTuple(arguments, "OsO", &capsule, &name, &sequence)) return NULL;
  saltus_controller* controller = controller_of(capsule);
  const int count = controller == NULL ? -1 : numbers(sequence, values);
  if (count < 0 || failed(saltus_set_data(controller, name, values, count), controller))
    return NULL;
  Py_RETURN_NONE;
}

static PyObject* tick(PyObject* self, PyObject* arguments) {
  (void)self;
  PyObject *capsule, *sequence;
  double time, state[most], input[most], start, length;
  saltus_tick result;
  saltus_status status;
  int count;
  if (!PyArg_ParseTuple(arguments, "OdO", &capsule, &time, &sequence)) return NULL;
  saltus_controller* controller = controller_of(capsule);
  const int states = controller == NULL ? -1 : numbers(sequence, state);
  if (states < 0) return NULL;
  Py_BEGIN_ALLOW_THREADS; /* other threads of Python run during the solve */
  status = saltus_prepare(controller, time);
  if (status == SALTUS_OK) status = saltus_feedback(controller, state, states, &result);
  Py_END_ALLOW_THREADS;
  if (failed(status, controller) ||
      failed(saltus_read_piece(controller, 0, &start, &length, input, most, &count), controller))
    return NULL;
  return Py_BuildValue("iN", (int)result.provenance, list_of(input, count));
}

static PyObject* plan(PyObject* self, PyObject* capsule) {
  (void)self;
  static double times[most_rows], states[most_rows * most], inputs[most_rows * most];
  saltus_controller* controller = controller_of(capsule);
  saltus_sizes sizes;
  int rows;
  if (controller == NULL || failed(saltus_read_sizes(controller, &sizes), controller) ||
      failed(saltus_read_plan(controller, times, NULL, states, inputs, most_rows, &rows),
             controller))
    return NULL;
  return Py_BuildValue("NNN", list_of(times, rows), table_of(states, rows, sizes.plan_states),
                       table_of(inputs, rows, sizes.plan_inputs));
}

static PyMethodDef methods[] = {
    {"create", create, METH_VARARGS, "create(name): a controller"},
    {"set_data", set_data, METH_VARARGS, "set_data(controller, name, values)"},
    {"tick", tick, METH_VARARGS, "tick(controller, time, state): provenance and input"},
    {"plan", plan, METH_O, "plan(controller): times, states and inputs of the nodes"},
    {NULL, NULL, 0, NULL}};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, "cart_extension", NULL, -1, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit_cart_extension(void) { return PyModule_Create(&module); }
