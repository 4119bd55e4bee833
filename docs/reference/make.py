#!/usr/bin/env python3
"""Builds the documentation as pages for a browser: guides, concepts, reference. The pages need no network.

Usage: make.py OUT

OUT/html/index.html is the first page. Doxygen builds the pages from the public headers and the Markdown pages of the
project. The exit status is 1 on any warning (for example a public name without a comment), on a broken link, and on a
formula that KaTeX rejects. Needs Debian's packages doxygen, doxygen-awesome-css, libjs-katex, nodejs.
"""

import html.parser
import json
import os
import re
import shutil
import subprocess
import sys
import urllib.parse

import public_headers

ROOT = os.path.abspath(public_headers.ROOT)
MARK = ".made-by-saltus-docs"  # as in the script saltus
THEME = "/usr/share/doxygen-awesome-css"
STYLES = ["doxygen-awesome.css", "doxygen-awesome-sidebar-only.css",
          "doxygen-awesome-sidebar-only-darkmode-toggle.css"]
SCRIPTS = ["doxygen-awesome-darkmode-toggle.js", "doxygen-awesome-fragment-copy-button.js"]
KATEX = "/usr/share/javascript/katex"  # katex.js runs here; the pages only need its style and fonts
# Reads [[formula, is it displayed], ...] and prints for each [html, null] or [null, the error of KaTeX].
TYPESET = """
const katex = require(process.argv[1]);
const typeset = ([formula, displayMode]) => {
  try {
    return [katex.renderToString(formula, {displayMode, throwOnError: true, strict: "error"}), null];
  } catch (error) { return [null, error.message]; }
};
console.log(JSON.stringify(JSON.parse(require("fs").readFileSync(0)).map(typeset)));
"""
FEWEST_SECTIONS = 3  # of a page with a table of contents
INLINE_FORMULA = re.compile(r"(?<![\w$])\$(?=[^\s$])([^$`]*[^\s$])\$(?![\w$])")
# The sidebar: groups in the order in which a newcomer needs them, and their pages. Other pages join the last group.
DECISIONS = [f"framework/design/decisions/{area}.md" for area in
             ("formulas", "problems", "transcription", "solvers", "control", "robots", "program", "build")]
GROUPS = {
    "Getting started": ("Install Saltus, solve a first problem and run the programs.", {
        "docs/install.md": "compilers, components and packages, and how a project uses the library",
        "docs/tutorial.md": "six short programs, from one phase to a closed loop",
        "docs/running.md": "runs, settings, results, pictures, and Python",
        "docs/viewer.md": "the page about a run: curves, scene, comparison, live runs"}),
    "Problem formulation": ("The problem class as equations, and its terms.", {
        "docs/formulation.md": "every symbol of the optimal control problem with its call",
        "docs/concepts.md": "modes, windows and events in pictures",
        "docs/glossary.md": "each term with its definition and its symbol in the code"}),
    "How-to": ("Answers to single questions, each with a program that the tests run.", {
        "docs/howto.md": "solvers, robots, events, own integrators and plants, warm starts, scaling, derivatives, export",
        "docs/troubleshooting.md": "each message with its cause and its remedy",
        "docs/coming_from.md": "terms of other frameworks and their names in Saltus, and an acados example line by line"}),
    "Examples gallery": ("Programs and problems to start from.", {
        "docs/gallery.md": "every program and library problem with equations, picture, lines and time",
        "examples/README.md": "a separate project that uses the installed library",
        "problems/README.md": "the library of problems with known answers, and the suite that runs it"}),
    "Solvers": ("Solvers, integrators and cost rules, how to choose them, and how fast they are.", {
        "docs/choosing.md": "recommendations with measured reasons",
        "docs/comparison.md": "features of other frameworks, with sources",
        "benchmarks/README.md": "how solvers are compared on the same problems",
        "benchmarks/measured.md": "results of single campaigns"}),
    "Robots": ("Models, simulation and control of robots, and two applications.", {
        "robots/README.md": "robot models, simulators, estimation and whole-body control",
        "docs/robot_link.md": "a robot in another process: usage, messages, reactions to faults",
        "problems/push_recovery/README.md": "the user guide of the reference problem",
        "problems/push_recovery/theory.md": "its optimal control problem and the rules for steps",
        "problems/push_recovery/step_planning.md": "number, foot, times and places of steps by optimal control",
        "problems/push_recovery/experiments.md": "results, survival maps and the comparison with the paper",
        "problems/push_recovery/step_experiments.md": "results of the step planner and of walking",
        "problems/quadruped/quadruped.md": "a four-legged robot on uneven ground"}),
    "Reference": ("*Classes*, *Namespaces* and *Files* in the sidebar list every public name. *Files* has one page per "
                  "header.", {
        "docs/reference.md": "the names that each task needs, with an example",
        "docs/promise.md": "public headers, versions, threads and real time",
        "docs/repeatability.md": "when two runs give identical results",
        "docs/bad_inputs.md": "messages for 485 kinds of mistakes",
        "docs/migration.md": "old and new names",
        "CHANGELOG.md": "changes by version",
        "docs/third_parties.md": "packages and their licences"}),
    "Theory": ("The formulas behind the library, with their derivations.", {
        "framework/design/conventions.md": "conventions at events: which values belong to the time before and after an event",
        "framework/design/events.md": "events inside an interval, and derivatives through them",
        "framework/design/links.md": "constraints that join several instants",
        "framework/design/dae.md": "phases with algebraic states",
        "framework/design/integrators.md": "one interval and its first and second derivatives",
        "framework/design/riccati.md": "quadratic programs stage by stage",
        "framework/design/sequences.md": "search of the best order of modes, with its guarantee",
        "framework/design/switch_times.md": "free durations, and derivatives of an optimum"}),
    "Contributing": ("How Saltus is developed, and the reasons for its design.", {
        "CONTRIBUTING.md": "folders, tests, style and releases",
        "framework/design/decisions.md": "index of the design decisions",
        **dict.fromkeys(DECISIONS, ""),
        "docs/faults.md": "behaviour of controllers, programs and readers when something fails",
        "docs/sanitizers.md": "tests under sanitizers and fuzzing",
        "SECURITY.md": "treatment of untrusted files, and how to report a vulnerability"}),
}
PAGES = ["README.md", *(page for _, pages in GROUPS.values() for page in pages)]


def label(page):
    return "page_" + re.sub(r"\W", "_", page.removesuffix(".md")).lower()


def anchor(page, heading):
    """The anchor of a heading."""
    return f"{label(page)}__{heading.replace('-', '_')}"


def slug(heading):
    """The anchor of a heading on GitHub."""
    text = re.sub(r"[`*\[\]]|\(\S*?\)(?=\])", "", heading.strip().lower())
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


# ---- formulas ------------------------------------------------------------------------------------


class Formulas:
    """The formulas of all pages: `$...$` within a line and blocks of ```math. Doxygen receives a mark for each."""

    def __init__(self):
        self.formulas = []  # (page, formula, is it displayed)

    def mark(self, page, formula, displayed):
        self.formulas.append((page, formula, displayed))
        return f"FORMULA{len(self.formulas) - 1}END"

    def typeset(self, folder):
        """Puts the formulas into the pages of the folder. Returns one sentence per formula that is not typeset."""
        asked = json.dumps([[formula, displayed] for _, formula, displayed in self.formulas])
        done = subprocess.run(["node", "-e", TYPESET, os.path.join(KATEX, "katex.js")], input=asked, capture_output=True,
                              text=True, check=True)
        answers = json.loads(done.stdout)
        wrong = [f"{page}: {error}: {formula}"
                 for (page, formula, _), (_, error) in zip(self.formulas, answers) if error]
        seen = set()

        def html_of(match):
            seen.add(int(match[1]))
            shown = answers[int(match[1])][0] or ""
            end = "</span></span></span>"  # end of the last part, in which no line is broken
            return shown.removesuffix(end) + match[2] + end if match[2] and shown.endswith(end) else shown + match[2]

        for name in os.listdir(folder):
            if name.endswith((".html", ".js")):
                path = os.path.join(folder, name)
                with open(path, encoding="utf-8") as file:
                    text = file.read()
                if re.search(r"FORMULA\d+END", text):
                    if name.endswith(".js"):
                        wrong.append(f"{name}: a formula is in a heading, where it is not typeset")
                        continue
                    with open(path, "w", encoding="utf-8") as file:
                        file.write(re.sub(r"FORMULA(\d+)END([,.;:)]?)", html_of, text))
        wrong += [f"{page}: this formula is not on its page: {formula}"
                  for number, (page, formula, _) in enumerate(self.formulas) if number not in seen]
        return wrong

    @staticmethod
    def copy_style(folder):
        os.makedirs(os.path.join(folder, "fonts"))
        shutil.copy(os.path.join(KATEX, "katex.min.css"), folder)
        for name in os.listdir(os.path.join(KATEX, "fonts")):
            if name.endswith(".woff2"):
                shutil.copy(os.path.join(KATEX, "fonts", name), os.path.join(folder, "fonts"))


# ---- pages ---------------------------------------------------------------------------------------


class Page:
    """A page converted for Doxygen: headings with anchors, links to pages and headers, and pictures in its folder."""

    def __init__(self, name, names, headers, pictures, formulas, lacking):
        self.name, self.names, self.headers, self.pictures = name, names, headers, pictures
        self.formulas, self.lacking = formulas, lacking
        self.folder = os.path.dirname(name)
        self.is_bold = False

    def path_of(self, link):
        return os.path.normpath(os.path.join(self.folder, link))

    def link(self, text, target, whole):
        if re.match(r"\w+:", target):
            return whole
        path, _, heading = target.partition("#")
        path = self.path_of(path) if path else self.name
        if os.path.isdir(os.path.join(ROOT, path)) and f"{path}/README.md" in self.names:
            path += "/README.md"
        words = text.replace('"', "'").replace("`", "")
        if path in self.names:
            to = anchor(path, heading) if heading else label(path)
            return f'\\ref {to} "{words}"'
        if path in self.headers:
            return f'\\ref {self.headers[path]} "{words}"'
        if not os.path.exists(os.path.join(ROOT, path)):
            self.lacking.append(f"{self.name}: the link to {target} leads nowhere")
        shown = text.replace("`", "")
        return f"`{shown}`" if shown in path or shown.split("/")[-1] == os.path.basename(path) else f"{text} (`{path}`)"

    def picture(self, match):
        path = self.path_of(match[2])
        if not os.path.exists(os.path.join(ROOT, path)):
            self.lacking.append(f"{self.name}: there is no picture {match[2]}")
            return match[1]
        flat = path.replace("/", "_")
        self.pictures[flat] = os.path.join(ROOT, path)
        said = match[1].replace('"', "&quot;")
        return f'<img src="{flat}" alt="{said}" class="picture"/>'

    @staticmethod
    def plain(text):
        """Escapes what Doxygen would replace: commands, names that it would link, and dashes."""
        text = re.sub(r"@|%(?! )", r"\\\g<0>", text)
        return re.sub(r"(?<![\w-])---?(?=[\w'])", r"\\\g<0>", text)

    def bold(self, _):
        """A tag instead of asterisks: Doxygen prints the asterisks of bold text that begins or ends with code."""
        self.is_bold = not self.is_bold
        return "<b>" if self.is_bold else "</b>"

    def words(self, line):
        self.is_bold = self.is_bold and bool(line.strip())
        if line.count("`") % 2:
            self.lacking.append(f"{self.name}: inline code does not end on its line: {line}")
        parts = re.split(r"(`[^`]*`)", line)
        # Doxygen ends inline code at an apostrophe, unless it begins with two backticks. Otherwise code is not changed.
        codes = [f"`{part}`" if "'" in part else part for part in parts if part.startswith("`")]
        line = "".join("\0" if part.startswith("`") else self.plain(part) for part in parts)
        line = INLINE_FORMULA.sub(lambda match: self.formulas.mark(self.name, match[1], False), line)
        if "$" in re.sub(r"\$(\{\w+\}|\(\w+\))", "", line):  # variables of shells and of CMake are not formulas
            self.lacking.append(f"{self.name}: a formula begins or ends with $, but not both: {line}")

        def with_codes(text):
            return re.sub("\0", lambda _: codes.pop(0), text)

        line = re.sub(r"\*\*", self.bold, line)
        line = re.sub(r"!\[([^\]]*)\]\(([^)\s]+)\)", self.picture, line)
        done, end = "", 0
        for match in re.finditer(r"(?<!!)\[([^\]]+)\]\(([^)\s]+)\)", line):
            done += with_codes(line[end:match.start()])
            text = with_codes(match[1])
            done += self.link(text, match[2], f"[{text}]({match[2]})")
            end = match.end()
        return done + with_codes(line[end:])

    def text(self):
        with open(os.path.join(ROOT, self.name), encoding="utf-8") as file:
            lines = file.read().splitlines()
        out, is_code, seen, formula = [], False, {}, None
        sections = sum(line.startswith("## ") for line in lines)
        for line in lines:
            if line.strip() == "```math" and not is_code:
                formula = []
                continue
            if formula is not None:
                if line.strip() != "```":
                    formula.append(line)
                    continue
                out += ["", self.formulas.mark(self.name, "\n".join(formula), True), ""]
                formula = None
                continue
            if line.lstrip().startswith("```"):
                is_code = not is_code
                # Doxygen supports few languages; it shows shell code unchanged.
                out.append(re.sub(r"```(sh|yaml|cmake|json|text)$", "```", line))
                continue
            if is_code or re.match(r"<!--.*-->$", line):
                out.append(line if is_code else "")
                continue
            heading = re.match(r"(#+) (.*)", line)
            if not heading:
                out.append(self.words(line))
                continue
            shown = heading[2].replace("`", "")  # Doxygen shows code in a heading as text with tags
            if heading[1] == "#":
                title = "Saltus" if self.name == "README.md" else shown
                out.append(f"# {title} {{#{'mainpage' if self.name == 'README.md' else label(self.name)}}}")
                if self.name != "README.md" and sections >= FEWEST_SECTIONS:
                    out += ["", "[TOC]", ""]
            else:
                name = slug(heading[2])
                seen[name] = seen.get(name, -1) + 1
                if seen[name]:
                    name += f"-{seen[name]}"
                if self.name == "README.md":  # a section of the first page would come before the groups in the sidebar
                    out += [f"\\anchor {anchor(self.name, name)}", f"<h1>{shown}</h1>", ""]
                else:
                    out.append(f"{heading[1]} {shown} {{#{anchor(self.name, name)}}}")
        return "\n".join(out) + "\n"


def group_label(title):
    return f"group_{re.sub(r'[^a-z]', '_', title.lower())}"


def group_page(title, pages):
    """A page that lists the pages of a group, which makes them its children in the sidebar."""
    introduction, described = GROUPS[title]
    lines = [f"# {title} {{#{group_label(title)}}}", "", introduction, ""]
    return "\n".join([*lines, *(f"- \\subpage {label(name)}" + (f" <br/>{described[name]}" if described.get(name) else "")
                                for name in pages)]) + "\n"


def namespaces():
    """Comments for Doxygen that describe the namespaces, from the table in promise.md."""
    with open(os.path.join(ROOT, "docs", "promise.md"), encoding="utf-8") as file:
        rows = re.findall(r"^\| `(saltus[\w:]*)` \| (.*) \|$", file.read(), re.MULTILINE)
    return "".join(f"/** \\namespace {name}\n{words[0].upper()}{words[1:]}. */\n" for name, words in rows)


def write_pages(folder):
    """Writes the pages for Doxygen: the README, then each group with its pages. Returns the files in order, the
    pictures, the formulas, and one sentence per broken link and missing picture."""
    names = [name for name in PAGES if os.path.exists(os.path.join(ROOT, name))]
    lacking = [f"make.py: there is no page {name}" for name in PAGES if name not in names]
    tracked = subprocess.run(["git", "-C", ROOT, "ls-files", "*.md"], capture_output=True, text=True, check=False)
    for name in tracked.stdout.split():
        if name not in names and "/templates/" not in name and not name.startswith(("docs/results/", ".")):
            names.append(name)
    headers = {os.path.relpath(path, ROOT): f"saltus/{name}"
               for name, path in public_headers.public_headers()}
    files, pictures, formulas = [], {}, Formulas()
    os.makedirs(folder)

    def write(name, text):
        files.append(os.path.join(folder, f"{len(files):02}_{name.replace('/', '_')}"))
        with open(files[-1], "w", encoding="utf-8") as file:
            file.write(text)

    write("README.md", Page("README.md", names, headers, pictures, formulas, lacking).text())
    grouped = {title: [name for name in pages if name in names] for title, (_, pages) in GROUPS.items()}
    others = [name for name in names if name not in PAGES]
    grouped[list(grouped)[-1]] += others
    for title, pages in grouped.items():
        write(title + ".md", group_page(title, pages))
        for name in pages:
            write(name, Page(name, names, headers, pictures, formulas, lacking).text())
    write("namespaces.dox", namespaces())
    return files, pictures, formulas, lacking


# ---- Doxygen -------------------------------------------------------------------------------------


def version():
    with open(os.path.join(ROOT, "CMakeLists.txt"), encoding="utf-8") as file:
        return re.search(r"project\(saltus\s+VERSION\s+([\d.]+)", file.read(), re.I)[1]


def write_header(out):
    """The page header of Doxygen with the scripts of the theme."""
    head = os.path.join(out, "header.html")
    subprocess.run(["doxygen", "-w", "html", head, os.path.join(out, "footer.html"), os.path.join(out, "style.css")],
                   check=True, capture_output=True)
    scripts = '<link rel="stylesheet" type="text/css" href="$relpath^katex.min.css"/>\n'
    scripts += "".join(f'<script type="text/javascript" src="$relpath^{name}"></script>\n' for name in SCRIPTS)
    scripts += ('<script type="text/javascript">DoxygenAwesomeDarkModeToggle.init();\n'
                "DoxygenAwesomeFragmentCopyButton.init();</script>\n")
    with open(head, encoding="utf-8") as file:
        text = file.read()
    with open(head, "w", encoding="utf-8") as file:
        file.write(text.replace("</head>", scripts + "</head>"))


def run_doxygen(out, files, pictures):
    write_header(out)
    headers = os.path.join(out, "headers")
    settings = {
        "OUTPUT_DIRECTORY": out,
        "PROJECT_NUMBER": version(),
        "INPUT": " ".join(f'"{path}"' for path in [*files, headers]),
        "STRIP_FROM_PATH": headers, "STRIP_FROM_INC_PATH": headers,
        "USE_MDFILE_AS_MAINPAGE": files[0],
        "HTML_HEADER": os.path.join(out, "header.html"),
        "HTML_EXTRA_STYLESHEET": " ".join([*(os.path.join(THEME, name) for name in STYLES),
                                           os.path.join(ROOT, "docs", "reference", "saltus.css")]),
        "HTML_EXTRA_FILES": " ".join(os.path.join(THEME, name) for name in SCRIPTS),
    }
    with open(os.path.join(ROOT, "docs", "reference", "Doxyfile"), encoding="utf-8") as file:
        text = file.read() + "".join(f"{key} = {value}\n" for key, value in settings.items())
    done = subprocess.run(["doxygen", "-"], input=text, capture_output=True, text=True, check=False)
    for name, path in pictures.items():
        shutil.copy(path, os.path.join(out, "html", name))
    warnings = list(dict.fromkeys(line for line in done.stderr.splitlines() if line.strip()))
    return [line.replace(headers + "/", "") for line in warnings], done.returncode


def break_long_words(folder):
    """Lets a browser break long names in tables at punctuation, which makes columns narrower."""
    for name in os.listdir(folder):
        if name.startswith(("page_", "index")) and name.endswith(".html"):
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                text = file.read()
            text = re.sub(r'(?<=<td class="markdownTableBody)\w+">(?:(?!katex).)*?</td>', lambda cell: re.sub(
                r"[\w/:.,(){}]{19,}(?![^<]*>)", lambda word: re.sub(r"([_/:.,({]+)(?=\w)", r"\1<wbr/>", word[0]), cell[0]), text)
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(text)


def shorten_sidebar(folder):
    """The lists of all classes, namespaces and files are pages. In the sidebar they would have hundreds of entries."""
    with open(os.path.join(folder, "navtreedata.js"), encoding="utf-8") as file:
        text = file.read()
    tops = [number for number, name in enumerate(re.findall(r'^    \[ "([^"]*)"', text, re.MULTILINE))
            if name in ("Namespaces", "Classes", "Files")]
    for name in os.listdir(folder):
        path = os.path.join(folder, name)
        if name == "navtreedata.js":
            text = re.sub(r'"\w+_dup" \]', "null ]", text)
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        elif re.match(r"navtreeindex\d+\.js$", name):
            with open(path, encoding="utf-8") as file:
                indices = file.read()
            with open(path, "w", encoding="utf-8") as file:
                file.write(re.sub(rf"\[({'|'.join(map(str, tops))}),(\d+)(?:,\d+)+\]", r"[\1,\2]", indices))


def list_groups_in_menu(folder):
    """Puts the groups into the menu of narrow windows, in place of one entry for all pages."""
    path = os.path.join(folder, "menudata.js")
    with open(path, encoding="utf-8") as file:
        text = file.read()
    groups = ",\n".join(f'{{text:"{title}",url:"{group_label(title)}.html"}}' for title in GROUPS)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text.replace('{text:"Related Pages",url:"pages.html"}', groups))


def drop_dead_summaries(folder):
    """Removes links from the head of a page to lists that Doxygen omits because all entries are private."""
    for name in os.listdir(folder):
        if name.endswith(".html"):
            path = os.path.join(folder, name)
            with open(path, encoding="utf-8") as file:
                text = file.read()
            if '<a name="nested-classes"></a>' not in text and '<a href="#nested-classes">' in text:
                with open(path, "w", encoding="utf-8") as file:
                    file.write(text.replace('<a href="#nested-classes">Classes</a> &#124;\n', "")
                               .replace('<a href="#nested-classes">Classes</a>', ""))


# ---- links ---------------------------------------------------------------------------------------


class Links(html.parser.HTMLParser):
    """The references of a page, and its anchors."""

    def __init__(self):
        super().__init__()
        self.links, self.loaded, self.anchors = set(), set(), set()

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        for key in ("id", "name"):
            if values.get(key):
                self.anchors.add(values[key])
        if tag == "a" and values.get("href"):
            self.links.add(values["href"])
        elif values.get("src") or (tag == "link" and values.get("href")):
            self.loaded.add(values.get("src") or values["href"])


def check_links(folder):
    """One sentence per dead link between pages and per resource from a network."""
    pages, wrong = {}, []
    for name in sorted(os.listdir(folder)):
        if name.endswith(".html"):
            pages[name] = Links()
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                pages[name].feed(file.read())
    count = 0
    for name, page in pages.items():
        for link in sorted(page.links | page.loaded):
            url = urllib.parse.urlsplit(link)
            if url.scheme or url.netloc:
                if link in page.loaded and url.scheme not in ("data", "javascript"):
                    wrong.append(f"{name} loads {link}")
                continue
            count += 1
            path = urllib.parse.unquote(url.path) or name
            if not os.path.exists(os.path.join(folder, path)):
                wrong.append(f"{name}: {link} leads nowhere")
            elif url.fragment and path in pages and urllib.parse.unquote(url.fragment) not in pages[path].anchors:
                wrong.append(f"{name}: there is no {link}")
    return wrong, len(pages), count


def clear(out):
    """Creates an empty folder, and rejects one with other files."""
    os.makedirs(out, exist_ok=True)
    mark = os.path.join(out, MARK)
    if os.listdir(out) and not os.path.exists(mark):
        sys.exit(f"documentation: there are other files in '{out}'; give a new folder, or one that `./saltus docs` made")
    for name in os.listdir(out):
        path = os.path.join(out, name)
        if name == MARK:
            continue
        if os.path.isdir(path) and not os.path.islink(path):
            shutil.rmtree(path)
        else:
            os.remove(path)
    with open(mark, "w", encoding="utf-8") as file:
        file.write("`./saltus docs` made this folder, and clears it before it writes it again.\n")


def main(out):
    if not shutil.which("doxygen") or not os.path.isdir(THEME):
        sys.exit("the documentation needs doxygen and its theme: apt-get install doxygen doxygen-awesome-css")
    if not shutil.which("node") or not os.path.isdir(KATEX):
        sys.exit("the formulas of the documentation need KaTeX: apt-get install libjs-katex nodejs")
    clear(out)
    public_headers.main(os.path.join(out, "headers"))
    files, pictures, formulas, lacking = write_pages(os.path.join(out, "pages"))
    warnings, status = run_doxygen(out, files, pictures)
    formulas.copy_style(os.path.join(out, "html"))
    lacking += formulas.typeset(os.path.join(out, "html"))
    break_long_words(os.path.join(out, "html"))
    shorten_sidebar(os.path.join(out, "html"))
    list_groups_in_menu(os.path.join(out, "html"))
    drop_dead_summaries(os.path.join(out, "html"))
    wrong, pages, links = check_links(os.path.join(out, "html"))
    wrong = [*lacking, *wrong]
    for sentence in [*warnings, *wrong]:
        print(sentence, file=sys.stderr)
    if warnings or wrong or status:
        sys.exit(f"documentation: {len(warnings)} warnings, {len(wrong)} broken links or formulas")
    print(f"documentation: {pages} pages, no warning, {links} links checked, {len(formulas.formulas)} formulas; "
          f"{os.path.join(out, 'html', 'index.html')}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(os.path.abspath(sys.argv[1]))
