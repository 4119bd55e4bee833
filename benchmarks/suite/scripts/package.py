"""Access to the package saltus for files and processes: it is next to these scripts, in a clone and in an installation."""

import os
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../python"))

from saltus.children import adopt_orphans, children_of, end_children, end_with_parent  # noqa: E402, F401
from saltus.whole_file import whole_file, write_text  # noqa: E402, F401
