"""The user's cache folder, for files that can be created again."""

import os


# An installed program has no script `./saltus`.
INSTALL_PEERS = ("./saltus setup --with-peers" if os.path.exists(os.path.join(os.path.dirname(__file__), "../../../CMakeLists.txt"))
                 else "saltus bench peers")


def not_installed(package):
    """The reason why a peer is missing, and the remedy."""
    return f"the package {package} is not installed: {INSTALL_PEERS}"


def cache_folder(*names):
    """saltus/NAMES in XDG_CACHE_HOME or ~/.cache. Creates it, readable by the user only."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folder = os.path.join(cache, "saltus", *names)
    os.makedirs(folder, mode=0o700, exist_ok=True)
    return folder
