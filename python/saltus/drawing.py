"""What the scripts that draw share: matplotlib without a display, and pictures written whole."""

import os
import sys
import tempfile

os.environ.setdefault("MPLCONFIGDIR", os.path.join(tempfile.gettempdir(), "saltus-matplotlib"))
try:
    import matplotlib
except ModuleNotFoundError:
    print("no pictures: this python3 has no matplotlib; install python3-matplotlib and use "
          "/usr/bin/python3", file=sys.stderr)
    sys.exit(3)  # said: the program that called adds nothing

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402, F401


def save_picture(figure, path, dpi=110):
    """A PNG file that is never half written."""
    folder, name = os.path.split(os.path.abspath(path))
    partial = os.path.join(folder, "." + name)
    try:
        figure.savefig(partial, dpi=dpi, format="png")
        os.replace(partial, path)
    except OSError as error:
        if os.path.exists(partial):
            os.remove(partial)
        raise OSError(error.errno, os.strerror(error.errno), path) from None
