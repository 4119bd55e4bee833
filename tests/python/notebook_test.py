#!/usr/bin/env python3
"""Opens a page of saltus.view() inside an executed notebook in a headless Chromium.

Usage: notebook_test.py SOURCE_DIR FOLDER, which gets the notebook as HTML and a picture of it. Needs the package saltus
and nbclient, nbformat and nbconvert of PyPI. Exits with 77, "skipped", without them or without Chromium.
"""

import importlib.util
import os
import shutil
import sys
import tempfile
import time

SKIPPED = 77
CELLS = ('''import saltus
from saltus import *
import numpy as np''',
         '''swing = Phase("swing up", lambda t, x, u: [x[1], 9.81 * sin(x[0]) + u[0]], between(0.5, 6.0), nx=2, nu=1)
swing.bound_input(0, between(-8.0, 8.0)).track("effort", lambda t, x, u: u, 0.01)
swing.reach("upright", lambda t, x: x, exactly([0.0, 0.0])).minimise_at_end("time", lambda t, x: t)
swing.guess_duration(2.0).guess_state(Guess.interpolate([np.pi, 0.0], [0.0, 0.0]))
problem = OptimalControlProblem("pendulum").start_at([np.pi, 0.0]).then(swing)
plan = solve(problem, intervals_per_phase=60)
plan''',
         "saltus.view(plan)")


def main(source, folder):
    missing = [name for name in ("nbclient", "nbformat", "nbconvert", "saltus") if importlib.util.find_spec(name) is None]
    sys.path.append(os.path.join(source, "docs", "reference"))
    import open_pages
    chromium = next((path for path in map(shutil.which, open_pages.BROWSERS) if path), None)
    if missing or not chromium:
        print(f"skipped: there is no {', '.join(missing) or 'Chromium'}")
        return SKIPPED
    import nbformat
    from nbclient import NotebookClient
    from nbconvert import HTMLExporter
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS])
    client = NotebookClient(notebook, timeout=600, kernel_name="python3")
    client.create_kernel_manager().transport = "ipc"  # works without a network
    client.execute()
    exporter = HTMLExporter()
    exporter.mathjax_url = exporter.require_js_url = exporter.jquery_url = exporter.mermaid_js_url = ""
    page, _ = exporter.from_notebook_node(notebook)
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, "notebook.html")
    with open(path, "w", encoding="utf-8") as file:
        file.write(page)
    with tempfile.TemporaryDirectory(prefix="saltus-profile-", ignore_cleanup_errors=True) as profile:
        browser = open_pages.Browser(chromium, profile)
        browser.window(1280)
        said = browser.open(path)
        frame = "document.querySelector('iframe[title=\"view of a run\"]')"
        inside = f"{frame}.contentWindow"
        deadline = time.monotonic() + 60
        while not browser.evaluate(f"Boolean({frame} && {frame}.contentDocument.querySelector('.uplot'))"):
            if time.monotonic() > deadline:
                sys.exit("the page in the notebook draws no curves")
            time.sleep(0.2)
        panels = browser.evaluate(f"{inside}.eval('panels.length')")
        browser.evaluate(f"{inside}.eval('set_playing(false); go(1.0); 0')")
        text = browser.evaluate(f"{inside}.eval('panels[0].box.innerText')")
        end = browser.evaluate(f"{inside}.eval('end')")
        browser.evaluate(f"{frame}.scrollIntoView(); 0")
        browser.picture(os.path.join(folder, "notebook.png"))
        said += [sentence for sentence in map(browser.error, browser.events) if sentence]
        browser.close()
    print(f"{panels} panels, the plan ends at {end:.3f} s; at 1 s: {' '.join(text.split())}; {len(page) / 1e6:.1f} MB")
    if panels != 3 or not 1.0 < end < 5.0:
        sys.exit("the page in the notebook shows other curves")
    if said:
        sys.exit("the console of the browser has errors: " + "; ".join(said))
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
