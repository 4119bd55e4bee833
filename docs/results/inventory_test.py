#!/usr/bin/env python3
"""Is every number of the READMEs made by a table or a sentence, or said to be something else than a measurement?"""

import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import inventory  # noqa: E402


class Numbers(unittest.TestCase):
    def test_every_number_is_made_or_given(self):
        for readme in inventory.readmes():
            found, absent = inventory.numbers(readme)
            self.assertEqual(absent, [])
            self.assertEqual([f"{n.readme}:{n.line}: {n.text}" for n in found if n.maker is None], [])

    def test_a_number_that_nothing_makes_is_seen(self):
        found, absent = inventory.look("problems/push_recovery/experiments.md", "It settles in 0.37s (`--wait 3`, see [2](a4.md)).")
        self.assertEqual([n.text for n in found if n.maker is None], ["0.37", "2"])
        self.assertNotEqual(absent, [])  # what is declared does not stand there

    def test_a_table_that_nothing_makes_is_seen(self):
        found, absent = inventory.look("README.md", "<!-- table: none -->\n| 1 |\n<!-- end of table -->")
        self.assertEqual([n.maker for n in found], [None])
        self.assertIn("README.md: nothing makes the table none", absent)


if __name__ == "__main__":
    unittest.main()
