"""A part of a batch: the share of its runs that one of several machines makes.

    iw-run SCENE --seeds 400 --part 2/8 --out here     on the second of eight machines, or in a job array
    iw-run SCENE --seeds 400 --merge a --merge b       the report of all runs

A run is the same on any machine, so the merged batch has the CSV that one machine would have written.
`collect_runs` brings the runs together.
"""

from __future__ import annotations

import argparse
import re
from typing import Final, NamedTuple

_FORM: Final = re.compile(r"([1-9]\d{0,5})/([1-9]\d{0,5})")


class Part(NamedTuple):
    """A share of the runs of a batch.

    Attributes:
        number: From 1 to `of`.
        of: Number of parts.
    """

    number: int
    of: int

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"

    def holds(self, index: int) -> bool:
        """Return whether the run at this index, counted from 0 by row and then by seed, is in the part."""
        return index % self.of == self.number - 1


WHOLE: Final = Part(1, 1)


def part(text: str) -> Part:
    """Return a part from its text, such as `2/8`. For argparse.

    Raises:
        argparse.ArgumentTypeError: The text has another form, or the number is larger than the number of parts.
    """
    found = _FORM.fullmatch(text)
    if found is None or int(found[1]) > int(found[2]):
        raise argparse.ArgumentTypeError(f"expected I/N with I from 1 to N, such as 2/8, got {text!r}")
    return Part(int(found[1]), int(found[2]))
