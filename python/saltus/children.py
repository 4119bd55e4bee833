"""Processes that end when the one that started them does, however that came about."""

import ctypes
import signal
import sys

_SET_SIGNAL_OF_PARENTS_DEATH = 1  # prctl(2)


def end_with_parent():
    """To be called in the child: at its begin, or as preexec_fn where no threads run. Linux only; elsewhere nothing."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_SIGNAL_OF_PARENTS_DEATH, signal.SIGTERM, 0, 0, 0)
