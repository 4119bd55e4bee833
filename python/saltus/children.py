"""Child processes that end with their parent, for any reason."""

import ctypes
import glob
import os
import signal
import sys

_SET_SIGNAL_OF_PARENTS_DEATH, _SET_CHILD_SUBREAPER = 1, 36  # prctl(2)


def end_with_parent():
    """Ends this process with its parent. Call it at the start of the child, or as preexec_fn if there are no threads.

    It has no effect outside Linux.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_SIGNAL_OF_PARENTS_DEATH, signal.SIGTERM, 0, 0, 0)


def adopt_orphans():
    """Makes this process the parent of its orphaned descendants, so that end_children() finds them. Linux only."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def children_of(process):
    """Process identifiers of the children; none on systems without /proc."""
    found = []
    for path in glob.glob(f"/proc/{process}/task/*/children"):
        try:
            with open(path, encoding="ascii") as file:
                found += map(int, file.read().split())
        except OSError:  # the thread has ended
            continue
    return found


def end_children():
    """Kills all descendants of a process that adopts orphans."""
    while children := children_of(os.getpid()):
        for child in children:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
