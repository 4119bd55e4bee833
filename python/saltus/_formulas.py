"""Formulas in Python: callables that are traced once, functions of CasADi, elementary functions."""

import builtins
import inspect
import types

import numpy as np

from . import _core

_DIRECT = {"add", "subtract", "multiply", "divide", "true_divide", "negative", "positive", "square", "reciprocal",
           "matmul", "absolute", "sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "exp",
           "log", "sqrt", "conjugate", "power", "float_power"}
_BINARY = {"minimum": _core._min, "fmin": _core._min, "maximum": _core._max, "fmax": _core._max,
           "arctan2": _core._atan2, "hypot": _core._hypot}


def _float(entry):
    return float(entry) if isinstance(entry, np.number) else entry


_floats = np.frompyfunc(_float, 1, 1)


def _plain(value):
    """The entries as objects; numbers of numpy would call numpy again."""
    return np.asarray(_floats(np.asarray(value, dtype=object)), dtype=object)


def _apply(ufunc, method, *inputs, out=None, **keywords):
    """A function of numpy whose arguments contain expressions."""
    if out is not None:
        raise TypeError(f"numpy.{ufunc.__name__}: a formula cannot write into an array; use the result")
    if ufunc.__name__ in _BINARY and method == "__call__":
        result = np.frompyfunc(_BINARY[ufunc.__name__], 2, 1)(*map(_plain, inputs))
    elif ufunc.__name__ in _DIRECT or ufunc.__name__.startswith(("less", "greater", "equal", "not_equal")):
        function = np.power if ufunc.__name__ == "float_power" else ufunc
        result = getattr(function, method)(*map(_plain, inputs), **keywords)
    else:
        raise TypeError(f"numpy.{ufunc.__name__} has no derivative rule here; available are "
                        f"{', '.join(sorted(_DIRECT | set(_BINARY)))}, and saltus.select")
    return result.view(Vector) if isinstance(result, np.ndarray) else result


_core.Expression.__array_ufunc__ = lambda self, ufunc, method, *inputs, **keywords: _apply(
    ufunc, method, *inputs, **keywords)


class Vector(np.ndarray):
    """The argument x, u or p of a formula: an array of expressions."""

    def __array_ufunc__(self, ufunc, method, *inputs, **keywords):
        return _apply(ufunc, method, *inputs, **keywords)

    def __array_finalize__(self, other):
        self.letter = None

    def __getitem__(self, index):
        if self.letter and isinstance(index, (int, np.integer)) and not -len(self) <= index < len(self):
            raise _core.DefinitionError(f"it uses {self.letter}[{index}], but {self.described()}")
        return super().__getitem__(index)

    def __iter__(self):
        return iter(self.tolist() if self.ndim == 1 else super().__iter__())

    def described(self):
        what = {"x": "state", "u": "input", "p": "parameter", "z": "algebraic state"}[self.letter]
        if len(self) == 0:
            return f"there are no {what}s"
        if len(self) == 1:
            return f"there is 1 {what}, {self.letter}[0]"
        return f"there are {len(self)} {what}s, {self.letter}[0] to {self.letter}[{len(self) - 1}]"


def _vector(letter, entries):
    vector = np.empty(len(entries), dtype=object)
    vector[:] = entries
    vector = vector.view(Vector)
    vector.letter = letter
    return vector


def rows(result):
    """The entries of a result: a number, or a list or array of numbers and arrays."""
    if isinstance(result, np.ndarray):
        if result.ndim > 1 and result.size != builtins.max(result.shape):
            raise _core.DefinitionError(f"it returns a matrix of {' x '.join(map(str, result.shape))}; a formula must "
                                        "return a scalar or a vector")
        return result.reshape(-1).tolist()
    if isinstance(result, (list, tuple)):
        return [entry for part in result for entry in rows(part)]
    if result is None:
        raise _core.DefinitionError("it returns nothing; a formula must return a scalar or a vector")
    if isinstance(result, _core.Expression):
        return [result]
    if isinstance(result, (int, float, np.number)):
        return [float(result)]
    if hasattr(result, "sparsity"):
        raise _core.DefinitionError("it returns an expression of CasADi; give casadi.Function(name, [t, x, u], [...])")
    raise _core.DefinitionError(f"it returns {type(result).__name__}; a formula must return a scalar or a vector")


def _count(formula):
    """Number of positional arguments; None: any."""
    try:
        parameters = inspect.signature(formula).parameters.values()
    except (TypeError, ValueError):
        return None
    if any(p.kind == p.VAR_POSITIONAL for p in parameters):
        return None
    required = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)
                and p.default is p.empty]
    return len(required)


def _split(z, sizes):
    """The arguments of a formula: `sizes` are pairs of a letter and a number of entries; t is a number."""
    arguments, first = [z[0]], 1
    for letter, size in sizes:
        arguments.append(_vector(letter, z[first:first + size]))
        first += size
    return arguments


def _called(formula, arguments, letters):
    given = _count(formula)
    if given is not None and not 2 <= given <= len(letters):
        forms = [f"f({', '.join(letters[:n])})" for n in range(2, len(letters) + 1)]
        raise _core.DefinitionError(f"it takes {given} arguments, but a formula is called as "
                                    f"{', '.join(forms[:-1])} or {forms[-1]}")
    return rows(formula(*(arguments if given is None else arguments[:given])))


def _record(count, of_list, where):
    try:
        return _core._record(count, of_list, where)
    except _core.DefinitionError as error:
        if str(error).startswith(where):
            raise
        raise _core.DefinitionError(f"{where}: {error}") from error


def function(formula, nx, nu, np, nz, where):
    """The Function of a formula with nx states, nu inputs, np parameters and nz algebraic states."""
    if isinstance(formula, _core.Function):
        return formula
    if hasattr(formula, "n_instructions"):
        from ._casadi import traced
        return _record(1 + nx + nz + nu + np, lambda z: traced(formula, z, nx, nz, nu, np), where)
    if not callable(formula):
        raise _core.DefinitionError(f"{where}: a formula must be callable as f(t, x), f(t, x, u) or f(t, x, u, p), or "
                                    f"a Function; given is {type(formula).__name__}")
    sizes = [("x", nx), *([("z", nz)] if nz else []), ("u", nu), ("p", np)]
    letters = ["t", *(letter for letter, _ in sizes)]
    return _record(1 + nx + nz + nu + np, lambda z: _called(formula, _split(z, sizes), letters), where)


def link_function(formula, ends, where):
    """The Function of a link: `ends` are pairs of the numbers of states and parameters."""
    def of_list(z):
        values, first = [], 1
        for nx, np_ in ends:
            values.append(types.SimpleNamespace(
                t=z[first], duration=z[first + 1], x=_vector("x", z[first + 2:first + 2 + nx]),
                p=_vector("p", z[first + 2 + nx:first + 2 + nx + np_])))
            first += 2 + nx + np_
        return rows(formula(*values))

    if isinstance(formula, _core.Function):
        return formula
    return _record(1 + sum(2 + nx + np_ for nx, np_ in ends), of_list, where)


def make_function(formula, nx, nu=0, np=0, nz=0):
    """The Function of a formula of (t, x), (t, x, u) or (t, x, u, p), which is traced once."""
    return function(formula, nx, nu, np, nz, "a formula")


def _elementary(name, of_numpy):
    def apply(x):
        return of_numpy(x)
    apply.__name__ = name
    apply.__doc__ = f"{name}(x) of a number, an expression of a formula, or an array of them."
    return apply


sin, cos, tan, sinh, cosh, tanh, exp, log, sqrt = (
    _elementary(name, getattr(np, name)) for name in "sin cos tan sinh cosh tanh exp log sqrt".split())
asin, acos, atan = _elementary("asin", np.arcsin), _elementary("acos", np.arccos), _elementary("atan", np.arctan)
fabs = _elementary("fabs", np.abs)


def _is_number(value):
    return isinstance(value, (int, float, np.number))


def atan2(y, x):
    """Angle of the point (x, y)."""
    return np.arctan2(y, x)


def hypot(a, b):
    """sqrt(a^2 + b^2), with derivative zero at zero."""
    return np.hypot(a, b)


def min(a, b):  # pylint: disable=redefined-builtin
    """The smaller one of two numbers."""
    return np.minimum(a, b)


def max(a, b):  # pylint: disable=redefined-builtin
    """The larger one of two numbers."""
    return np.maximum(a, b)


def select(condition, a, b):
    """`a` if condition >= 0, else `b`. The derivative is that of the chosen branch."""
    if all(map(_is_number, (condition, a, b))):
        return a if condition >= 0 else b
    return _core._select(condition, a, b)


def norm(v):
    """Euclidean length of a vector, with derivative zero at zero."""
    return sqrt(sum(entry * entry for entry in v))


def smooth_step(x, width):
    """Rises from 0 to 1 around x = 0: (1 + tanh(x / width)) / 2."""
    return 0.5 * (1.0 + tanh(x / width))


def smooth_abs(x, width):
    """sqrt(x^2 + width^2)."""
    return sqrt(x * x + width * width)


def smooth_max(a, b, width):
    """Exceeds max(a, b) by at most width / 2."""
    return 0.5 * (a + b + smooth_abs(a - b, width))


def smooth_min(a, b, width):
    """Below min(a, b) by at most width / 2."""
    return 0.5 * (a + b - smooth_abs(a - b, width))
