"""Checks the dependencies: no cycle between folders, and no include of a higher layer.

Usage: check_layers.py ROOT [--list]. Exits with 1 and a line for every include that breaks a rule, or for a cycle with
one include per step. Public headers may include public headers only. --list writes the folders in order of dependence.
"""

import collections
import pathlib
import re
import sys

TOPS = ("framework", "integrators", "robots", "problems", "program", "benchmarks", "tests", "docs", "examples")
# "saltus/ocp/phase.hpp" is framework/saltus/ocp/phase.hpp (SALTUS_INCLUDE_ROOTS of framework/cmake/SaltusTarget.cmake).
INCLUDE_ROOTS = ("framework", "integrators", "robots")
# Forbidden includes by folder; the longest matching name applies.
FORBIDDEN = {
    "framework": ("framework/app", "robots", "problems", "program", "benchmarks", "tests", "docs", "examples"),
    "integrators": ("framework/app", "robots", "problems", "program", "benchmarks", "tests", "docs", "examples"),
    "robots": ("framework/app", "problems", "program", "benchmarks", "tests", "docs", "examples"),
    "problems": ("program", "benchmarks", "tests", "docs", "examples"),
    "benchmarks": ("program", "tests", "docs", "examples"),
    "program": ("tests", "docs", "examples"),
    "tests/qp": ("problems", "program", "docs", "examples"),
    # These folders use installed headers only, by their installed names.
    "examples": ("framework", "problems", "program", "benchmarks", "tests", "docs"),
    "docs": ("problems", "program", "benchmarks", "tests", "examples"),
}
# Files that must not include these folders and headers, even indirectly: a robot's computer runs them without a
# simulator and without the application.
CONTROLLER = ("robots/saltus/robots/control/control_process.cpp", "robots/saltus/robots/walking/balance_controller.cpp",
              "robots/saltus/robots/whole_body/sensor_estimator.cpp",
              "robots/saltus/robots/whole_body/inverse_dynamics_controller.cpp",
              "robots/saltus/robots/whole_body/momentum_controller.cpp")
NOT_FOR_CONTROLLERS = ("framework/app", "framework/simulation", "robots/dart", "robots/mujoco", "robots/simulation",
                       "robots/saltus/robots/whole_body/plant.hpp", "robots/saltus/robots/centroidal/centroidal_plant.hpp")
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]', re.M)


def folder_of(path):
    """The unit of a file: framework/ocp, robots/dart, integrators, tests/qp, ..."""
    parts = path.parts
    if parts[0] in INCLUDE_ROOTS and parts[1] == "saltus":
        below = parts[2:]
        parts = below if below[0] == parts[0] else (parts[0], *below)
    if parts[0] in ("framework", "robots", "problems", "tests") and len(parts) > 2:
        return "/".join(parts[:2])
    return parts[0]


def resolve(root, including, included):
    """The file that an include names, relative to the root, or None for a header of another package."""
    path = pathlib.PurePosixPath(included)
    if path.parts[0] == "saltus" and len(path.parts) > 1:
        top = path.parts[1] if path.parts[1] in INCLUDE_ROOTS else "framework"
        return top / path
    if path.parts[0] in TOPS:
        return path
    beside = including.parent / path
    return beside if (root / beside).exists() else None


def is_below(folder, top):
    return folder == top or folder.startswith(top + "/")


def rules_for(folder):
    names = [name for name in FORBIDDEN if is_below(folder, name)]
    return FORBIDDEN[max(names, key=len)] if names else ()


def circle(graph):
    """A cycle of folders, or an empty list."""
    state, trail = {}, []

    def visit(node):
        state[node] = "open"
        trail.append(node)
        for target in sorted(graph.get(node, ())):
            if state.get(target) == "open":
                return trail[trail.index(target):] + [target]
            if target not in state:
                found = visit(target)
                if found:
                    return found
        trail.pop()
        state[node] = "done"
        return []

    for node in sorted(graph):
        if node not in state:
            found = visit(node)
            if found:
                return found
    return []


def in_order(graph):
    order, seen = [], set()

    def visit(node):
        if node in seen:
            return
        seen.add(node)
        for target in sorted(graph.get(node, ())):
            visit(target)
        order.append(node)

    for node in sorted(graph):
        visit(node)
    return order


def public_headers(root):
    """The component of every public header (framework/cmake/public_headers.txt), by its path."""
    listing, public = root / "framework/cmake/public_headers.txt", {}
    if listing.exists():
        for line in listing.read_text(encoding="utf-8").splitlines():
            if line and not line.startswith("#"):
                component, name = line.split()[:2]
                pattern = resolve(root, pathlib.PurePosixPath("."), "saltus/" + name)
                public.update({path.relative_to(root).as_posix(): component for path in sorted(root.glob(pattern.as_posix()))})
    return public


def private_includes(root):
    """A line for every include of a public header (framework/cmake/public_headers.txt) that is not public itself."""
    public = public_headers(root)
    lines = []
    for header in sorted(public):
        for included in INCLUDE.findall((root / header).read_text(encoding="utf-8")):
            target = resolve(root, pathlib.PurePosixPath(header), included)
            if target is not None and target.as_posix() not in public:
                lines.append(f"{header}: is public and includes {included}, which is not (framework/cmake/public_headers.txt)")
    return lines


def simulators_of_the_controller(root):
    """A line for every header behind a file of the controller that belongs to a simulator, a plant or the application."""
    lines = []
    for file in CONTROLLER:
        including = {pathlib.PurePosixPath(file): None}
        waiting = [path for path in including if (root / path).exists()]
        while waiting:
            path = waiting.pop()
            if any(is_below(folder_of(path), top) or path.as_posix() == top for top in NOT_FOR_CONTROLLERS):
                lines.append(f"{file}: the controller must not include {path}, not even through {including[path]}")
                continue
            for included in INCLUDE.findall((root / path).read_text(encoding="utf-8")):
                target = resolve(root, path, included)
                if target is not None and target not in including and (root / target).exists():
                    including[target] = path
                    waiting.append(target)
    return lines


def links_of_the_application(root):
    """A line for every CMakeLists.txt of a library, except that of app itself, that names the target of app."""
    lines = []
    for top in INCLUDE_ROOTS:
        for file in sorted((root / top / "saltus").rglob("CMakeLists.txt")):
            name = pathlib.PurePosixPath(file.relative_to(root).as_posix())
            if folder_of(name) != "framework/app" and re.search(r"\bsaltus(::|_)app\b", file.read_text(encoding="utf-8")):
                lines.append(f"{name}: a library must not link saltus::app")
    return lines


Looked = collections.namedtuple("Looked", "problems graph circle files")


def look(root):
    """The includes that break a rule, and the folders that each folder includes."""
    problems, graph, example = [], collections.defaultdict(set), {}
    files = 0
    for top in TOPS:
        for file in sorted((root / top).rglob("*")):
            if file.suffix not in (".hpp", ".cpp", ".in") or not file.is_file():
                continue
            files += 1
            including = pathlib.PurePosixPath(file.relative_to(root).as_posix())
            folder = folder_of(including)
            graph.setdefault(folder, set())
            for included in INCLUDE.findall(file.read_text(encoding="utf-8")):
                target = resolve(root, including, included)
                if target is None:
                    continue
                # tests/packaging builds separate projects with their own headers.
                if not (root / target).exists():
                    problems.append(f"{including}: includes {included}, which does not exist")
                    continue
                used = folder_of(target)
                if used == folder:
                    continue
                broken = [top for top in rules_for(folder) if is_below(used, top)]
                if broken and not (folder == "examples" and included.startswith("saltus/")):
                    problems.append(f"{including}: {folder} must not include {used} ({included})")
                graph[folder].add(used)
                example.setdefault((folder, used), f"{including} includes {included}")
    problems += private_includes(root)
    problems += links_of_the_application(root)
    problems += simulators_of_the_controller(root)
    round_trip = circle(graph)
    if round_trip:
        problems.append("a cycle between folders: " + " -> ".join(round_trip))
        problems += ["  " + example[step] for step in zip(round_trip, round_trip[1:])]
    return Looked(problems, graph, round_trip, files)


def main(arguments):
    problems, graph, _, files = look(pathlib.Path(arguments[0]))
    if "--list" in arguments:
        for folder in in_order(graph):
            print(f"{folder}: {' '.join(sorted(graph[folder]))}")
    if problems:
        print("\n".join(problems))
        return 1
    print(f"layers: {files} files in {len(graph)} folders, no cycle, no include of a higher layer")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
