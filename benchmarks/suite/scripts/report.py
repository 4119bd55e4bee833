"""`bench report`: one page that includes all pictures, for offline use and for printing."""

import html
import io
import math
import statistics

import figures
import matrix
import scores
import table
from package import write_text
from task import LADDER, OURS

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 90rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
td, th { padding: .2rem .6rem; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap; }
td:first-child, th:first-child { text-align: left; }
.wide { overflow-x: auto; margin-bottom: 1rem; } .first { font-weight: 700; } .miss { color: #b00020; } .note { color: #555; }
svg { max-width: 100%; height: auto; } pre { background: #f5f5f5; padding: .6rem; white-space: pre-wrap; }
@page { size: A4 landscape; margin: 12mm; }
@media print { body { font-size: 9pt; margin: 0; max-width: none; } .wide { overflow: visible; } td, th { padding: .1rem .3rem;
  white-space: normal; } svg, tr, li, .keep { break-inside: avoid; } h2, h3 { break-after: avoid; } .keep svg { width: 49%; } table.many { font-size: 6.5pt; } }
"""
COLOURS = ("#0b62a4", "#e07b00", "#2a8f3c", "#b3262e", "#7a4fa3", "#7b5a45", "#cf5fa8", "#4d4d4d")
LINES = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (3, 1)), (0, (1, 1)), (0, (8, 2)))  # readable without colour
MARKERS = ("o", "^", "s", "D", "v", "P", "X", "*")


def colour_of(names):
    return {name: COLOURS[i % len(COLOURS)] for i, name in enumerate(names)}


def style_of(names, styles):
    """A style per solver of a picture, besides its colour."""
    return {name: styles[i % len(styles)] for i, name in enumerate(names)}


def picture(draw, width=9.0, height=4.2):
    """The output of `draw(axes)` as inline SVG."""
    import matplotlib
    matplotlib.use("svg")
    matplotlib.rcParams["svg.fonttype"] = "path"
    from matplotlib.figure import Figure
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots()
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(True, which="major", color="#e6e6e6")
    draw(axes)
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()[text.getvalue().index("<svg"):]


IN_A_COLUMN = 15  # labels of a legend next to a picture


def legend_beside(axes):
    names = axes.get_legend_handles_labels()[1]
    if names:  # no lines if nothing was solved
        axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0), markerscale=1.5, fontsize=8,
                    ncols=-(-len(names) // IN_A_COLUMN))


def profiles(records, tasks, names, is_relative):
    """Performance profile, or data profile with times in seconds, with bands."""
    grid, found = scores.curves(records, tasks, names, is_relative)

    def draw(axes):
        colours, lines, markers = colour_of(names), style_of(names, LINES), style_of(names, MARKERS)
        for place, name in enumerate(name for name in names if name in found):
            share, low, high = found[name]
            axes.step(grid, share, where="post", color=colours[name], linestyle=lines[name], label=name, marker=markers[name],
                      markevery=(3 * place, 30), markersize=5, linewidth=2.4 if name in OURS else 1.4)
            axes.fill_between(grid, low, high, step="post", color=colours[name], alpha=0.06, linewidth=0)
        axes.set(xscale="log", xlim=(grid[0], grid[-1]), ylim=(0.0, 1.02), ylabel="share of the solver's instances",
                 xlabel="time / time of the fastest on the same instance" if is_relative else "seconds per solve")
        legend_beside(axes)
    return picture(draw, 7.0, 3.6)


def slope(points):
    """Slope of a line fitted to the logarithms."""
    x, y = [math.log(p[0]) for p in points], [math.log(p[1]) for p in points]
    mean_x, mean_y = statistics.mean(x), statistics.mean(y)
    return (sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y))
            / sum((a - mean_x) ** 2 for a in x))


HORIZONS = ("recipe/kI=7 cold", "recipe/N=30 cold", "recipe/N=60 cold", "recipe/N=150 cold")


def time_against_horizon(records, cells, colours):
    """None if fewer than two horizons were run."""
    lengths = records.head["matrix"]["horizons"]
    series = {}
    for solver in colours:
        for task in HORIZONS:
            times = [t for t in map(figures.time_of, cells.get((task, solver), [])) if t]
            if times:
                series.setdefault(solver, []).append((lengths[task], statistics.median(times)))
    series = {solver: points for solver, points in series.items() if len(points) > 1}
    if not series:
        return None

    def draw(axes):
        for solver, points in series.items():
            axes.plot(*zip(*points), marker="o", linestyle=style_of(colours, LINES)[solver], color=colours[solver], markersize=4,
                      label=f"{solver}, N^{slope(points):.2f}",
                      linewidth=2.4 if solver in OURS else 1.4)
        axes.set(xscale="log", yscale="log", xlabel="intervals N", ylabel="us per solve, median")
        ticks = sorted({n for points in series.values() for n, _ in points})
        axes.set_xticks(ticks, [str(n) for n in ticks])
        axes.minorticks_off()
        legend_beside(axes)
    return picture(draw)


def accuracy_against_time(cells, colours, accepted):
    def draw(axes):
        for solver in colours:
            points = []
            for (_, name), lines in cells.items():
                for line in lines:
                    found = figures.repetitions(line)
                    if name == solver and "kkt" in line and found:
                        points.append((statistics.median(found), min(max(max(line["kkt"].values()), 1e-17), 1e3)))
            if points:
                axes.scatter(*zip(*points), s=16, color=colours[solver], label=solver, alpha=0.6,
                             marker=style_of(colours, MARKERS)[solver], linewidths=0)
        axes.axhline(accepted, color="#222", linewidth=0.8)
        axes.annotate("accepted below", (0.01, accepted), xycoords=("axes fraction", "data"),
                      va="bottom", fontsize=8)
        axes.set(xscale="log", yscale="log", xlabel="us per solve",
                 ylabel="KKT residual, recomputed")
        legend_beside(axes)
    return picture(draw)


def latency_histogram(cells, colours):
    """Every timed solve of the recorded recovery."""
    task = next((t for t in ("sequence warm", "sequence cold") if any(k[0] == t for k in cells)),
                None)
    if task is None:
        return None, None
    mine = {}
    for solver in colours:
        for line in cells.get((task, solver), []):
            if line["verdict"] == "solved":
                mine.setdefault(solver, []).extend(figures.repetitions(line))
    if not mine:
        return None, None

    def draw(axes):
        low = min(min(v) for v in mine.values())
        high = max(max(v) for v in mine.values())
        bins = [low * (1.001 * high / low) ** (i / 60) for i in range(61)]
        for solver, values in mine.items():
            axes.hist(values, bins, color=colours[solver], label=solver, alpha=0.75,
                      linestyle=style_of(colours, LINES)[solver], histtype="stepfilled" if solver in OURS else "step")
        axes.set(xscale="log", xlabel="us per solve", ylabel="solves")
        legend_beside(axes)
    return picture(draw), task


WIDE = 9  # columns above which a table is printed small


def html_table(rows, marked=lambda row, i: ""):
    lines = []
    for number, row in enumerate(rows):
        tag = "td" if number else "th"
        lines.append("<tr>" + "".join(
            f'<{tag}{marked(row, i) if number else ""}>{html.escape(str(text))}</{tag}>'
            for i, text in enumerate(row)) + "</tr>")
    kind = ' class="many"' if lines and max(line.count("<t") for line in lines) > WIDE else ""
    return f'<div class="wide"><table{kind}>' + "\n".join(lines) + "</table></div>"


def mark_first(row, i):
    """Classes of the fastest solver and of cells with failures. Only a solver without failures can be the fastest."""
    if i == 0:
        return ""
    times = {k: float(text) for k, text in enumerate(row) if k and text.isdigit()}
    if times and i == min(times, key=times.get):
        return ' class="first"'
    return ' class="miss"' if "missed" in row[i] else ""


def ratio_rows(tasks, cells, names):
    """Time of every solver divided by that of riccati as a user gets it, instance by instance."""
    names = [n for n in names if any((task, n) in cells for task in tasks)]
    base = "riccati-generic" if "riccati-generic" in names else "riccati"
    yield [f"time / {base}'s", *table.labels(n for n in names if n != base)]
    for task in tasks:
        ours = cells.get((task, base), [])
        row = [task]
        for name in names:
            if name == base:
                continue
            found = figures.ratios(cells.get((task, name), []), ours)
            if found:
                low, middle, high = figures.quartiles(found)
                row.append(f"{middle:.2f} ({low:.2f} .. {high:.2f})")
            else:
                row.append("-")
        if any(text != "-" for text in row[1:]):
            yield row


PARTS = {"import": ("import_us",), "set-up": ("setup_us",), "first solve": ("first_us",),
         "set-up, first solve and reading its answer": ("setup_us", "first_us", "reading_us")}


def part_rows(part, cells, names, tasks):
    """Medians of one part of the work that precedes a repeated solve."""
    names = [n for n in names if any((task, n) in cells for task in tasks)]
    yield [f"{part}, us, medians", *table.labels(names)]
    for task in tasks:
        row = [task]
        for name in names:
            values = [sum(line["times"].get(key, 0.0) for key in PARTS[part]) for line in cells.get((task, name), [])
                      if "setup_us" in line.get("times", {})]
            row.append(f"{statistics.median(values):.0f}" if values else "-")
        yield row


def loop_rows(cells, names, tasks):
    """Median closed-loop costs, and how much each exceeds the smallest one."""
    names = [n for n in names if any((task, n) in cells for task in tasks)]
    yield ["closed-loop cost, medians", *table.labels(names)]
    for task in tasks:
        costs = {name: statistics.median(line.get("objective", math.inf) for line in cells[task, name])
                 for name in names if (task, name) in cells}
        best = min(costs.values())
        yield [task, *(f"{costs[name]:.6g} (+{100.0 * (costs[name] / best - 1.0):.2g} %)" if costs.get(name, math.inf) < math.inf
                       else "-" for name in names)]


def setting_rows(cells):
    """Solvers with several starts or kinds of warm start: what was tried on the probes, and the times of the default and
    of the chosen one."""
    yield ["task", "solver", "passed probes and iterations of each setting", "chosen", "us", "default", "us"]
    for (task, solver), lines in cells.items():
        swept = lines[0].get("swept", {})
        if len(swept) < 2:
            continue
        tried = ", ".join(f"{name}: {count} in {iterations}" for name, (count, iterations) in swept.items())
        chosen, default = lines[0]["setting"], next(iter(swept))
        medians = [[us for us in (figures.time_of(line, prefix) for line in lines) if us]
                   for prefix in ("", "" if chosen == default else "default_")]
        yield [task, solver, tried, chosen, *(f"{statistics.median(medians[0]):.0f}" if medians[0] else "-",), default,
               f"{statistics.median(medians[1]):.0f}" if medians[1] else "-"]


def failure_rows(cells, names):
    causes = ("wrong", "worse optimum", "gave up", "too slow", "out of memory", "error", "crashed", "judges disagree")
    yield ["solver", "instances", "solved", *causes]
    for name in names:
        verdicts = [line["verdict"] for (_, solver), lines in cells.items() if solver == name
                    for line in lines]
        yield [name, len(verdicts), verdicts.count("solved"), *map(verdicts.count, causes)]


def not_first(records, cells):
    """Sentences on tasks in which none of our solvers is the fastest of those that solved everything. Ours count as a
    user gets them."""
    for task in records.tasks:
        medians = {}
        is_generic = (task, "riccati-generic") in cells
        for (where, solver), lines in cells.items():
            times = [figures.time_of(line) for line in lines]
            if where == task and times and all(times) and not (solver == "riccati" and is_generic):
                medians[solver] = statistics.median(times)
        if not medians:
            continue
        best = min(medians, key=medians.get)
        ours = {s: medians[s] for s in OURS if s in medians}
        if best not in OURS:
            mine = min(ours, key=ours.get) if ours else None
            yield (f"{task}: {best} takes {medians[best]:.0f} us"
                   + (f", {mine} {ours[mine]:.0f} us." if mine
                      else ", and none of our solvers solved all."))


def notes(names, packages):
    for peer in matrix.all_peers():
        if peer.name in names:
            of = f" ({peer.package} {html.escape(str(packages.get(peer.package)))})" if peer.package else ""
            yield f"<b>{peer.name}</b>{of}: {html.escape(peer.about)}."


def counted(count, what):
    return f"{html.escape(str(count))} {what}" + ("" if count == 1 else "s")


def summary_rows(records, tasks):
    rows = scores.summary(records, tasks)
    yield ["solver", "instances", "solved", "mean, ms", f"{100 * scores.BAND:.0f} % interval", "/ best"]
    for solver, count, solved, value, low, high in rows:
        is_comparable = count == rows[0][1]
        yield [*table.labels([solver]), count, solved, f"{1e3 * value:.3g}", f"{1e3 * low:.3g} .. {1e3 * high:.3g}",
               f"{value / rows[0][3]:.2f}" if is_comparable else "fewer instances"]


def head_text(records):
    head, matrix_ = records.head, records.head["matrix"]
    saltus, machine = ({key: html.escape(str(value)) for key, value in head[part].items()} for part in ("saltus", "machine"))
    return f"""<p>Saltus {saltus['version']} ({saltus['commit']}), {saltus['compiler']}, {saltus['type']}, -march={saltus['march']};
{machine['processor']}, {machine['system']}.
At most {counted(matrix_['instances'], 'instance')} per problem, {counted(matrix_['repetitions'], 'repetition')}, alternating.
An answer counts as solved if its KKT residual, recomputed from the problem, is at most the tolerance. The status
of its solver does not count. Times are wall times of a repeated solve, or the processor times of the process if they
agree within 5 %; import, set-up and first solve are listed separately. Every solver has at most
{scores.limit_of(records):g} s for a solve.</p>"""


def overview(all_records):
    """The first page: where ours are not first, and means per class and tolerance."""
    for records in all_records:
        lines = list(scores.behind(records))
        yield (f"<h2>Where Saltus is not first, tolerance {records.head['matrix']['tolerance']:g}</h2>" + (
            "<ul>" + "".join(f"<li>{html.escape(line)}</li>" for line in lines) + "</ul>" if lines
            else "<p>In no class of this run. Single problems are listed below.</p>"))
    yield (f'<h2>Means</h2><p class="note">Shifted geometric means of the times of a solve (shift {1e3 * scores.SHIFT:g} ms), over '
           "the instances to which a solver applies. An instance that is missed counts with the limit of a solve. Intervals: "
           f"bootstrap over instances, {scores.RESAMPLES} samples, seed {scores.SEED}.</p>")
    for records in all_records:
        for name, tasks in table.groups(records):
            yield (f"<div class=\"keep\"><h3>{name.capitalize()}, tolerance {records.head['matrix']['tolerance']:g}</h3>"
                   f"{html_table(summary_rows(records, tasks))}</div>")


def profile_parts(all_records):
    for records in all_records:
        for name, tasks in table.groups(records):
            names = scores.shown(scores.summary(records, tasks))
            yield (f"<div class=\"keep\"><h3>{name.capitalize()}, tolerance {records.head['matrix']['tolerance']:g}</h3>"
                   f"{profiles(records, tasks, names, True)}{profiles(records, tasks, names, False)}</div>")


def _list(sentences):
    return "<ul>" + "".join(f"<li>{html.escape(sentence)}</li>" for sentence in sentences) + "</ul>"


def write_report(all_records, path, links=""):
    """`all_records`: runs with different tolerances. Tables of times and details are those of the tightest one."""
    all_records = sorted(all_records, key=lambda one: -one.head["matrix"]["tolerance"])
    records = all_records[-1]
    cells = figures.by_cell(records)
    present = [s for s in table.solvers_of(records) if any(key[1] == s for key in cells)]
    groups = table.groups(records)
    best = [name for _, tasks in groups for name in scores.shown(scores.summary(records, tasks))]
    drawn = list(dict.fromkeys(best))[:scores.CURVES]
    colours = colour_of(drawn)
    accepted = records.head["matrix"]["tolerance"]
    parts = [f"""<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>Benchmark suite</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style>
<h1>Solvers on optimal control problems</h1>
{head_text(records)}{links}""", *overview(all_records),
             "<h2>Performance and data profiles</h2><p>At most eight solvers per picture, those with the smallest means, and one of "
             "ours. The share of a solver counts only instances to which it applies. Performance profiles leave out instances that "
             f"no solver solved. Bands: {100 * scores.BAND:.0f} % of the bootstrap samples.</p>", *profile_parts(all_records),
             f"<h2>Times, tolerance {accepted:g}</h2>",
             *(html_table(table.rows(records, tasks), mark_first) for _, tasks in groups),
             '<p class="note">Microseconds per solve; bold: the fastest solver that solved everything.</p>']
    lines = list(not_first(records, cells))
    parts.append("<h2>Problems on which Saltus is not first</h2>" + (
        _list(lines) if lines else "<p>None in this run.</p>"))
    for one in all_records:
        closed = [task for name, tasks in table.groups(one) if name == table.CLASSES["loop"] for task in tasks]
        if closed:
            tolerance = one.head["matrix"]["tolerance"]
            parts.append(f"<h2>Closed-loop cost, tolerance {tolerance:g}</h2>" + html_table(
                loop_rows(figures.by_cell(one), present, closed)))
    horizon = time_against_horizon(records, cells, colours)
    if horizon:
        parts.append("<h2>Time against horizon</h2><p>Step recovery, landing at stage 7; exponents of a fitted power."
                     f"</p>{horizon}")
    parts.append("<h2>Accuracy against time</h2>" + accuracy_against_time(cells, colours, accepted))
    histogram, task = latency_histogram(cells, colours)
    if histogram:
        parts.append(f"<h2>Latency, {task}</h2>{histogram}")
    parts.append("<h2>Pair by pair</h2>" + "".join(html_table(ratio_rows(tasks, cells, present)) for _, tasks in groups)
                 + '<p class="note">Median over the instances that both solved, and quartiles.</p>')
    parts.append("<h2>Import, set-up and first solve</h2>" + "".join(
        html_table(part_rows(part, cells, present, tasks)) for part in PARTS for _, tasks in groups)
        + '<p class="note">The set-up of our solvers runs in C++; that of the others includes their conversions in Python, so '
          'compare it among them only. A solver that works in its set-up has a short solve and a long set-up.</p>')
    told = figures.all_remarks(records.lines())
    if told:
        parts.append("<h2>Work that the times do not show</h2>" + _list(told))
    settings = list(setting_rows(cells))
    if len(settings) > 1:
        parts.append("<h2>Starts and settings</h2>" + html_table(settings))
    parts.append("<h2>Failures by cause</h2>" + html_table(failure_rows(cells, present))
                 + '<p class="note">wrong: reported as solved, but rejected by the check; gave up: reported as failed by '
                   'the solver itself.</p>')
    parts.append("<h2>Solvers</h2><ul>" + "".join(
        f"<li>{note}</li>" for note in notes(present, records.head["packages"])) + "</ul>")
    missing = sorted({(line["solver"], line["claimed"]) for line in records.lines()
                      if line["verdict"] == "missing"})
    if missing:
        parts.append("<h2>Not run</h2>" + _list(f"{solver}: {why}" for solver, why in missing))
    write_text(path, "\n".join(parts) + "\n</html>\n")
