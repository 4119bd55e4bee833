"""Checks that the check of the paths finds those that do not exist."""

import contextlib
import io
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import check_paths  # noqa: E402

FILES = ("framework/saltus/core/a.hpp", "robots/saltus/robots/model/b.cpp", "robots/icub/c.yaml", "docs/d.md", "saltus")
CASES = [
    # page, text, expected text of the verdict
    ("README.md", "[d](docs/d.md#part), [e](https://e.org/f.md), [g](#part)", None),
    ("README.md", "[d](docs/gone.md)", "README.md:1: there is no docs/gone.md"),
    ("robots/README.md", "[a](../framework/saltus/core/a.hpp), [b](saltus/robots/model/b.cpp)", None),
    ("robots/README.md", "\n[b](saltus/robots/b.cpp)", "robots/README.md:2: there is no saltus/robots/b.cpp"),
    ("docs/README.md", "`docs/gone.md`", "there is no docs/gone.md"),
    ("docs/more/README.md", "`docs/gone.md`", None),  # not a page of a top folder
    ("CONTRIBUTING.md", "`a.hpp`, `robots/icub`, `\"saltus/core/a.hpp\"`, `saltus/robots/model/`", None),
    ("CONTRIBUTING.md", "`run.csv`, `build/x.py`, `x / y`, `docs/<name>.md`, `\"saltus/...\"`, `.cpp`, `./saltus test`", None),
    ("CONTRIBUTING.md", "`gone.hpp`", "there is no gone.hpp"),
    ("CONTRIBUTING.md", "`python3 docs/gone.py --draw x.svg`", "there is no docs/gone.py"),
    ("CONTRIBUTING.md", "`\"saltus/core/gone.hpp\"`", "there is no \"saltus/core/gone.hpp\""),
    ("CONTRIBUTING.md", "```\nframework/\n  saltus/    a.hpp\n    core/    types\nrobots/\n  saltus/robots/\n    model/\n```", None),
    ("CONTRIBUTING.md", "```\nrobots/\n  saltus/robots/\n    model/ gone/   x\n```", "there is no robots/saltus/robots/gone/"),
    ("CONTRIBUTING.md", "```\ngone/   x\n```", "there is no gone/"),
    ("CONTRIBUTING.md", "```\ncmake -B examples/build\n```", None),
]

for page, text, expected in CASES:
    with tempfile.TemporaryDirectory() as folder:
        for name in (*FILES, page):
            file = pathlib.Path(folder) / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text if name == page else "", encoding="utf-8")
        words = io.StringIO()
        with contextlib.redirect_stdout(words):
            status = check_paths.main(folder)
    assert (status == 0) == (expected is None), (text, words.getvalue())
    assert expected is None or expected in words.getvalue(), (text, words.getvalue())
print(f"{len(CASES)} cases")
