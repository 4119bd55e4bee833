"""A sentence of a README with numbers in it: the words around them, and the runs that they come from."""

import dataclasses
import re
import string
from typing import Callable, Dict, List

from tables import README


@dataclasses.dataclass
class Sentence:
    """A README says these words with these numbers, however its lines are broken. A field for words such as {}
    stands for nothing while the claim holds, and says what is not so if it does not. What {:d} stands for is a count."""
    words: str  # with {} where the numbers come
    runs: List[Dict[str, object]]  # settings of push_recovery
    numbers: Callable  # (summaries) -> the numbers; (programs) where there are no runs
    readme: str = README
    quick: bool = True
    timed: bool = False  # its numbers are times

    def pieces(self, programs):
        """What stands in the fields."""
        found = self.numbers([programs.run(settings) for settings in self.runs] if self.runs else programs)
        formats = self.formats()
        if len(formats) != len(found):
            raise ValueError(f"{len(formats)} fields, but {len(found)} numbers: {self.words}")
        return [format(value, spec) for spec, value in zip(formats, found)]

    def formats(self):
        return [spec for _, field, spec, _ in string.Formatter().parse(self.words) if field is not None]

    def counts(self, pieces):
        """Of what stands in the fields that which has to be so to the letter."""
        return [piece for piece, spec in zip(pieces, self.formats()) if spec.endswith("d")]

    def text(self, pieces):
        return re.sub(r"\{[^}]*\}", "{}", self.words).format(*pieces)

    def look_up(self, text):
        """Where a README says it, with a group for each field; None if it does not."""
        pattern = ""
        for literal, field, spec, _ in string.Formatter().parse(self.words):
            pattern += re.sub(r"(\\\s|\s)+", r"\\s+", re.escape(literal))
            if field is not None:
                pattern += r"([-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?)" if spec else "(.{0,80}?)"
        return re.search(pattern, text, re.DOTALL)
