#!/usr/bin/env python3
"""Opens the pages from make.py in a headless browser, at the widths of a desktop and of a telephone.

Usage: open_pages.py FOLDER [--pictures OUT] [PAGE...]

FOLDER has the pages (.html); PAGE names some of them, by default all. The exit status is 1 if a page writes an error to
the console, cannot load a file, shows a formula that is not typeset, is wider than the window, or has a sidebar of more
than 40 entries. --pictures writes a picture of each page at each width to OUT. Without Chromium the script prints a
message and exits with 77.
"""

import base64
import collections
import json
import os
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
WIDTHS = {1280: 900, 400: 800}  # width and height of the window, pixels
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SLACK = 1  # pixels, for rounding
MOST_ENTRIES = 40  # of the sidebar
SETTLE = """new Promise(done => {
  let left = 20;
  const look = () => --left && !document.querySelector("#nav-tree .selected") ? setTimeout(look, 20) : done();
  setTimeout(look, 20);
})"""
# Returns the elements that overflow, by the id or class of the widest one, and formulas that are shown as text.
EXAMINE = """(() => {
  const wrong = [];
  for (const part of [document.documentElement, document.body, document.querySelector("#doc-content")]) {
    if (!part || part.scrollWidth <= part.clientWidth + SLACK) continue;
    let widest = null, right = 0;
    for (const element of document.querySelectorAll("body *")) {
      const box = element.getBoundingClientRect();
      if (box.width > 0 && box.right > right) { widest = element; right = box.right; }
    }
    wrong.push(`${part.scrollWidth} pixels do not fit into ${part.clientWidth}: ` +
               `${widest.tagName.toLowerCase()} ${widest.id || widest.className}: ${widest.innerText?.slice(0, 60)}`);
    break;
  }
  const entries = [...document.querySelectorAll("#nav-tree li")].filter(e => e.offsetParent).length;
  if (entries > MOST_ENTRIES) wrong.push(`the sidebar has ${entries} entries`);
  if (document.querySelector(".katex-error") || /FORMULA\\d+END/.test(document.body.innerText))
    wrong.push("a formula is not typeset");
  return wrong;
})()""".replace("SLACK", str(SLACK)).replace("MOST_ENTRIES", str(MOST_ENTRIES))


class Browser:
    """Chromium, controlled by its DevTools protocol over two pipes."""

    def __init__(self, program, profile, *flags):
        theirs_in, self.out = os.pipe()
        back, theirs_out = os.pipe()
        self.process = subprocess.Popen(
            ["sh", "-c", f'exec "$@" 3<&{theirs_in} 4>&{theirs_out}', "sh", program, "--headless", "--no-sandbox",
             "--disable-gpu", "--hide-scrollbars", *flags, "--allow-file-access-from-files", "--remote-debugging-pipe",
             f"--user-data-dir={profile}", "about:blank"],
            pass_fds=(theirs_in, theirs_out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(theirs_in)
        os.close(theirs_out)
        self.answers = os.fdopen(back, "rb")
        self.number, self.session, self.rest = 0, None, b""
        self.events = collections.deque()
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")

    def receive(self):
        while b"\0" not in self.rest:
            more = os.read(self.answers.fileno(), 1 << 20)
            if not more:
                sys.exit("open_pages: the browser has ended")
            self.rest += more
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **parameters):
        """Sends a command and returns its answer. Events received meanwhile are kept."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        sent = json.dumps(message).encode() + b"\0"
        while sent:
            sent = sent[os.write(self.out, sent):]
        while True:
            answer = self.receive()
            if answer.get("id") != self.number:
                self.events.append(answer)
                continue
            if "error" in answer:
                sys.exit(f"open_pages: {method}: {answer['error']['message']}")
            return answer["result"]

    def window(self, width):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=WIDTHS[width], deviceScaleFactor=1,
                  mobile=False)

    def open(self, path):
        """Loads a page and returns one sentence per error on its console."""
        self.events.clear()
        self.call("Page.navigate", url=f"file://{path}")
        while not any(event.get("method") == "Page.loadEventFired" for event in self.events):
            self.events.append(self.receive())
        # Scripts that wait for the document run before this call returns, and the sidebar has marked the page.
        self.call("Runtime.evaluate", expression=SETTLE, awaitPromise=True)
        return [sentence for sentence in map(self.error, self.events) if sentence]

    @staticmethod
    def error(event):
        values = event.get("params", {})
        if event.get("method") == "Runtime.exceptionThrown":
            thrown = values["exceptionDetails"]
            return thrown.get("exception", {}).get("description", thrown["text"]).split("\n")[0]
        if event.get("method") == "Log.entryAdded" and values["entry"]["level"] in ("error", "warning"):
            return f"{values['entry']['text']} {values['entry'].get('url', '')}"
        if event.get("method") == "Runtime.consoleAPICalled" and values["type"] in ("error", "assert", "warning"):
            return " ".join(str(argument.get("value", argument.get("description"))) for argument in values["args"])
        return None

    def evaluate(self, expression):
        return self.call("Runtime.evaluate", expression=expression, returnByValue=True)["result"]["value"]

    def picture(self, path):
        with open(path, "wb") as file:
            file.write(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))

    def close(self):
        self.session = None
        self.call("Browser.close")
        self.process.wait(10)
        self.answers.close()
        os.close(self.out)


def main(folder, names, pictures):
    program = next((path for path in map(shutil.which, BROWSERS) if path), None)
    if program is None:
        print("skipped: there is no Chromium (Debian's package chromium), so no page was opened")
        return SKIPPED
    folder = os.path.abspath(folder)
    names = names or sorted(name for name in os.listdir(folder) if name.endswith(".html"))
    if not names:
        sys.exit(f"open_pages: there are no pages in {folder}")
    if pictures:
        os.makedirs(pictures, exist_ok=True)
    wrong = 0
    with tempfile.TemporaryDirectory(prefix="saltus-pages-", ignore_cleanup_errors=True) as profile:
        browser = Browser(program, profile)
        for width in WIDTHS:
            browser.window(width)
            for name in names:
                for sentence in [*browser.open(os.path.join(folder, name)), *browser.evaluate(EXAMINE)]:
                    print(f"{name} at {width} pixels: {sentence}")
                    wrong += 1
                if pictures:
                    browser.picture(os.path.join(pictures, f"{name.removesuffix('.html')}_{width}.png"))
        browser.close()
    print(f"{len(names)} pages opened at {' and '.join(map(str, WIDTHS))} pixels: {wrong} errors")
    return 1 if wrong else 0


if __name__ == "__main__":
    given, out = sys.argv[1:], None
    if "--pictures" in given[:-1]:
        place = given.index("--pictures")
        out = given[place + 1]
        del given[place:place + 2]
    if not given or any(name.startswith("-") for name in given):
        sys.exit(__doc__)
    sys.exit(main(given[0], given[1:], out))
