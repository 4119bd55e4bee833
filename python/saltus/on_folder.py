"""The command line of a script that works on one folder."""

import sys

# As framework/saltus/app/python_script.cpp understands them.
SAID = 3  # cannot be done, and a sentence said why
NOT_WRITTEN = 4


def on_folder(main, usage, what):
    """Calls main(folder); `what` says which folder is meant when a file is missing in it."""
    if len(sys.argv) != 2:
        sys.exit(usage)
    try:
        main(sys.argv[1])
    except FileNotFoundError as error:
        sys.exit(f"{error.filename}: there is no such file; {what}")
    except OSError as error:
        print(f"{error.filename or sys.argv[1]}: {error.strerror}", file=sys.stderr)
        sys.exit(NOT_WRITTEN)
