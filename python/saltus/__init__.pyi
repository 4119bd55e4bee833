from ._casadi import generate_casadi as generate_casadi
from ._core import *
from ._formulas import (acos as acos, asin as asin, atan as atan, atan2 as atan2, cos as cos, cosh as cosh, exp as exp,
                        fabs as fabs, hypot as hypot, log as log, make_function as make_function, max as max,
                        min as min, norm as norm, select as select, sin as sin, sinh as sinh, smooth_abs as smooth_abs,
                        smooth_max as smooth_max, smooth_min as smooth_min, smooth_step as smooth_step, sqrt as sqrt,
                        tan as tan, tanh as tanh)
from .results import Run as Run, SaltusError as SaltusError, Table as Table, load as load, run as run
from .viewer import view as view
