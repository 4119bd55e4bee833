"""Checks that every public header compiles alone and finds its includes among the installed headers.

Usage: check_headers.py PREFIX COMPILER [FLAG ...]. Exits with 1 and the output of the compiler if one does not. The
flags name the headers of other packages; the prefix is an installation of all components.
"""

import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys


def check(header, include, compiler, flags):
    source = f"#include <{header}>\n#include <{header}>\n"  # twice, to test the include guard
    command = [compiler, "-x", "c++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", f"-I{include}",
               *flags, "-"]
    done = subprocess.run(command, input=source, capture_output=True, text=True)
    return header, done.returncode, done.stderr


def main(arguments):
    include = pathlib.Path(arguments[0]) / "include"
    headers, failures = [], 0
    for path in sorted(include.rglob("*.hpp")):
        # A header at the old path of one that moved (framework/cmake/moved_headers.txt) only includes the new one.
        moved = re.match(r"// Moved: include <([^>]+)>", path.read_text(encoding="utf-8"))
        if not moved:
            headers.append(path.relative_to(include).as_posix())
        elif not (include / moved[1]).exists():
            failures += 1
            print(f"{path.relative_to(include)} moved to {moved[1]}, which is not installed")
    if not headers:
        print(f"no headers in {include}")
        return 1
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        for header, status, words in pool.map(lambda h: check(h, include, arguments[1], arguments[2:]), headers):
            if status:
                failures += 1
                print(f"{header} does not compile alone:\n{words[:1500]}")
    print(f"public headers: {len(headers)}, failures: {failures}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
