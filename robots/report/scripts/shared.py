"""Makes the package saltus importable: the top folder's python/, or what lies there installed."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../python"))
