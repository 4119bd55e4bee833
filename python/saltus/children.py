"""Child processes that end with their parent, for any reason."""

import ctypes
import signal
import sys

_SET_SIGNAL_OF_PARENTS_DEATH = 1  # prctl(2)


def end_with_parent():
    """Ends this process with its parent. Call it at the start of the child, or as preexec_fn if there are no threads.

    It has no effect outside Linux.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_SIGNAL_OF_PARENTS_DEATH, signal.SIGTERM, 0, 0, 0)
