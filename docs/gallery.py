#!/usr/bin/env python3
"""Writes the list of library problems in the gallery, from the first comments of their source files.

Usage: gallery.py GALLERY.md [--write] [--draw PROGRAM]

The text between `<!-- problems: LETTER -->` and `<!-- end of problems -->` lists the files of problems/library whose
names begin with LETTER: statement, equations, lines of code without comments, picture, and the time to solve from the
table of the page. Without --write the exit status is 1 if the page differs from the sources. --draw runs each problem
with PROGRAM, the program saltus, and draws its trajectory to GALLERY/NAME.svg.
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

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SECTION = re.compile(r"(<!-- problems: (\w) -->\n).*?(<!-- end of problems -->)", re.DOTALL)
TIME = re.compile(r"^\| ([A-Z]\d\d)[a-z]? (\w+) \| [\d.]+ \| ([\d.]+) \|", re.MULTILINE)  # by `sparse`, ms

# ---- pictures ------------------------------------------------------------------------------------

CELL, GAP, PLOT, TITLE = 164, 10, 64, 18  # pixels: width of a cell, space between cells, height of a plot and its title
COLUMNS, MOST_CELLS = 4, 8
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
    return "0" if abs(value) < 1e-4 * extent else f"{value:.3g}"


def svg(rows, modes, channels, inputs):
    """Small plots of the channels over time, next to each other; bands mark modes, orange marks inputs."""
    times = [row[0] for row in rows]
    begin, span = times[0], (times[-1] - times[0]) or 1.0
    shown = channels[:MOST_CELLS]
    columns = min(COLUMNS, len(shown))
    lines = -(-len(shown) // columns)
    width, height = columns * (CELL + GAP) - GAP, lines * (TITLE + PLOT + GAP) + 12
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
           f'font-family="sans-serif" font-size="11"><rect width="{width}" height="{height}" fill="#fff"/>']
    edges = [i for i in range(1, len(modes)) if modes[i] != modes[i - 1]]
    spans = [(times[a], times[b - 1] if b == len(times) else times[b])
             for a, b in zip([0, *edges], [*edges, len(times)])]
    for k, name in enumerate(shown):
        left, top = k % columns * (CELL + GAP), k // columns * (TITLE + PLOT + GAP)
        line = [(row[0], row[k + 1]) for row in rows if math.isfinite(row[k + 1])]  # a phase may lack a channel
        values = [value for _, value in line]
        low, high = min(values), max(values)
        extent = high - low
        if extent <= 1e-9 * max(1.0, abs(low)):
            low, extent = low - 1.0, 2.0

        def x(t, left=left):
            return left + CELL * (t - begin) / span

        def y(value, top=top, low=low, extent=extent):
            return top + TITLE + 3 + (PLOT - 6) * (1.0 - (value - low) / extent)

        colour = INPUT if name in inputs else STATE
        title = name if len(name) <= 16 else name[:15].rstrip() + "..."
        out.append(f'<text x="{left}" y="{top + 12}" fill="{colour}">{html.escape(title)}</text>')
        if max(values) > min(values):
            out.append(f'<text x="{left + CELL}" y="{top + 12}" text-anchor="end" fill="#666" font-size="9">'
                       f"{short(min(values), extent)} to {short(max(values), extent)}</text>")
        out.append(f'<rect x="{left}" y="{top + TITLE}" width="{CELL}" height="{PLOT}" fill="none" stroke="#ccc"/>')
        for a, b in spans[1::2]:
            out.append(f'<rect x="{x(a):.1f}" y="{top + TITLE}" width="{x(b) - x(a):.1f}" height="{PLOT}" fill="{BAND}"/>')
        points = simplified([(x(t), y(value)) for t, value in line])
        path = " ".join(f"{a:.1f},{b:.1f}" for a, b in points)
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.6"/>')
    out.append(f'<text x="0" y="{height - 4}" fill="#666" font-size="9">t = {short(begin)} to {short(times[-1])}'
               f'{"; the bands are the modes" if edges else ""}</text></svg>')
    return "\n".join(out) + "\n"


def case_name(program, name):
    """The first case of a file among the problems that the program lists, such as b14a_hanging_chain; None without one."""
    listed = subprocess.run([program, "list"], capture_output=True, text=True, check=True).stdout
    number, _, _ = name.partition("_")
    found = re.search(rf"^  ({number}[a-z]?_\w+) ", listed, re.MULTILINE)
    return found[1] if found else None


def draw(program, name, folder):
    """True if the program runs the problem and a picture was drawn."""
    case = case_name(program, name)
    if not case:
        return False
    with tempfile.TemporaryDirectory() as out:
        done = subprocess.run([program, "run", case, "--out", out, "--pictures", "false"], capture_output=True, check=False)
        table = os.path.join(out, "trajectory.csv")
        if done.returncode != 0 or not os.path.exists(table):
            return False
        with open(table, encoding="utf-8", newline="") as file:
            titles, *rows = list(csv.reader(file))
    has_modes = titles[1] == "mode"
    first = 2 if has_modes else 1
    with open(os.path.join(ROOT, "problems", "library", name + ".cpp"), encoding="utf-8") as file:
        listed = re.search(r"\.inputs = \{(.*?)\}", file.read(), re.DOTALL)
    inputs = re.findall(r'"(.*?)"', listed[1]) if listed else []
    values = [[float(cell) if cell else math.nan for cell in [row[0], *row[first:]]] for row in rows]
    text = svg(values, [row[1] if has_modes else "" for row in rows], titles[first:], inputs)
    with open(os.path.join(folder, name + ".svg"), "w", encoding="utf-8") as file:
        file.write(text)
    return True


# ---- equations -----------------------------------------------------------------------------------

GREEK = {"theta", "tau", "mu", "pi", "rho", "omega", "xi", "Xi", "Omega"}
FUNCTIONS = {"sin", "cos", "tan", "exp", "ln", "min", "max"}
LETTERS = {"xbar": r"\bar x", "tf": "t_f", "ts": "t_s", "Cd": "C_d", "cL": "c_L", "Re": "R_e", "Px": "P x", "int": r"\int",
           "sum": r"\sum", "dt": r"\,\mathrm{d}t"}
WORDS = {"at", "in", "is", "or", "of", "by", "if", "to", "on", "a"}
UNIT = re.compile(r" (m|s|N|kg|kN/m)(?=,| in |$)")
TOKEN = re.compile(r"(?P<gap>\s{2,})|(?P<blank>\s)|(?P<fraction>\d+/\d+(?![\w.]))|(?P<power>\d+(?:\.\d+)?e-?\d+)"
                   r"|(?P<number>\d+(?:\.\d+)?)|(?P<name>[A-Za-z]+\d*)(?P<sub>_\w+)?(?P<primes>'*)"
                   r"|(?P<relation><=|>=|->|\*)|(?P<other>.)")
RELATIONS = {"<=": r"\le ", ">=": r"\ge ", "->": r"\to ", "*": r"\cdot "}


def closing(text, begin, pair="()"):
    """Position of the bracket that closes the one at `begin`."""
    depth = 0
    for i in range(begin, len(text)):
        depth += (text[i] == pair[0]) - (text[i] == pair[1])
        if depth == 0:
            return i
    raise ValueError(f"no bracket closes '{text[begin:]}'")


def tex_of_name(name, sub, primes, after):
    """A variable; None if the name is a word."""
    if name in FUNCTIONS:
        return f"\\{name}"
    letters, digits = re.fullmatch(r"([A-Za-z]+)(\d*)", name).groups()
    if letters in LETTERS:
        base = LETTERS[letters]
    elif letters in GREEK:
        base = f"\\{letters}"
    elif len(letters) == 2 and letters[1] in "xyz" and letters not in WORDS:
        base = f"{letters[0]}_{letters[1]}"
    elif len(letters) == 1:
        base = letters
    else:
        return None
    index = digits or (sub or "").removeprefix("_")
    index = index if len(index) <= 1 or index.isdigit() else f"\\text{{{index}}}"
    if primes and re.match(r"[A-Za-z]| [PQ] ", after):  # a transpose
        return f"{base}{f'_{{{index}}}' if index else ''}^{{\\top}}"
    if primes:
        dot = {1: "dot", 2: "ddot"}[len(primes)]
        head, _, tail = base.partition("_")
        base = f"\\{dot}{{{head}}}" + (f"_{tail}" if tail else "")
    return base + (f"_{{{index}}}" if index else "")


def tex_of_line(text):
    out, place, words, depth = [], 0, [], 0

    def end_words():
        if words:
            space = " " if out and not out[-1].endswith(("quad ", "(")) else ""
            out.append(f"\\text{{{space}{' '.join(words)} }}")
            words.clear()

    while place < len(text):
        if text.startswith("sqrt(", place):
            end_words()
            end = closing(text, place + 4)
            out.append(f"\\sqrt{{{tex_of_line(text[place + 5:end])}}}")
            place = end + 1
            continue
        if text[place] == "[":
            end_words()
            end = closing(text, place, "[]")
            rows = [re.split(r"\s{2,}" if re.search(r"\S\s{2,}\S", row) else r"\s+", row.strip())
                    for row in text[place + 1:end].split(";")]
            out.append(r"\begin{bmatrix}" + r" \\ ".join(" & ".join(map(tex_of_line, row)) for row in rows)
                       + r"\end{bmatrix}")
            place = end + 1
            continue
        match = TOKEN.match(text, place)
        place = match.end()
        if match["gap"]:
            end_words()
            out.append(" " if out and out[-1] == "=" else r"\quad ")
        elif match["blank"]:
            if not words:
                out.append(" ")
        elif match["name"]:
            tex = tex_of_name(match["name"], match["sub"], match["primes"], text[place:])
            if tex is None or match["name"] in WORDS and (words or re.match(r" [a-z]{2}", text[place:])):
                words.append(match[0])
            else:
                end_words()
                superscript = re.match(r"\^(-?[\w.]+)", text[place:])
                sign = re.match(r"[+-](?=[\s;,)]|$)", text[place:])
                if superscript:
                    tex += f"^{{{superscript[1]}}}"
                    place += superscript.end()
                elif sign:  # before and after an event
                    tex = f"{tex}^{{{sign[0]}}}" if "^" not in tex else tex
                    place += 1
                out.append(tex + (" " if tex.startswith("\\") else ""))
        else:
            if words and match[0] in ",;.:":
                words[-1] += match[0]
                if match[0] != ".":
                    end_words()
                continue
            end_words()
            if match["fraction"]:
                out.append(r"\tfrac{{{}}}{{{}}}".format(*match[0].split("/")))
            elif match["power"]:
                digits, exponent = match[0].split("e")
                out.append((f"{digits} \\cdot " if digits != "1" else "") + f"10^{{{int(exponent)}}}")
            elif match["relation"]:
                out.append(RELATIONS[match[0]])
            elif match[0] in "^_" and text[place:place + 1] == "(":
                end = closing(text, place)
                out.append(f"{match[0]}{{{tex_of_line(text[place + 1:end])}}}")
                place = end + 1
            elif match[0] == "^":
                power = re.match(r"-?[\w.]+", text[place:])
                out.append(f"^{{{power[0]}}}")
                place += power.end()
            elif match[0] in "{}":
                out.append("\\" + match[0])
            else:
                depth += (match[0] == "(") - (match[0] == ")")
                out.append(r",\;" if match[0] == "," and depth == 0 else match[0])
                unit = UNIT.match(text, place) if match["number"] else None
                if unit:
                    out.append(f"\\,\\text{{{unit[1]}}}")
                    place = unit.end()
    end_words()
    return "".join(out).strip()


def tex(block):
    """The equations of a comment as a block of formulas. An indented line continues the previous line."""
    rows = [("& \\qquad " if line.startswith("    ") else "& ") + tex_of_line(line.strip()) for line in block.splitlines()]
    return "```math\n\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}\n```"


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


def entry(path, times, pictures):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    head = []
    for line in text.splitlines():
        if not line.startswith("//"):
            break
        head.append(line[2:].removeprefix(" "))
    if not head:  # the header has the statement
        with open(path.replace(".cpp", ".hpp"), encoding="utf-8") as file:
            head = [line[2:].removeprefix(" ") for line in file.read().split("#pragma once")[0].splitlines()]
    blocks = re.split(r"\n\s*\n", "\n".join(head).strip("\n"))
    statement = blocks[0]
    equations = [block for block in blocks[1:] if block.startswith("  ")]
    name = os.path.basename(path).removesuffix(".cpp")
    number, _, title = name.partition("_")
    solved = f", {' and '.join(times[number.upper()])} ms" if number.upper() in times else ""
    shown = [f"**{number.upper()} {title}** ([{name}.cpp](../problems/library/{name}.cpp), {code_lines(text)} lines{solved})",
             "", wrapped(statement), ""]
    if equations:
        shown += [tex(equations[0]), ""]
    if os.path.exists(os.path.join(pictures, name + ".svg")):
        shown += [f"![Trajectory of {name}]({os.path.basename(pictures)}/{name}.svg)", ""]
    return "\n".join(shown)


def files(letter="?"):
    return sorted(glob.glob(os.path.join(ROOT, "problems", "library", f"{letter}[0-9][0-9]_*.cpp")))


def main(page, write, program):
    pictures = os.path.splitext(os.path.abspath(page))[0]
    if program:
        os.makedirs(pictures, exist_ok=True)
        for path in files():
            name = os.path.basename(path).removesuffix(".cpp")
            if not draw(program, name, pictures):
                print(f"gallery: {name} was not drawn, because the program does not run it", file=sys.stderr)
    with open(page, encoding="utf-8") as file:
        shown = file.read()
    times = {}
    for number, _, milliseconds in TIME.findall(shown):
        times.setdefault(number, []).append(milliseconds)
    made = SECTION.sub(lambda match: match[1] + "\n" + "\n".join(entry(path, times, pictures) for path in files(match[2]))
                       + match[3], shown)
    if write:
        with open(page, "w", encoding="utf-8") as file:
            file.write(made)
    elif made != shown:
        sys.exit(f"{page} differs from the sources of the library: docs/gallery.py {page} --write updates it")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="gallery", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--draw", metavar="PROGRAM")
    given = parser.parse_args()
    main(given.page, given.write, given.draw)
