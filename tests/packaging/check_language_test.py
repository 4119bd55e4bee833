"""The check of the language finds what it should, and nothing else."""

import contextlib
import io
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import check_language  # noqa: E402

WIDE = "A line of prose that goes on and on, far beyond what a reader of two windows beside each other can see on a screen, is wide."
LONG = "\n".join(" ".join(["word"] * count) for count in (16, 15)) + "."
SOURCES = [
    # text of a header, rule that it breaks
    ("/// Of the rows.\nint rows();\n", "fragment"),
    ("int rows;  ///< of the program\n", "fragment"),
    ("/// What a solve has come\n/// to.\n", "phrase"),
    ("/// In radians, which is the unit of every angle.\n", None),
    ("/// Number of rows.\nint rows();\n", None),
    ("// The plant is told of it.\n", "phrase"),
    ('const char* text = "is told";\n', None),
    ("// An event comes to rest.\n", None),
]
PAGES = [
    (WIDE, "wide"),
    (f"| {WIDE} |", None),
    (f"```\n{WIDE}\n```", None),
    (LONG, "long"),
    (LONG.replace("word word word", "word. Word word", 1), None),
    (f"- {LONG[:60]}\n- {LONG[:60]}\n- {LONG[:60]}", None),
    ("The term gives way.", "phrase"),
    ("The term `gives way`.", None),
]

assert len(WIDE) > check_language.MOST_COLUMNS
for check, cases in ((check_language.check_source, SOURCES), (check_language.check_page, PAGES)):
    for text, rule in cases:
        found = [hit[1] for hit in check(text)]
        assert rule in found if rule else not found, (text, found)

with tempfile.TemporaryDirectory() as root:
    def run(*arguments):
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            return check_language.main([root, *arguments]), said.getvalue()

    page = pathlib.Path(root, "docs", "page.md")
    page.parent.mkdir()
    pathlib.Path(root, "tests", "packaging").mkdir(parents=True)
    page.write_text(LONG + "\n\n" + LONG, encoding="utf-8")
    assert run()[0] == 1
    assert run("--write")[0] == 0 and run()[0] == 0
    page.write_text(LONG, encoding="utf-8")
    status, said = run()
    assert status == 0 and "1 limits can be lowered" in said, said
    assert run("--write")[0] == 0
    page.write_text(LONG + "\n\n" + LONG, encoding="utf-8")
    status, said = run("--write")  # a limit never rises
    assert status == 1 and "docs has 2 places of kind 'long', at most 1" in said, said
print(f"{len(SOURCES) + len(PAGES)} texts")
