"""The user's folder for what can be made again."""

import os


def cache_folder(*names):
    """saltus/NAMES in XDG_CACHE_HOME, else in ~/.cache; made if it is not there, for the user alone."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folder = os.path.join(cache, "saltus", *names)
    os.makedirs(folder, mode=0o700, exist_ok=True)
    return folder
