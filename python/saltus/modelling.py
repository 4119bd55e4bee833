"""All names for problems, solves and control loops, as in C++. Use them as `saltus.Phase` or import them from here."""

from . import _core
from ._core import *  # noqa: F401, F403
from ._casadi import generate_casadi
from ._display import install as _install
from ._formulas import (acos, asin, atan, atan2, cos, cosh, exp, fabs, hypot, log, make_function, max, min, norm,
                        select, sin, sinh, smooth_abs, smooth_max, smooth_min, smooth_step, sqrt, tan, tanh)

_install(_core)
_core.DefinitionError.__doc__ = "A problem, phase, term or option is defined incorrectly. The message names it."
_core.InputError.__doc__ = "A file or value from outside the program is unusable."
__all__ = [name for name in dir(_core) if not name.startswith("_")] + [
    "acos", "asin", "atan", "atan2", "cos", "cosh", "exp", "fabs", "generate_casadi", "hypot", "log", "make_function", "max", "min", "norm",
    "select", "sin", "sinh", "smooth_abs", "smooth_max", "smooth_min", "smooth_step", "sqrt", "tan", "tanh"]
