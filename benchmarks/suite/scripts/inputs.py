"""Inputs that determine results besides version, machine and packages: the program file, and files named by the user.
They are identified by SHA-256, so a change is detected independent of dates."""

import hashlib
import os

import campaign
import data_problems
from hpipm import OWN_LIBRARY, libraries_of
from program import path_of_program


def digest(path, *more):
    """Hash of a file and additional words."""
    with open(path, "rb") as file:
        found = hashlib.sha256(file.read())
    for word in more:
        found.update(str(word).encode())
    return found.hexdigest()


def of_files(paths):
    """Hashes by name, of existing files."""
    return {name: digest(path) for name, path in sorted(paths.items()) if os.path.isfile(path)}


def of_the_suite():
    return digest(path_of_program())


def of_run(tasks):
    """Data files that tasks read, and libraries of solvers that are not packages."""
    found = {}
    for problem in sorted({task["problem"] for task in tasks}):
        source = data_problems.source_of(problem)
        if source:
            found[problem] = digest(*source)
    libraries = {}
    if any(solver.startswith("hpipm") for task in tasks for solver in task["solvers"]):
        libraries = libraries_of(os.environ.get(OWN_LIBRARY, ""))
    return {**found, **of_files(libraries)}


def of_campaign(what, settings):
    """Files that settings name; for tables also their scripts, their pages and the programs next to `saltus`."""
    named = [text.partition("=")[2] for text in settings or ()]
    return of_files({**{name: name for name in named}, **(campaign.files_of_tables() if what == "reproduce" else {})})
