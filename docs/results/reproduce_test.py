#!/usr/bin/env python3
"""Does reproduce.py see what differs from a printed table, and nothing else?"""

import json
import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import reproduce  # noqa: E402
from programs import is_whole  # noqa: E402
from sentence import Sentence  # noqa: E402


class Agreement(unittest.TestCase):
    def test_one_unit_of_the_last_digit_is_rounding(self):
        self.assertTrue(reproduce.agree("0.559 s", "0.560 s", False))
        self.assertFalse(reproduce.agree("0.559 s", "0.561 s", False))
        self.assertTrue(reproduce.agree("1.2e-08", "1.3e-08", False))
        self.assertFalse(reproduce.agree("100 %", "102 %", False))

    def test_words_count_to_the_letter(self):
        self.assertFalse(reproduce.agree("yes", "fell at 3.32 s", False))
        self.assertFalse(reproduce.agree("12 mm", "12 N", False))
        self.assertFalse(reproduce.agree("", "0.1", False))

    def test_times_may_be_three_times_as_long(self):
        self.assertTrue(reproduce.agree("0.10 s", "0.29 s", True))
        self.assertFalse(reproduce.agree("0.10 s", "0.40 s", True))

    def test_a_table_is_read_without_its_rule(self):
        text = "| push | yes |\n| --- | --- |\n| 6 N s | no |\n"
        self.assertEqual(reproduce.cells(text), [["push", "yes"], ["6 N s", "no"]])


class Tables(unittest.TestCase):
    def test_every_table_stands_in_its_readme(self):
        for name, table in reproduce.ALL.items():
            there = reproduce.printed(name, table)
            self.assertIsNotNone(there, name)
            rows = reproduce.cells(there)
            titles, count = table.shape()
            self.assertEqual(rows[0], [title.strip() for title in titles], name)
            self.assertEqual(len(rows) - 1, count, name)

    def test_every_picture_is_there(self):
        for path in reproduce.PICTURES:
            self.assertTrue(os.path.exists(os.path.join(reproduce.ROOT, path)), path)

    def test_the_words_around_numbers_stand_in_their_readme(self):
        for name, sentence in reproduce.SENTENCES.items():
            with open(reproduce.readme_of(sentence), encoding="utf-8") as file:
                self.assertIsNotNone(sentence.look_up(file.read()), name)


class Kept(unittest.TestCase):
    def test_a_run_that_was_interrupted_is_none(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertFalse(is_whole(folder))
            for reason, whole in (("interrupted at 2.78 s", False), ("", True), ("fell at 3 s", True)):
                with open(os.path.join(folder, "summary.json"), "w", encoding="utf-8") as file:
                    json.dump({"reason": reason}, file)
                self.assertEqual(is_whole(folder), whole, reason)


class OfASentence(unittest.TestCase):
    sentence = Sentence("It settles in {:.2f} s{} after the landing", [{}], lambda s: [0.123, ""])

    def test_its_lines_may_be_broken_anywhere(self):
        there = self.sentence.look_up("As said, it does. It settles\n  in 0.14 s after\nthe landing.")
        self.assertEqual(there.groups(), ("0.14", ""))

    def test_other_words_are_another_sentence(self):
        self.assertIsNone(self.sentence.look_up("It settles in 0.14 s before the landing"))
        self.assertIsNone(self.sentence.look_up("It settles in a few s after the landing"))

    def test_what_was_made_stands_in_it(self):
        self.assertEqual(self.sentence.text(["0.12", " NOT SO"]), "It settles in 0.12 s NOT SO after the landing")


if __name__ == "__main__":
    unittest.main()
