"""`bench report --site`: the report with a page per instance, whose address does not change, and a page per solver."""

import html
import inspect
import os
import re
import textwrap

import data_problems
import figures
import matrix
import problem_files
import report
import table
from package import write_text
from task import OURS


def address(task, instance):
    """`restated-moon_lander-cold-1.html`"""
    return re.sub(r"[^A-Za-z0-9_.=-]+", "-", f"{task} {instance}") + ".html"


def page(title, parts):
    return (f'<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>{html.escape(title)}</title>'
            f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{report.STYLE}</style>'
            f'<p><a href="../index.html">All results</a></p><h1>{html.escape(title)}</h1>' + "\n".join(parts) + "\n</html>\n")


def instances_of(all_records):
    """(task, instance) -> [(tolerance, line)], in the order of the runs."""
    found = {}
    for records in all_records:
        for task, lines in records.tasks.items():
            for line in lines:
                if line["instance"] and line["verdict"] not in figures.NO_RESULT:
                    found.setdefault((task, line["instance"]), []).append((records.head["matrix"]["tolerance"], line))
    return found


def facts_of(problem):
    """Texts of a problem file that is here: what it is, its source and licence, its optimum."""
    try:
        source = data_problems.source_of(problem)
        if source is None or problem.startswith(data_problems.PUBLIC):
            return {}
        data = problem_files.read(source[0], problem)
        return {key: data[key] for key in ("about", "source", "licence", "optimum", "optimum_source") if data.get(key) is not None}
    except (KeyError, OSError, ValueError):
        return {}


def instance_page(task, instance, lines, kinds):
    first = lines[0][1]
    size = next((line["size"] for _, line in lines if "size" in line), None)
    facts = {"class": table.class_of(task, kinds), **({"size": f"{size[0]} variables, {size[1]} rows"} if size else {}),
             **facts_of(first["problem"])}
    rows = [["tolerance", "solver", "result", "us", "iterations", "cost", "stationarity", "feasibility", "complementarity", "integrality",
             "asked", "setting", "version", "its status"]]
    for tolerance, line in lines:
        us, kkt = figures.time_of(line), line.get("kkt", {})
        rows.append([f"{tolerance:g}", line["solver"], line["verdict"], f"{us:.0f}" if us else "-", line.get("iterations", "-"),
                     f"{line['objective']:.9g}" if "objective" in line else "-",
                     *(f"{kkt[key]:.1e}" if key in kkt else "-" for key in ("stationarity", "feasibility", "complementarity", "integrality")),
                     f"{line['asked']:g}" if "asked" in line else "-", line.get("setting", "-"),
                     line.get("machine", {}).get("version", "-"), line["claimed"]])
    return page(f"{task}, instance {instance}", [
        "<ul>" + "".join(f"<li>{html.escape(key)}: {html.escape(str(value))}</li>" for key, value in facts.items()) + "</ul>",
        report.html_table(rows), f'<p class="note">{html.escape(command(first, lines))}</p>'])


def command(line, lines):
    solvers = ",".join(dict.fromkeys(line["solver"] for _, line in lines))
    return f"saltus bench run --problems {line['problem']} --start {line.get('start') or 'cold'} --solvers {solvers}"


def source_of(adapter):
    """The module text of an adapter that has its own file, and the code of the class with those it extends here."""
    module = inspect.getmodule(adapter)
    own = module.__name__.startswith("adapters.") if module else False
    classes = [c for c in adapter.__mro__ if c is not object and c.__name__ not in ("Adapter",)]
    return (inspect.getdoc(module) if own else "", [inspect.getdoc(c) for c in classes if c.__doc__ and not own],
            [textwrap.dedent(inspect.getsource(c)) for c in classes])


def solver_page(adapter, all_records):
    text, notes, code = source_of(adapter)
    parts = [f"<p>{html.escape(adapter.about)}.</p>"]
    parts += [f"<p>{html.escape(one)}</p>" for one in (text.split("\n\n") if text else notes)]
    package = adapter.package and f"Package {adapter.package}, version in this run: " + str(next(
        (r.head["packages"].get(adapter.package) for r in all_records), None))
    parts.append(f"<p>{html.escape(package or 'Not a package.')}</p>")
    ladder = ", ".join(f"{factor:g}" for factor in getattr(adapter, "ladder", report.LADDER))
    parts.append(f"<p>Requested tolerances that were tried, as factors of the tolerance: {ladder}. "
                 "The loosest one whose answers pass is used. "
                 + ("It uses its own start." if not getattr(adapter, "takes_start", True) else "It is offered every start of the file.")
                 + "</p>")
    rows = [["tolerance", "task", "asked", "setting", "passed probes and iterations of each setting"]]
    for records in all_records:
        for (task, solver), lines in figures.by_cell(records).items():
            if solver == adapter.name and "asked" in lines[0]:
                swept = ", ".join(f"{name}: {count} in {iterations}" for name, (count, iterations) in lines[0]["swept"].items())
                rows.append([f"{records.head['matrix']['tolerance']:g}", task, f"{lines[0]['asked']:g}", lines[0]["setting"], swept])
    if len(rows) > 1:
        parts.append("<h2>Settings in this run</h2>" + report.html_table(rows))
    parts.append("<h2>Code of the call</h2>" + "".join(f"<pre>{html.escape(one)}</pre>" for one in code))
    return page(adapter.name, parts)


def write_site(all_records, folder):
    for name in ("", "instances", "solvers"):
        os.makedirs(os.path.join(folder, name), exist_ok=True)
    instances = instances_of(all_records)
    kinds = {task: kind for records in all_records for task, kind in records.head["matrix"].get("kinds", {}).items()}
    for (task, instance), lines in instances.items():
        write_text(os.path.join(folder, "instances", address(task, instance)), instance_page(task, instance, lines, kinds))
    present = {line["solver"] for lines in instances.values() for _, line in lines}
    adapters = [peer for peer in matrix.all_peers() if peer.name in present]
    for adapter in adapters:
        write_text(os.path.join(folder, "solvers", adapter.name + ".html"), solver_page(adapter, all_records))
    links = "<p>Solvers: " + ", ".join(f'<a href="solvers/{html.escape(a.name)}.html">{html.escape(a.name)}</a>' for a in adapters)
    links += f"; ours: {', '.join(sorted(present & set(OURS)))}.</p><details><summary>All instances</summary><p>" + ", ".join(
        f'<a href="instances/{html.escape(address(*key))}">{html.escape(f"{key[0]} {key[1]}")}</a>' for key in instances)
    report.write_report(all_records, os.path.join(folder, "index.html"), links + "</p></details>")
