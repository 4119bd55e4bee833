"""Runs of Saltus in Python: load their tables, make them, draw them, hand them to other tools.

    import saltus
    run = saltus.load("results/demo")                    # a folder that a run left
    run = saltus.run("push_recovery", push__impulse=6)   # makes one with the program, and loads it
    height = run.trajectory["height"]                    # arrays by name, with or without the unit
    run.to_mat("demo.mat")                               # robot-log-visualizer, MATLAB
    run.to_mcap("demo.mcap")                             # Foxglove, PlotJuggler

What the program saltus itself calls to draw is in this package, too; that part needs matplotlib only.
"""

_OF_RESULTS = ("load", "run", "Run", "Table", "SaltusError")
__all__ = list(_OF_RESULTS)


def __getattr__(name):
    if name in _OF_RESULTS:  # numpy is needed from here on
        from . import results
        return getattr(results, name)
    raise AttributeError(f"module 'saltus' has no attribute '{name}'")
