#!/usr/bin/env python3
"""Checks the rewritten headers for Doxygen, and which links count as dead."""

import os
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import make  # noqa: E402
import public_headers  # noqa: E402


def rewritten(*lines):
    return public_headers.rewritten("saltus/a.hpp", list(lines)).splitlines()


class Sidebar(unittest.TestCase):
    def test_lists_of_names_are_one_entry(self):
        with tempfile.TemporaryDirectory() as folder:
            files = {"navtreedata.js": '    [ "Theory", "t.html", "t" ],\n    [ "Classes", "a.html", [\n'
                                       '      [ "Class List", "a.html", "annotated_dup" ]\n    ] ]\n',
                     "navtreeindex0.js": '"t.html#x":[0,3,1],\n"classA.html":[1,0,7,2]\n'}
            for name, text in files.items():
                with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                    file.write(text)
            make.shorten_sidebar(folder)
            for name, text in files.items():
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    self.assertEqual(file.read(), text.replace('"annotated_dup"', "null").replace("[1,0,7,2]", "[1,0]"))


class Headers(unittest.TestCase):
    def test_comments_belong_to_their_declarations(self):
        self.assertEqual(rewritten("// One idea.", "#pragma once"),
                         ["/// One idea.", "/// \\file saltus/a.hpp"])
        self.assertEqual(rewritten("", "  double thrust;  // N")[1], "  double thrust;  ///< N")
        self.assertEqual(rewritten("", "  double x = f(1, 2), y;  ///< m")[1],
                         "  double x = f(1, 2); /**< m */ double y; /**< m */")
        self.assertEqual(rewritten("", "  /// m", "  Vec<S, 3> x, y;")[2],
                         "  Vec<S, 3> x; /**< m */ Vec<S, 3> y; /**< m */")

    def test_functions_under_one_comment_share_it(self):
        self.assertEqual(rewritten("", "/// A row;", "/// or its head.", "std::string head();", "std::string row(int i);")[3:],
                         ["std::string head();", "/** A row; or its head. */ std::string row(int i);"])
        self.assertEqual(rewritten("", "/// A row.", "std::string row(int i);", "", "std::string head();")[4],
                         "std::string head();")

    def test_self_explanatory_declarations(self):
        self.assertIn("Deleted.", rewritten("", "  Part(const Part&) = delete;")[1])
        for line in ("  Part(Part&& other) noexcept;", "  Part& operator=(const Part& other);"):
            self.assertEqual(rewritten("", line)[1], f"  /** \\cond */ {line.strip()} /** \\endcond */")

    def test_deprecated_names_are_hidden(self):
        self.assertEqual(rewritten("", "  /// Deprecated name.", '  [[deprecated("use b{")]] int a() {', "    return b();", "  }", "  int b();"),
                         ["", "", '/** \\cond */ [[deprecated("use b{")]] int a() {', "    return b();",
                          "  } /** \\endcond */", "  int b();"])

    def test_undocumented_names_stay_undocumented(self):
        for line in ("int rows() const { return rows_; }", "struct Options {", "double thrust;",
                     "double x, y;", "Part(int rows, int columns);"):
            self.assertEqual(rewritten("", line)[1], line)

    def test_lines_keep_their_numbers(self):
        for name, path in public_headers.public_headers():
            with open(path, encoding="utf-8") as file:
                lines = file.read().splitlines()
            self.assertEqual(len(public_headers.rewritten(name, lines).splitlines()), len(lines), name)


class Pages(unittest.TestCase):
    def test_dead_links_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "a.html"), "w", encoding="utf-8") as file:
                file.write('<h1 id="top"></h1><a href="#top"></a><a href="b.html#there"></a><a href="c.html"></a>'
                           '<a href="https://x.org"></a><a href="#lost"></a><script src="https://x.org/a.js"></script>')
            with open(os.path.join(folder, "b.html"), "w", encoding="utf-8") as file:
                file.write('<h2 id="there"></h2>')
            wrong, pages, _ = make.check_links(folder)
            self.assertEqual(pages, 2)
            self.assertEqual(sorted(wrong), ["a.html loads https://x.org/a.js", "a.html: c.html leads nowhere",
                                             "a.html: there is no #lost"])

    def test_links_between_pages(self):
        lacking = []
        page = make.Page("docs/howto.md", ["docs/howto.md", "docs/tutorial.md"],
                         {"framework/saltus/ocp/phase.hpp": "saltus/ocp/phase.hpp"}, {}, make.Formulas(), lacking)
        self.assertEqual(page.words("[a](tutorial.md#6-under-control)"), '\\ref page_docs_tutorial__6_under_control "a"')
        self.assertEqual(page.words("[`Phase`](../framework/saltus/ocp/phase.hpp)"), '\\ref saltus/ocp/phase.hpp "Phase"')
        self.assertEqual(page.words("`[a](b)`"), "`[a](b)`")
        page.words("[a](nowhere.md)")
        self.assertEqual(len(lacking), 1)


class Script(unittest.TestCase):
    def refused(self, folder, out):
        """The error of ./saltus docs, called in this folder with an extra argument."""
        done = subprocess.run([os.path.join(make.ROOT, "saltus"), "docs", "--out", out, "one-too-many"], cwd=folder, text=True,
                              capture_output=True, check=False)
        self.assertEqual(done.returncode, 2, done.stderr)
        return done.stderr

    def test_folder_is_relative_to_the_caller(self):
        with tempfile.TemporaryDirectory() as folder:
            os.makedirs(os.path.join(folder, "mine"))
            self.assertIn("one-too-many", self.refused(folder, "mine"))
            self.assertIn("one-too-many", self.refused(folder, "docs"))  # the clone has a folder of this name
            with open(os.path.join(folder, "mine/a.txt"), "w", encoding="utf-8") as file:
                file.write("a")
            self.assertIn("the folder has other files", self.refused(folder, "mine"))


if __name__ == "__main__":
    unittest.main()
