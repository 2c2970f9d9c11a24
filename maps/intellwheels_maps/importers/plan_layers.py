"""What a layer of a drawing holds, told by its name. Pure.

Words are those of layer standards (AIA `A-WALL`, ISO 13567 descriptions) and of drawings in six languages.
"""

from __future__ import annotations

import re
from typing import Final, Literal

Part = Literal["wall", "window", "door"]

_WORDS: Final[dict[Part, str]] = {
    "door": r"doors?|t(?:ü|ue)r(?:en)?|portes?|portas?|puertas?|porta",
    "window": r"win(?:d|dows?)?|glaz(?:ing)?|glas{1,2}|fenster|fen(?:ê|e)tres?|janelas?|ventanas?|finestre?",
    "wall": r"walls?|w(?:a|ae|ä)nde?|mauern?|murs?|muros?|paredes?|pared|mur[io]|concr(?:ete)?|columns?|cols?|pillars?"
    r"|partitions?|st(?:ü|ue)tzen?|pilar(?:es)?",
}
_PATTERNS: Final = {
    part: re.compile(rf"(?:^|[^a-zäöüê])(?:{words})(?:$|[^a-zäöüê])", re.IGNORECASE) for part, words in _WORDS.items()
}


def part_of(layer: str, block: str = "") -> Part | None:
    """Return what the things on a layer are, or None if its name does not tell.

    Args:
        layer: The name of the layer.
        block: The name of a block on it, which counts more than that of the layer.
    """
    for name in (block, layer):
        for part, pattern in _PATTERNS.items():
            # A digit separates too: `door1000a`.
            if name and pattern.search(name[:200]):
                return part
    return None
