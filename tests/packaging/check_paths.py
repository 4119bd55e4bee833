#!/usr/bin/env python3
"""Checks that every path of the repository that CONTRIBUTING.md and the READMEs of top folders name exists.

Usage: check_paths.py ROOT. Exits with 1 and a line for every path that does not exist. Paths are:
  - targets of links, relative to the page,
  - inline code with a slash that begins with a name in the root or with "saltus/" (an include path),
  - inline code that is only a file name with the suffix of a source: a file of this name must exist anywhere,
  - folders of a tree in a code block: lines that begin with words such as "core/", with two spaces per level.
"""

import pathlib
import re
import subprocess
import sys

INCLUDE_ROOTS = ("framework", "integrators", "robots")
SUFFIXES = (".hpp", ".cpp", ".py", ".sh", ".cmake", ".in", ".md", ".txt")
LINK = re.compile(r"\]\(([^)\s]+)\)")
CODE = re.compile(r"`([^`]+)`")
PATH = re.compile(r"(?!\.*$)[\w.+-]+(?:/[\w.+-]+)*/?$")
TREE = re.compile(r"( *)((?:[\w.+-]+/ ?)+)(?: |$)")


def files_of(root):
    listed = subprocess.run(["git", "-C", root, "ls-files"], capture_output=True, text=True, check=False).stdout.split("\n")
    files = [name for name in listed if name]  # empty outside of a checkout
    return files or [path.relative_to(root).as_posix() for path in pathlib.Path(root).rglob("*") if path.is_file()]


class Paths:
    """The files and folders of the repository."""

    def __init__(self, files):
        self.all = {part.as_posix() for name in files for part in (pathlib.PurePosixPath(name),
                                                                  *pathlib.PurePosixPath(name).parents)}
        self.tops = {name.split("/")[0] for name in files}
        self.names = {pathlib.PurePosixPath(name).name for name in files}

    def has(self, path):
        return path.rstrip("/") in self.all

    def has_code(self, word):
        """False if the word is a path that does not exist."""
        word = word.removeprefix("./").strip("\"")
        if not PATH.match(word) or "..." in word:
            return True
        first, slash, _ = word.partition("/")
        if not slash:
            return not word.endswith(SUFFIXES) or word.startswith(".") or word in self.names
        if first == "saltus":
            return any(self.has(f"{root}/{word}") for root in INCLUDE_ROOTS)
        return first not in self.tops or self.has(word)


def linked(page, target):
    """The path of a link from the root, or None for another site or the page itself."""
    path = target.split("#")[0]
    if not path or ":" in path:
        return None
    parts = []
    for part in (pathlib.PurePosixPath(page).parent / path).parts:
        if part == ".." and parts:
            parts.pop()
        else:
            parts.append(part)
    return "/".join(parts)


def missing(page, text, paths):
    """(line, path) of every path in the page that does not exist."""
    is_block, above = False, []
    for number, line in enumerate(text.split("\n"), 1):
        if line.strip().startswith("```"):
            is_block, above = not is_block, []
        elif is_block:
            tree = TREE.match(line)
            if tree is None or len(tree[1]) // 2 > len(above):
                continue
            level = len(tree[1]) // 2
            folders = [above[level - 1] + name if level else name for name in tree[2].split()]
            above = [*above[:level], folders[-1]]
            yield from ((number, folder) for folder in folders if not paths.has(folder))
        else:
            targets = [target for target in LINK.findall(line) if linked(page, target)]
            yield from ((number, target) for target in targets if not paths.has(linked(page, target)))
            words = [word for code in CODE.findall(line) for word in code.split()]
            yield from ((number, word) for word in words if not paths.has_code(word))


def main(root):
    files = files_of(root)
    paths = Paths(files)
    pages = sorted(name for name in files
                   if name in ("CONTRIBUTING.md", "README.md") or re.fullmatch(r"[^/]+/README\.md", name))
    count = 0
    for page in pages:
        text = pathlib.Path(root, page).read_text(encoding="utf-8")
        for line, path in missing(page, text, paths):
            print(f"{page}:{line}: there is no {path}")
            count += 1
    if count:
        return 1
    print(f"paths: all that {len(pages)} pages name exist")
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
