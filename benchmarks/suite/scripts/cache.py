"""The user's folder for what can be made again."""

import os


# Beside an installed program there is no script `./saltus`.
INSTALL_PEERS = ("./saltus setup --with-peers" if os.path.exists(os.path.join(os.path.dirname(__file__), "../../../CMakeLists.txt"))
                 else "saltus bench peers")


def not_installed(package):
    """Why a peer is missing, and what to do."""
    return f"the package {package} is not installed: {INSTALL_PEERS}"


def cache_folder(*names):
    """saltus/NAMES in XDG_CACHE_HOME, else in ~/.cache; made if it is not there, for the user alone."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folder = os.path.join(cache, "saltus", *names)
    os.makedirs(folder, mode=0o700, exist_ok=True)
    return folder
