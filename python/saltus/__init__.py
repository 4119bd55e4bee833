"""Saltus in Python: define and solve problems, run control loops, load, draw and view runs.

    import saltus
    from saltus import *                                 # the names of C++: Phase, solve, exactly, ...
    plan = saltus.solve(problem, intervals_per_phase=50)     # docs/python.md

    run = saltus.load("results/demo")                    # the folder of a run
    run = saltus.run("push_recovery", push__impulse=6)   # runs the program and loads the result
    height = run.trajectory["height"]                    # arrays by name, with or without the unit
    saltus.view(run)                                     # a page with curves and scene, inline in Jupyter
    run.to_mat("demo.mat")                               # robot-log-visualizer, MATLAB
    run.to_mcap("demo.mcap")                             # Foxglove, PlotJuggler

This package also contains the scripts that draw the pictures of the program saltus. They need only matplotlib.
"""

import importlib
import importlib.util
import pkgutil

# A build folder holds the extension in another folder of this name.
__path__ = pkgutil.extend_path(__path__, __name__)

_OF_RESULTS = ("load", "run", "Run", "Table", "SaltusError")
_BUILTINS = ("min", "max")  # `from saltus import *` leaves these to Python


def _modelling():
    try:
        return importlib.import_module(".modelling", __name__)
    except ImportError as error:
        if "cannot open shared object file" in str(error):
            raise ImportError(f"the extension saltus._core needs the library {str(error).split(':')[0]}, which is missing: "
                              "apt-get install libfmt-dev libsuitesparse-dev libsundials-dev coinor-libipopt-dev; if that "
                              "does not help, the wheel is for another release of Debian: build it with "
                              "`pip install ./python` in a checkout") from error
        if "_core" not in str(error):
            raise
        raise ImportError("the extension saltus._core is not built: `pip install ./python` in a checkout of Saltus "
                          "builds it") from error


def __getattr__(name):
    if name in _OF_RESULTS:  # numpy is needed from here on
        return getattr(importlib.import_module(".results", __name__), name)
    if name == "view":
        return importlib.import_module(".viewer", __name__).view
    if name == "__all__":
        return sorted({*_OF_RESULTS, "view", *_modelling().__all__} - {*_BUILTINS})
    if not name.startswith("_") and importlib.util.find_spec(f"{__name__}.{name}") is None:
        value = getattr(_modelling(), name, None)
        if value is not None:
            return value
    raise AttributeError(f"module 'saltus' has no attribute '{name}'")


def __dir__():
    return sorted({*_OF_RESULTS, "view", *_modelling().__all__})
