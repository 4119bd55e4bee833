#!/usr/bin/env python3
"""Counts lines of code and public types, and draws the includes between folders.

Usage: structure.py [--draw FILE.svg]

Prints the lines of text per folder, and per component the public headers (framework/cmake/public_headers.txt) with the
types that they define. --draw writes the include graph between folders of the libraries and programs, without arrows
that longer paths imply; it needs Graphviz (Debian: graphviz). Status 1 if folders include each other in a cycle, or a
folder includes one above it (tests/packaging/check_layers.py); the reasons are printed.
"""

import argparse
import collections
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/packaging"))
import check_layers  # noqa: E402

PRODUCT = ("framework", "integrators", "robots", "problems")
COLOURS = {"framework": ("#e8f1fb", "#bcd7f3"), "integrators": ("#fdf0e0", "#f8d3a3"),  # a group and its boxes
           "robots": ("#e9f6e9", "#b9e0ba"), "problems": ("#f3ebf8", "#dcc4ea")}
LABELS = {"framework": "saltus.hpp", "problems": "program saltus"}  # files directly in a group's folder
CODE = (".cpp", ".hpp")
COMMENT_OR_STRING = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|^[ \t]*#(?:\\\n|[^\n])*', re.DOTALL | re.MULTILINE)
SCOPE = re.compile(
    r"\bnamespace\s+(?P<namespace>[\w:]*)\s*\{"
    r"|\b(?P<kind>enum\s+(?:class|struct)|enum|class|struct|union)\s+(?:\[\[[^]]*\]\]\s*|alignas\([^)]*\)\s*)*"
    r"(?P<name>\w+)[^;{}()]*\{"
    r"|(?P<open>\{)|(?P<close>\})")

Type = collections.namedtuple("Type", "namespace name kind values")  # values: of an enum, otherwise 0


def types_of(text):
    """The types that a header defines in its namespaces, without those within types, functions and detail."""
    text = COMMENT_OR_STRING.sub("", text)
    found, scopes = [], []
    for match in SCOPE.finditer(text):
        if match["close"]:
            scopes.pop()
        elif match["namespace"] is not None:
            scopes.append(match["namespace"] or "detail")
        else:
            if match["name"] and None not in scopes and "detail" not in "::".join(scopes):
                kind, values = match["kind"].split()[0], 0
                if kind == "enum":
                    body = text[match.end():text.index("}", match.end())]
                    values = sum(bool(value.strip()) for value in body.split(","))
                found.append(Type("::".join(scopes), match["name"], kind, values))
            scopes.append(None)
    return found


def tracked():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [pathlib.PurePosixPath(line) for line in listed.splitlines()]


def lines_of(path):
    data = (ROOT / path).read_bytes() if (ROOT / path).is_file() else b""
    return 0 if b"\0" in data else data.count(b"\n")


def print_lines(paths):
    folders = collections.Counter()
    total = product = 0
    for path in paths:
        count = lines_of(path)
        total += count
        if path.suffix in CODE and path.parts[0] in PRODUCT:
            product += count
            folders[check_layers.folder_of(path)] += count
    print("lines of C++")
    for folder, count in sorted(folders.items()):
        print(f"  {folder:<28}{count:>8}")
    for top in PRODUCT:
        print(f"  {top + ', all':<28}{sum(n for folder, n in folders.items() if folder.split('/')[0] == top):>8}")
    print(f"  {'product':<28}{product:>8}")
    print(f"lines of text in the repository {total}")


def print_face():
    headers = check_layers.public_headers(ROOT)
    print(f"{'component':<12}{'headers':>8}{'types':>8}{'options':>8}{'enums':>8}{'values':>8}")
    everything = collections.Counter()
    for component in dict.fromkeys(headers.values()):
        types = [t for header, owner in headers.items() if owner == component for t in types_of((ROOT / header).read_text(encoding="utf-8"))]
        enums = [t for t in types if t.kind == "enum"]
        row = {"headers": sum(owner == component for owner in headers.values()), "types": len(types),
               "options": sum(t.name.endswith(("Options", "Settings")) for t in types),
               "enums": len(enums), "values": sum(t.values for t in enums)}
        everything.update(row)
        print(f"{component:<12}" + "".join(f"{n:>8}" for n in row.values()))
    print(f"{'all':<12}" + "".join(f"{everything[key]:>8}" for key in row))


def reduced(graph):
    """The graph without edges that a longer path replaces."""
    reach = {}

    def reachable(node):
        if node not in reach:
            reach[node] = set(graph[node]).union(*(reachable(target) for target in graph[node]))
        return reach[node]

    return {node: sorted(target for target in targets
                         if not any(target in reachable(other) for other in targets if other != target))
            for node, targets in graph.items()}


def draw(graph, file):
    shown = {node: [t for t in targets if t.split("/")[0] in PRODUCT]
             for node, targets in graph.items() if node.split("/")[0] in PRODUCT and "/templates" not in node}
    reached = {target for targets in shown.values() for target in targets}
    shown = {node: targets for node, targets in shown.items() if targets or node in reached}
    lines = ["digraph folders {", '  node [shape=box, style="filled,rounded", color="#888888", fontname="sans-serif", fontsize=15];',
             '  edge [color="#555555", arrowsize=0.8]; ranksep=0.3; nodesep=0.2; fontname="sans-serif"; fontsize=17;']
    for top in PRODUCT:
        inside = sorted(node for node in shown if node.split("/")[0] == top)
        lines.append(f'  subgraph "cluster_{top}" {{ label="{top}"; style="filled,rounded"; color="{COLOURS[top][0]}";')
        lines += [f'    "{node}" [label="{LABELS.get(node, node.split("/")[-1])}", fillcolor="{COLOURS[top][1]}"];'
                  for node in inside] + ["  }"]
    lines += [f'  "{node}" -> "{target}";' for node, targets in sorted(reduced(shown).items()) for target in targets]
    svg = subprocess.run(["dot", "-Tsvg"], input="\n".join(lines + ["}"]), capture_output=True, text=True, check=True).stdout
    svg = re.sub(r"<!--.*?-->\n?", "", svg, flags=re.DOTALL)
    svg = re.sub(r'<g id="(node|edge|clust)\d.*?</g>', lambda box: box[0].replace("\n", ""), svg, flags=re.DOTALL)  # one line each
    pathlib.Path(file).write_text(svg, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(prog="structure", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draw", metavar="FILE.svg")
    arguments = parser.parse_args()
    print_lines(tracked())
    print_face()
    looked = check_layers.look(ROOT)
    print("\n".join(looked.problems) or "no cycle between folders, no include of a higher layer")
    if arguments.draw and not looked.circle:
        try:
            draw(looked.graph, arguments.draw)
        except FileNotFoundError:
            sys.exit("structure: there is no program dot; install Graphviz (Debian: graphviz)")
    return 1 if looked.problems else 0


if __name__ == "__main__":
    sys.exit(main())
