"""Runs as arrays with names and units."""

import collections.abc
import glob
import json
import os
import re
import shutil
import subprocess

import numpy as np

from .tables import read_table

_WITH_UNIT = re.compile(r"(.*\S) \[(.*)\]$")


class SaltusError(RuntimeError):
    """The program ended with a status other than 0. Holds its message and `status`."""

    def __init__(self, sentence, status):
        super().__init__(sentence)
        self.status = status


class Table(collections.abc.Mapping):
    """Columns of a CSV file by name, in order: arrays of numbers (empty cells are NaN) or of texts.

    `table["height"]` and `table["height [m]"]` are the same column, and `table.units["height"]` is "m". Columns that
    differ only in their unit keep it in their names.
    """

    def __init__(self, columns):
        self.units, self._columns, self._full = {}, {}, {}
        matches = {full: _WITH_UNIT.match(full) for full in columns}
        short = {full: match.group(1) if match else full for full, match in matches.items()}
        for full, values in columns.items():
            name = short[full] if list(short.values()).count(short[full]) == 1 else full
            self.units[name] = matches[full].group(2) if matches[full] else ""
            self._columns[name] = np.asarray(values)
            self._full[full] = name

    def __getitem__(self, name):
        return self._columns[self._full.get(name, name)]

    def __iter__(self):
        return iter(self._columns)

    def __len__(self):
        return len(self._columns)

    def __repr__(self):
        rows = len(next(iter(self._columns.values()))) if self._columns else 0
        return f"<Table: {rows} rows of {', '.join(self._full)}>"

    @property
    def time(self):
        """Column t, s."""
        return self["t"]

    def numbers(self):
        """The columns that hold numbers, without the time."""
        return [name for name in self if name != "t" and self[name].dtype.kind == "f"]


class Run:
    """The folder of a run: every table as a `Table`, summary.json as `summary`."""

    def __init__(self, folder):
        self.folder = os.path.abspath(folder)
        files = sorted(glob.glob(os.path.join(glob.escape(self.folder), "*.csv")))
        if not files:
            raise FileNotFoundError(f"{folder}: this is not the folder of a run with tables (.csv)")
        self.summary = {}
        summary = os.path.join(self.folder, "summary.json")
        if os.path.exists(summary):
            with open(summary, encoding="utf-8") as file:
                self.summary = json.load(file)
        self.tables = {os.path.basename(file)[:-len(".csv")]: Table(read_table(file)) for file in files}

    @property
    def trajectory(self):
        return self.tables["trajectory"]

    @property
    def config(self):
        """The settings as YAML, in the format of `--config`."""
        with open(os.path.join(self.folder, "config.yaml"), encoding="utf-8") as file:
            return file.read()

    def timed_tables(self):
        """The tables whose rows are instants, by name."""
        return {name: table for name, table in self.tables.items() if "t" in table and len(table.time)}

    def plot(self):
        """Draws all pictures of the folder again and returns their paths."""
        from .plot import redraw
        return redraw(self.folder)

    def to_mat(self, path):
        """Writes a MAT file (v7.3) in the layout of robometry; needs h5py."""
        from .logs import write_mat
        write_mat(self, path)

    def to_mcap(self, path):
        """Writes an MCAP file of JSON messages with schemas; needs the package mcap."""
        from .logs import write_mcap
        write_mcap(self, path)

    def __repr__(self):
        return f"<Run in {self.folder}: {', '.join(self.tables)}>"


def load(folder):
    """Loads the run in the folder. Raises FileNotFoundError if there is none."""
    return Run(folder)


def _program():
    named = os.environ.get("SALTUS_PROGRAM") or shutil.which("saltus")
    if not named:
        raise FileNotFoundError("saltus is not on the PATH; set SALTUS_PROGRAM to the program")
    return named


def run(problem, out=None, config=None, **settings):
    """Executes `saltus run problem`, then load(). Settings are keywords with __ for the dot: push__impulse=6.

    Without `out` the results are in results/PROBLEM. Raises SaltusError with the program's message if
    the program rejects the settings or the solver does not converge.
    """
    words = [_program(), "run", problem]
    if config is not None:
        words += ["--config", os.fspath(config)]
    for key, value in settings.items():
        if isinstance(value, bool):
            value = "true" if value else "false"
        elif isinstance(value, (list, tuple, np.ndarray)):
            value = ",".join(repr(float(entry)) for entry in value)
        words += ["--set", f"{key.replace('__', '.')}={value}"]
    folder = os.fspath(out) if out is not None else os.path.join("results", problem)
    words += ["--out", folder]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sentences = (done.stderr.strip() or done.stdout.strip()).splitlines()
        raise SaltusError(sentences[-1] if sentences else "saltus failed", done.returncode)
    return load(folder)
