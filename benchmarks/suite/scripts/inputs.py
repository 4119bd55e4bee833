"""What results depend on besides version, machine and packages: the program's own file, and files that are named from outside.
Told by their SHA-256, so that a change is seen whatever their dates say."""

import hashlib
import os

import campaign
import data_problems
from hpipm import OWN_LIBRARY, libraries_of
from program import path_of_program


def digest(path, *more):
    """Of a file, and of words beside it."""
    with open(path, "rb") as file:
        found = hashlib.sha256(file.read())
    for word in more:
        found.update(str(word).encode())
    return found.hexdigest()


def of_files(paths):
    """By name, of those that are there."""
    return {name: digest(path) for name, path in sorted(paths.items()) if os.path.isfile(path)}


def of_the_suite():
    return digest(path_of_program())


def of_run(tasks):
    """Data that the tasks read, and libraries of solvers that are no packages."""
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
    """Files that settings name; of tables also their scripts, the pages that they stand in and the programs beside `saltus`."""
    named = [text.partition("=")[2] for text in settings or ()]
    return of_files({**{name: name for name in named}, **(campaign.files_of_tables() if what == "reproduce" else {})})
