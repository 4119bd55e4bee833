"""Draws all pictures of a results folder from its tables.

The folder may hold any run, a run of a legged robot (with report and view), a run or a campaign of the quadruped,
or a survival map.

Usage: python3 -m saltus.plot FOLDER
"""

import json
import os
import sys
import time

from .on_folder import NOT_WRITTEN, SAID

ENDINGS = (".png", ".html")


def _summary(folder):
    path = os.path.join(folder, "summary.json")
    if not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def _drawers(folder):
    """The modules that draw the tables of the folder, in order."""
    names = os.listdir(folder)
    if "map.csv" in names:
        from .walking import plot_map
        return [plot_map.main]
    if _summary(folder).get("name") == "quadruped":
        from . import plot_quadruped
        return [plot_quadruped.main]
    if "tracking.csv" in names:
        from . import plot_whole_body
        return [plot_whole_body.main]
    if "push_start_s" in _summary(folder):
        from .walking import plot_run, report
        return [plot_run.main, report.main]
    if any(name.startswith("trajectory") and name.endswith(".csv") for name in names):
        from . import plot_trajectory
        return [plot_trajectory.main]
    raise FileNotFoundError(f"{folder}: there is nothing to draw, neither trajectory.csv nor map.csv")


def redraw(folder):
    """Draws everything and returns the files that were written. Raises FileNotFoundError if there is nothing to draw."""
    folder = os.path.abspath(folder)
    begin = time.time() - 0.01  # resolution of the file system's clock
    for draw in _drawers(folder):
        draw(folder)
    drawn = [os.path.join(folder, name) for name in sorted(os.listdir(folder)) if name.endswith(ENDINGS)]
    return [path for path in drawn if os.path.getmtime(path) >= begin]


def main(folder):
    try:
        drawn = redraw(folder)
    except FileNotFoundError as error:
        print(f"{error.filename}: there is no such file" if error.filename else error, file=sys.stderr)
        return SAID
    except KeyError as error:
        print(f"{folder}: its tables have no column {error}; use the version of saltus that wrote them",
              file=sys.stderr)
        return SAID
    except (ValueError, TypeError, IndexError, AttributeError) as error:
        reason = str(error).strip().splitlines() or [type(error).__name__]
        print(f"{folder}: its tables are damaged and cannot be drawn: {reason[0][:200]}", file=sys.stderr)
        return SAID
    except OSError as error:
        print(f"{error.filename or folder}: {error.strerror}", file=sys.stderr)
        return NOT_WRITTEN
    print(f"drawn in {folder}: {', '.join(os.path.basename(path) for path in drawn)}")
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
