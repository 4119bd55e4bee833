"""What the scripts that draw share: matplotlib without a display, and pictures written whole."""

import os
import sys


def keep_fonts_in_cache():
    """What matplotlib finds out about fonts takes it a second: kept in the user's own cache.

    Without a folder that can be written it makes one of its own for each run."""
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
    sys.exit(3)  # said: the program that called adds nothing

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402, F401

from .whole_file import whole_file  # noqa: E402


def save_picture(figure, path, dpi=110):
    """A PNG file that is never half written."""
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=dpi, format="png")
