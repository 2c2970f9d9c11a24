"""What one browser chose, beside what is seen of the run: the second half of what a panel is drawn from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

RGB: TypeAlias = tuple[int, int, int]


@dataclass(frozen=True)
class Choices:
    """A browser's own state.

    Attributes:
        selected: The agent that is selected; it may have gone.
        colours: The sRGB colour, 0 to 255, of each agent, in the order in which they got it; other bodies are grey.
        allowed: Whether this viewer has the right to steer.
        placing: The label of what the next click on the floor places, see `place.PALETTE`.
        refusal: Why the last wish was refused, in the simulator's words; empty: it was not.
        quiet: Seconds of wall time since the last clock.
    """

    selected: str | None = None
    colours: Mapping[str, RGB] = field(default_factory=dict)
    allowed: bool = True
    placing: str | None = None
    refusal: str = ""
    quiet: float = 3.0
