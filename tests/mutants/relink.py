"""Programs of a build folder, linked again with some of their objects compiled in another way.

Sources are those of the project or a copy of them in the build folder, where they can be changed; neither the build's
objects nor the project's sources are touched.
"""
import fcntl
import json
import os
import re
import shlex
import shutil
import subprocess
from collections import defaultdict
from contextlib import contextmanager
from functools import cache, cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ("framework", "integrators", "robots", "problems", "tests", "benchmarks")


class Failure(Exception):
    """A sentence for the user."""


@contextmanager
def alone_in(work):
    """Nobody else works in this folder meanwhile."""
    work.mkdir(parents=True, exist_ok=True)
    with open(work / "lock", "w", encoding="utf-8") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise Failure(f"somebody else works in {work}; let that end, or take another --build-dir") from None
        yield


class Build:
    """What the build folder knows: how objects are compiled, what they include, how tests are linked."""

    def __init__(self, folder, work):
        self.folder = folder
        self.work = work  # below the build folder, of one user at a time
        self.tree = self.work / "tree"
        commands = [shlex.split(entry["command"]) for entry in json.loads((folder / "compile_commands.json").read_text())]
        self.commands = {words[words.index("-o") + 1]: words for words in commands}
        self.includers = self._includers()
        self.copy_sources()

    def ninja(self, *words):
        return subprocess.run(["ninja", "-C", str(self.folder), *words], capture_output=True, text=True,
                              check=True).stdout

    def _includers(self):
        """Objects by the file of ours that they include or are made from, relative to the top folder."""
        found, target = defaultdict(set), None
        for line in self.ninja("-t", "deps").splitlines():
            if line and not line[0].isspace():
                target = line.split(":")[0]
            elif line.strip() and target in self.commands:
                path = os.path.realpath(self.folder / line.strip())
                if path.startswith(f"{ROOT}/") and not path.startswith(f"{self.folder}/"):
                    found[os.path.relpath(path, ROOT)].add(target)
        return found

    def copy_sources(self):
        """The copy as the sources are now: what a mutant or an interruption left there is overwritten."""
        wanted = {Path(os.path.relpath(path, ROOT)) for top in SOURCES for path in (ROOT / top).rglob("*.[ch]pp")}
        for path in wanted:
            text, copy = (ROOT / path).read_bytes(), self.tree / path
            if not copy.exists() or copy.read_bytes() != text:
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy.write_bytes(text)

    def compile(self, target, output, *options):
        """Whether an object could be made from the copy."""
        words = []
        for word in self.commands[target]:
            if word == "-Werror":
                continue
            prefix = "-I" if word.startswith("-I") else ""
            path = word[len(prefix):]
            if path == str(ROOT) or path.startswith(f"{ROOT}/") and not path.startswith(f"{self.folder}/"):
                path = f"{self.tree}{path[len(str(ROOT)):]}"
            words.append(prefix + path)
        words[words.index("-o") + 1] = str(output)
        return subprocess.run([*words, "-w", *options], cwd=self.folder, capture_output=True).returncode == 0

    def made(self):
        """An empty folder for programs that are linked anew; their data are beside them as in the build."""
        folder = self.work / "made"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        if (self.folder / "share").exists():
            (folder / "share").symlink_to(self.folder / "share")
        return folder

    def place(self, program):
        """A program as it is, where changed ones are run: what fails there for its place alone would be a false kill."""
        return shutil.copy(self.folder / program, self.made() / program)

    @cache
    def link_command(self, program):
        line = self.ninja("-t", "commands", "-s", program).strip().splitlines()[-1]
        return tuple(shlex.split(line.split(" && ")[1]))

    def members(self, program):
        """Objects of ours that a program is made of, those of libraries too."""
        traced = subprocess.run([*self.link_to(program, self.work / "traced"), "-Wl,-t,-t"], cwd=self.folder,
                                capture_output=True, text=True, check=True).stdout
        found = set()
        for line in traced.splitlines():
            line = line.strip()
            if line in self.commands:
                found.add(line)
            elif member := re.fullmatch(r"\((\S*/)?lib(\w+)\.a\)(\S+)", line):
                folder, name, part = member.groups()
                inside = f"{folder or ''}CMakeFiles/{name}.dir/"
                found |= {target for target in self.by_name[part] if target.startswith(inside)}
        return found

    @cached_property
    def by_name(self):
        """Objects by the last part of their path."""
        found = defaultdict(list)
        for target in self.commands:
            found[target.rsplit("/", 1)[-1]].append(target)
        return found

    def link_to(self, program, output, replaced=None):
        """The command that links a program with objects in place of its own: of libraries the linker
        takes an object only for what nothing before it defines."""
        words = list(self.link_command(program))
        words[words.index("-o") + 1] = str(output)
        replaced = dict(replaced or {})
        words = [str(replaced.pop(word)) if word in replaced else word for word in words]
        at = words.index("-o")
        return words[:at] + [str(path) for path in replaced.values()] + words[at:]

    def link(self, program, output, replaced, *options):
        return subprocess.run([*self.link_to(program, output, replaced), *options], cwd=self.folder,
                              capture_output=True).returncode == 0
