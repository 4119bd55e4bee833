"""The command line of a script that works on one folder."""

import sys

# Exit status for framework/saltus/app/python_script.cpp.
SAID = 3  # impossible, and the reason is printed
NOT_WRITTEN = 4


def on_folder(main, usage, what):
    """Calls main(folder). If a file is missing, the message describes the folder by `what`."""
    if len(sys.argv) != 2:
        sys.exit(usage)
    try:
        main(sys.argv[1])
    except FileNotFoundError as error:
        sys.exit(f"{error.filename}: there is no such file; {what}")
    except OSError as error:
        print(f"{error.filename or sys.argv[1]}: {error.strerror}", file=sys.stderr)
        sys.exit(NOT_WRITTEN)
