#!/usr/bin/env python3
"""Writes the list of library problems in the gallery, from the first comments of their source files.

The page contains the typeset equations of each problem and a checksum of the comment with these equations. If the
comment changes, the equations must be typeset again.

Usage: gallery.py GALLERY.md [--write] [--draw PROGRAM]

The column Lines of the table of programs has the lines of code of the linked .cpp files. For a linked page it has the
smallest and the largest number of its programs, which are in the folder with the name of the page.

The text between `<!-- problems: LETTER -->` and `<!-- end of problems -->` lists the files of problems/library whose
names begin with LETTER: statement, equations, lines of code without comments, picture, and the solve time from the
table of the page. Without --write the exit status is 1 if the page differs from the sources. --draw runs each problem
with PROGRAM, the program saltus, and draws its trajectory to GALLERY/NAME.svg. The program mode_search next to it
solves the problems whose sequence of modes is searched.
"""

import argparse
import csv
import glob
import html
import math
import os
import re
import subprocess
import sys
import tempfile
import textwrap
import zlib

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SECTION = re.compile(r"(<!-- problems: (\w) -->\n).*?(<!-- end of problems -->)", re.DOTALL)
EQUATIONS = re.compile(r"\[(\w+)\.cpp\]\([^\n]*<!-- (\w+) -->\n.*?(```math\n.*?\n```)", re.DOTALL)
PROGRAMS = re.compile(r"^(\| \[[^|\n]*\) \| )[\w ,]+( \|)", re.MULTILINE)  # first column: links to programs or pages
TIME = re.compile(r"^\| ([A-Z]\d\d)[a-z]? (\w+) \| [\d.]+ \| ([\d.]+) \|", re.MULTILINE)  # by `sparse`, ms

# ---- pictures ------------------------------------------------------------------------------------

CELL, GAP, PLOT, LINE = 164, 10, 64, 14  # pixels: width of a cell, space between cells, height of a plot and of text
BESIDE, MOST_LETTERS = 16, 26  # number of letters of a title that fit next to the range of its values, and into a cell
COLUMNS, MOST_CELLS = 4, 12
# Arguments of mode_search for the problems that it solves, and the names of states and inputs in its table.
SEARCHED = {
    "s01_cart_between_walls": ("walls 20 20 plan", ["cart p [m]", "angle theta", "p' [m/s]", "theta' [rad/s]"], ["force u [N]"]),
    "s02_thermostats": ("thermostats 24 5 plan", ["T1 [deg C]", "T2 [deg C]", "T3 [deg C]"], []),
    "s03_two_tanks": ("tanks 20 5 plan", ["level h1 [m]", "level h2 [m]"], ["outflow v"]),
    "s04_fishing_modes": ("fishing 9 plan", ["prey x1", "predators x2"], []),
}
NO_PICTURE = {"c01_mpc_qps": "There is no picture, because a quadratic program from a file has no trajectory."}
WRENCH = ("fx [N]", "fy [N]", "fz [N]", "mx [Nm]", "my [Nm]", "mz [Nm]")  # as in wrench_names()
STATE, INPUT, BAND = "#1f6fb4", "#d9661f", "#eef1f5"


def simplified(points, tolerance=0.4):
    """The points of a line without those within `tolerance` pixels of it (Ramer, Douglas and Peucker)."""
    keep, parts = {0, len(points) - 1}, [(0, len(points) - 1)]
    while parts:
        first, last = parts.pop()
        (ax, ay), (bx, by) = points[first], points[last]
        length = math.hypot(bx - ax, by - ay)
        farthest, place = tolerance, None
        for i in range(first + 1, last):
            x, y = points[i]
            distance = abs((bx - ax) * (ay - y) - (ax - x) * (by - ay)) / length if length else math.hypot(x - ax, y - ay)
            if distance > farthest:
                farthest, place = distance, i
        if place is not None:
            keep.add(place)
            parts += [(first, place), (place, last)]
    return [points[i] for i in sorted(keep)]


def short(value, extent=1.0):
    """Three significant digits, without an exponent from 1e-4 to 1e6."""
    if abs(value) < 1e-4 * extent:
        return "0"
    rounded = float(f"{value:.3g}")
    return f"{rounded:.0f}" if 1e3 <= abs(rounded) < 1e6 else f"{rounded:.3g}"


def svg(rows, modes, channels, inputs):
    """Small plots of the channels over time, next to each other; bands mark modes, orange marks inputs."""
    times = [row[0] for row in rows]
    begin, span = times[0], (times[-1] - times[0]) or 1.0
    shown = channels[:MOST_CELLS]
    columns = min(COLUMNS, len(shown))
    lines = -(-len(shown) // columns)
    titles = {name: textwrap.wrap(name, MOST_LETTERS) for name in shown}
    rows_of_text = max(len(title) + (len(title[-1]) > BESIDE) for title in titles.values())  # the last line has the range
    head = rows_of_text * LINE + 4
    width, height = columns * (CELL + GAP) - GAP, lines * (head + PLOT + GAP) + 12
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
           f'font-family="sans-serif" font-size="11"><rect width="{width}" height="{height}" fill="#fff"/>']
    edges = [i for i in range(1, len(modes)) if modes[i] != modes[i - 1]]
    spans = [(times[a], times[b - 1] if b == len(times) else times[b])
             for a, b in zip([0, *edges], [*edges, len(times)])]
    for k, name in enumerate(shown):
        left, top = k % columns * (CELL + GAP), k // columns * (head + PLOT + GAP)
        line = [(row[0], row[k + 1]) for row in rows if math.isfinite(row[k + 1])]  # a phase may lack a channel
        values = [value for _, value in line]
        low, high = min(values), max(values)
        extent = high - low
        if extent <= 1e-9 * max(1.0, abs(low)):
            low, extent = low - 1.0, 2.0

        def x(t, left=left):
            return left + CELL * (t - begin) / span

        def y(value, top=top, low=low, extent=extent):
            return top + head + 3 + (PLOT - 6) * (1.0 - (value - low) / extent)

        colour = INPUT if name in inputs else STATE
        for row, text in enumerate(titles[name]):
            out.append(f'<text x="{left}" y="{top + 12 + row * LINE}" fill="{colour}">{html.escape(text)}</text>')
        if max(values) > min(values):
            ends = dict.fromkeys((short(min(values), extent), short(max(values), extent)))  # one if printed alike
            out.append(f'<text x="{left + CELL}" y="{top + head - 6}" text-anchor="end" fill="#666" font-size="9">'
                       f"{' to '.join(ends)}</text>")
        out.append(f'<rect x="{left}" y="{top + head}" width="{CELL}" height="{PLOT}" fill="none" stroke="#ccc"/>')
        for a, b in spans[1::2]:
            out.append(f'<rect x="{x(a):.1f}" y="{top + head}" width="{x(b) - x(a):.1f}" height="{PLOT}" fill="{BAND}"/>')
        points = simplified([(x(t), y(value)) for t, value in line])
        path = " ".join(f"{a:.1f},{b:.1f}" for a, b in points)
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.6"/>')
    notes = [f"t = {short(begin)} to {short(times[-1])}", *(["the bands are the modes"] if edges else []),
             *([f"the first {len(shown)} of {len(channels)} quantities"] if len(channels) > len(shown) else [])]
    out.append(f'<text x="0" y="{height - 4}" fill="#666" font-size="9">{"; ".join(notes)}</text></svg>')
    return "\n".join(out) + "\n"


def case_name(program, name):
    """The first case of a file among the problems that the program lists, such as b14a_hanging_chain; None without one."""
    listed = subprocess.run([program, "list"], capture_output=True, text=True, check=True).stdout
    number, _, _ = name.partition("_")
    found = re.search(rf"^  ({number}[a-z]?_\w+) ", listed, re.MULTILINE)
    return found[1] if found else None


def searched(program, name):
    """The table of the best sequence of modes and the names of its inputs. Mode names have no phase number here."""
    words, states, inputs = SEARCHED[name]
    search = os.path.join(os.path.dirname(os.path.abspath(program)), "mode_search")
    done = subprocess.run([search, *words.split()], capture_output=True, text=True, check=True)
    _, *rows = csv.reader(done.stdout.splitlines())
    return [["t", "mode", *states, *inputs], *([row[0], row[1].rpartition(" ")[0], *row[2:]] for row in rows)], inputs


def joined(tables):
    """One table of several motions of a scalar state, with a column for each."""
    columns = [re.search(r"trajectory_(\w+)\.csv", path)[1] for path in tables]
    rows = []
    for number, path in enumerate(tables):
        with open(path, encoding="utf-8", newline="") as file:
            rows += [[row[0], *("" if i != number else row[2] for i in range(len(tables)))]
                     for row in list(csv.reader(file))[1:]]
    return [["t", *columns], *sorted(rows, key=lambda row: float(row[0]))]


def run(program, name):
    """The table of a problem and the names of its inputs; None if the program does not run it."""
    if name in SEARCHED:
        return searched(program, name)
    case = case_name(program, name)
    if not case:
        return None
    with open(os.path.join(ROOT, "problems", "library", name + ".cpp"), encoding="utf-8") as file:
        text = file.read()
    listed = re.search(r"\.input(?:s|_names) = \{(.*?)\}", text, re.DOTALL)
    inputs = re.findall(r'"(.*?)"', listed[1]) if listed else []
    if ".inputs = wrench_names()" in text:
        inputs = [f"{foot} {part}" for foot in ("left", "right") for part in WRENCH]
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([program, "run", case, "--out", out, "--pictures", "false"], capture_output=True, check=False)
        motions = sorted(glob.glob(os.path.join(out, "trajectory_*.csv")))
        if motions:
            return joined(motions), inputs
        table = os.path.join(out, "trajectory.csv")
        if not os.path.exists(table):
            return None
        with open(table, encoding="utf-8", newline="") as file:
            return list(csv.reader(file)), inputs


def draw(program, name, folder):
    """True if the program runs the problem and a picture was drawn."""
    table = run(program, name)
    if not table:
        return False
    (titles, *rows), inputs = table
    has_modes = titles[1] == "mode"
    first = 2 if has_modes else 1
    values = [[float(cell) if cell else math.nan for cell in [row[0], *row[first:]]] for row in rows]
    text = svg(values, [row[1] if has_modes else "" for row in rows], titles[first:], inputs)
    with open(os.path.join(folder, name + ".svg"), "w", encoding="utf-8") as file:
        file.write(text)
    return True


# ---- page ----------------------------------------------------------------------------------------


def wrapped(text, width=118):
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + 1 + len(word) > width:
            lines.append(line)
            line = word
        else:
            line = f"{line} {word}".strip()
    return "\n".join([*lines, line])


def code_lines(text):
    """Lines that are neither blank nor a comment."""
    return sum(1 for line in text.splitlines() if line.strip() and not line.strip().startswith("//"))


def file_lines(path):
    with open(path, encoding="utf-8") as file:
        return code_lines(file.read())


def program_lines(folder, links):
    """The numbers of lines of the linked programs, or the range of those of the programs of a linked page."""
    shown = []
    for link in re.findall(r"\]\(([^)]*)\)", links):
        path = os.path.join(folder, link)
        if path.endswith(".md"):
            sizes = [file_lines(program) for program in glob.glob(path.removesuffix(".md") + "/*.cpp")]
            shown.append(f"{min(sizes)} to {max(sizes)} each")
        else:
            shown.append(str(file_lines(path)))
    return ", ".join(shown)


def entry(path, times, pictures, typeset):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    head = []
    for line in text.splitlines():
        if not line.startswith("//"):
            break
        head.append(line[2:].removeprefix(" "))
    if not head:  # the header contains the statement
        with open(path.replace(".cpp", ".hpp"), encoding="utf-8") as file:
            head = [line[2:].removeprefix(" ") for line in file.read().split("#pragma once")[0].splitlines()]
    blocks = re.split(r"\n\s*\n", "\n".join(head).strip("\n"))
    statement = blocks[0]
    equations = [block for block in blocks[1:] if block.startswith("  ")]
    name = os.path.basename(path).removesuffix(".cpp")
    number, _, title = name.partition("_")
    solved = f", {' and '.join(times[number.upper()])} ms" if number.upper() in times else ""
    checksum, formulas = f"{zlib.crc32(equations[0].encode()):08x}" if equations else "", []
    if equations:
        if typeset.get(name, ("", ""))[0] != checksum:
            sys.exit(f"gallery: typeset the equations of {name} again, below its title with <!-- {checksum} -->:\n{equations[0]}")
        formulas, checksum = [typeset[name][1], ""], f" <!-- {checksum} -->"
    shown = [f"**{number.upper()} {title}** ([{name}.cpp](../problems/library/{name}.cpp), {code_lines(text)} lines{solved})"
             f"{checksum}", "", wrapped(statement), "", *formulas]
    if os.path.exists(os.path.join(pictures, name + ".svg")):
        shown += [f"![Trajectory of {name}]({os.path.basename(pictures)}/{name}.svg)", ""]
    elif name in NO_PICTURE:
        shown += [NO_PICTURE[name], ""]
    return "\n".join(shown)


def files(letter="?"):
    return sorted(glob.glob(os.path.join(ROOT, "problems", "library", f"{letter}[0-9][0-9]_*.cpp")))


def main(page, write, program):
    pictures = os.path.splitext(os.path.abspath(page))[0]
    if program:
        os.makedirs(pictures, exist_ok=True)
        for path in files():
            name = os.path.basename(path).removesuffix(".cpp")
            if name not in NO_PICTURE and not draw(program, name, pictures):
                print(f"gallery: {name} was not drawn, because the program does not run it", file=sys.stderr)
    with open(page, encoding="utf-8") as file:
        shown = file.read()
    times = {}
    for number, _, milliseconds in TIME.findall(shown):
        times.setdefault(number, []).append(milliseconds)
    typeset = {name: (checksum, formulas) for name, checksum, formulas in EQUATIONS.findall(shown)}
    made = SECTION.sub(lambda match: match[1] + "\n"
                       + "\n".join(entry(path, times, pictures, typeset) for path in files(match[2])) + match[3], shown)
    folder = os.path.dirname(os.path.abspath(page))
    made = PROGRAMS.sub(lambda match: f"{match[1]}{program_lines(folder, match[1])}{match[2]}", made)
    if write:
        with open(page, "w", encoding="utf-8") as file:
            file.write(made)
    elif made != shown:
        sys.exit(f"{page} differs from the sources: docs/gallery.py {page} --write updates it")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="gallery", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--draw", metavar="PROGRAM")
    given = parser.parse_args()
    main(given.page, given.write, given.draw)
