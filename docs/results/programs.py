"""Runs of the program saltus for tables and pictures."""

import csv
import glob
import hashlib
import json
import os
import subprocess
import sys


ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PACKAGE = os.path.join(ROOT, "python")
sys.path.append(PACKAGE)

from saltus.children import end_with_parent  # noqa: E402
from saltus.whole_file import write_text  # noqa: E402


class NotHere(Exception):
    """A requirement is missing on this machine; the sentence names it and its source."""


def call(command, good=(0, 3), folder=None, environment=None):
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder, env=environment,
                          preexec_fn=end_with_parent)
    if done.returncode not in good:
        raise RuntimeError(f"{' '.join(command)}: status {done.returncode}\n{done.stderr}")
    return done


def draw(module, *arguments):
    """Runs a module of saltus.walking."""
    call([sys.executable, "-B", "-m", f"saltus.walking.{module}", *arguments],
         environment={**os.environ, "PYTHONPATH": PACKAGE, "PYTHONSAFEPATH": "1"})


UNKNOWN = "kept, from an unknown version"


def read_bytes(path):
    """None if there is no such file."""
    if not os.path.exists(path):
        return None
    with open(path, "rb") as file:
        return file.read()


def is_whole(folder):
    """True if a run has ended there by itself. An interrupted run keeps its results, too."""
    try:
        with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
            return not json.load(file)["reason"].startswith("interrupted")
    except FileNotFoundError:
        return False


class Programs:
    """Makes every run once, in a separate folder below `folder`."""

    def __init__(self, program, folder, jobs):
        self.program, self.folder, self.jobs = program, folder, jobs
        self.pictures = {}  # pictures of tables: path in the project -> file
        self.maps = set()  # folders of complete runs
        self.versions = set()  # versions of the programs that made the checked runs

    def _folder(self, kind, what):
        digest = hashlib.sha1(json.dumps(what, sort_keys=True).encode()).hexdigest()[:16]
        return os.path.join(self.folder, f"{kind}-{digest}")

    def version(self):
        return call([self.program, "--version"]).stdout.strip()

    def _noted(self, note):
        """Maps and tables do not contain the versions of their programs, so a file next to them has one line for each."""
        if not os.path.exists(note):
            return {UNKNOWN}
        with open(note, encoding="utf-8") as file:
            return set(file.read().splitlines())

    def _note(self, note, versions):
        write_text(note, "\n".join(sorted(versions)))

    def made_by(self):
        """The versions of the runs checked since the last call. A kept run has its own version."""
        versions, self.versions = self.versions or {self.version()}, set()
        return ", ".join(sorted(versions))

    def run(self, settings, pictures=False):
        """summary.json of a run of push recovery, with its folder."""
        folder = self.run_folder(settings, pictures)
        with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
            summary = json.load(file)
        self.versions.add("saltus {version} ({commit})".format(**summary["saltus"]))
        return {**summary, "folder": folder}

    def run_folder(self, settings, pictures=False):
        out = self._folder("run", [settings, pictures])
        if not is_whole(out):
            command = [self.program, "run", "push_recovery", "--out", out,
                       "--pictures", "true" if pictures else "false"]
            for key, value in settings.items():
                command += ["--" + key, str(value)]
            call(command)
        return out

    def outcome(self, settings):
        """The summary of a long run, whose tables (more than 100 MB per minute) are deleted."""
        summary = self.run(settings)
        for table in glob.glob(os.path.join(summary["folder"], "*.csv")):
            os.remove(table)
        return summary

    def suite(self, solver, only="", repeat=0):
        """The output of `saltus suite --json`; `repeat` numbers repeated runs."""
        out = self._folder("suite", [solver, only, *([repeat] if repeat else [])]) + ".json"
        if not os.path.exists(out):
            call([self.program, "suite", "--set", f"solver={solver}", "--json", out]
                 + (["--only", only] if only else []))
            self._note(out + ".made_by", {self.version()})
        self.versions |= self._noted(out + ".made_by")
        with open(out, encoding="utf-8") as file:
            return json.load(file)

    def survival_map(self, *arguments):
        """The folder of a map: map.csv and map.png. An interrupted map is continued, and then comes from two programs."""
        out = self._folder("map", arguments)
        table, note = os.path.join(out, "map.csv"), os.path.join(out, "made_by")
        if out not in self.maps:
            before = read_bytes(table)
            known = set() if before is None else self._noted(note)
            os.makedirs(out, exist_ok=True)
            self._note(note, known | {self.version()})  # before a cell is run, because the map may be interrupted again
            call([self.program, "map", *arguments, "--out", out, "--jobs", str(self.jobs)])
            if read_bytes(table) == before:
                self._note(note, known)
            self.maps.add(out)
        self.versions |= self._noted(note)
        return out

    def beside(self, name, *arguments):
        """The output of a program of benchmarks/, as a file."""
        program = os.path.join(os.path.dirname(self.program), name)
        table = os.path.join(self.folder, "_".join([name, *arguments]) + ".csv")
        if not os.path.exists(table):
            if not os.path.exists(program):
                raise NotHere(f"the program {name} is not built; it is a target of the build")
            write_text(table, call([program, *arguments], good=(0,)).stdout)
            self._note(table + ".made_by", {self.version()})
        self.versions |= self._noted(table + ".made_by")
        return table

    def drawn(self, name, module):
        """The output of a program of benchmarks/ and its picture, as files."""
        table, picture = self.beside(name), os.path.join(self.folder, name + ".png")
        draw(module, table, picture)
        return table, picture

    def new_robot(self, urdf):
        """run.yaml of a robot, written by `saltus robot new`."""
        out = self._folder("robot", urdf)
        if not os.path.exists(os.path.join(out, "run.yaml")):
            call([self.program, "robot", "new", urdf, "--out", out], good=(0,))
        return os.path.join(out, "run.yaml")


def rows_of(folder, name="map.csv"):
    """The rows of a table, by the names of its columns without units."""
    with open(os.path.join(folder, name), encoding="utf-8", newline="") as file:
        return [{column.split(" [")[0]: cell for column, cell in row.items()} for row in csv.DictReader(file)]


def humanoid(package, path):
    """A URDF of another robot, from a package of PyPI installed for this Python or in the virtual environment that
    SALTUS_HUMANOIDS names."""
    roots = [os.environ.get("SALTUS_HUMANOIDS"), sys.prefix]
    for root in filter(None, roots):
        for folder, _, _ in os.walk(root):
            candidate = os.path.join(folder, path)
            if os.path.exists(candidate):
                return candidate
    raise NotHere(f"{os.path.basename(path)} comes with the package {package} of PyPI: install it into a "
                  "virtual environment and name that in SALTUS_HUMANOIDS")
