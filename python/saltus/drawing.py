"""Common parts of the drawing scripts: matplotlib without a display, and atomic writing of pictures."""

import os
import sys


def keep_fonts_in_cache():
    """Keeps matplotlib's font cache in the user's cache folder, which saves a second per run.

    Without a writable folder matplotlib creates a temporary one for each run."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folder = os.path.join(cache, "saltus", "matplotlib")
    try:
        os.makedirs(folder, mode=0o700, exist_ok=True)
        if os.stat(folder).st_uid == os.getuid():
            os.environ.setdefault("MPLCONFIGDIR", folder)
    except OSError:
        pass


keep_fonts_in_cache()
try:
    import matplotlib
except ModuleNotFoundError:
    print("no pictures: this python3 has no matplotlib; install python3-matplotlib and use "
          "/usr/bin/python3", file=sys.stderr)
    sys.exit(3)  # the message is printed; the calling program adds nothing

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402, F401

from .whole_file import whole_file  # noqa: E402


def save_picture(figure, path, dpi=110):
    """Writes a PNG file atomically."""
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=dpi, format="png")
