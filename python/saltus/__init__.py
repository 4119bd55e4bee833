"""Runs of Saltus in Python: load tables, run the program, draw pictures, convert to other formats.

    import saltus
    run = saltus.load("results/demo")                    # the folder of a run
    run = saltus.run("push_recovery", push__impulse=6)   # runs the program and loads the result
    height = run.trajectory["height"]                    # arrays by name, with or without the unit
    run.to_mat("demo.mat")                               # robot-log-visualizer, MATLAB
    run.to_mcap("demo.mcap")                             # Foxglove, PlotJuggler

This package also contains the scripts that draw the pictures of the program saltus. They need only matplotlib.
"""

_OF_RESULTS = ("load", "run", "Run", "Table", "SaltusError")
__all__ = list(_OF_RESULTS)


def __getattr__(name):
    if name in _OF_RESULTS:  # numpy is needed from here on
        from . import results
        return getattr(results, name)
    raise AttributeError(f"module 'saltus' has no attribute '{name}'")
