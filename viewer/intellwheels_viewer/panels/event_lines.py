"""The lines of the list of events: which there are, and which of them are one line. Pure.

A body that scrapes along another one touches it again and again. Contacts of the same pair within `TOGETHER` are one
line with their number.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from intellwheels_schemas.messages import Event, EventCode
from intellwheels_viewer.panels import number_format
from intellwheels_viewer.panels.sentences import sentence

Kind: TypeAlias = Literal["Contacts", "Agents", "Run", "Words"]

TOGETHER: Final = 5.0
"""Simulated seconds between two contacts of the same pair that are one line."""
_CONTACTS: Final[frozenset[EventCode]] = frozenset({"contact", "parted"})
_RUN: Final[frozenset[EventCode]] = frozenset({"paused", "resumed", "speed", "reset", "loaded", "ended"})


@dataclass(frozen=True)
class EventLine:
    """A line of the list.

    Attributes:
        event: The newest event of the line.
        text: The line in words, without its time.
        count: The number of contacts of the line; 1 for all other events.
    """

    event: Event
    text: str
    count: int = 1


def kind_of(event: Event) -> Kind:
    """Return what an event is about: contacts, agents, or the run."""
    if event.code in _CONTACTS:
        return "Contacts"
    return "Run" if event.code in _RUN else "Agents"


def event_lines(events: Sequence[Event], period: float) -> list[EventLine]:
    """Return the lines of events, newest first.

    Args:
        events: In the order in which they happened.
        period: The simulated seconds of a tick; 0 while unknown, when no contacts are joined.
    """
    lines: list[EventLine] = []
    # For each pair of the run its line, and the contacts in it.
    open_lines: dict[tuple[str, frozenset[str | None]], tuple[int, list[Event]]] = {}
    dropped: set[int] = set()
    for event in events:
        pair = (event.run, frozenset((event.agent, event.other)))
        if event.code == "contact":
            at, contacts = open_lines.get(pair, (-1, []))
            if contacts and period > 0 and (event.tick - contacts[-1].tick) * period <= TOGETHER:
                dropped.add(at)
                # Between two contacts of one line nobody needs to know that the pair had parted.
                dropped.update(k for k in range(at + 1, len(lines)) if _parts(lines[k].event, pair))
                contacts = [*contacts, event]
            else:
                contacts = [event]
            open_lines[pair] = (len(lines), contacts)
            lines.append(EventLine(event, _joined(contacts), len(contacts)))
        else:
            lines.append(EventLine(event, sentence(event)))
    return [line for k, line in reversed([*enumerate(lines)]) if k not in dropped]


def _parts(event: Event, pair: tuple[str, frozenset[str | None]]) -> bool:
    return event.code == "parted" and (event.run, frozenset((event.agent, event.other))) == pair


def _joined(contacts: Iterable[Event]) -> str:
    found = list(contacts)
    if len(found) == 1:
        return sentence(found[0])
    fastest = max((abs(event.speed) for event in found if event.speed is not None), default=None)
    first = found[0]
    other = "a wall" if first.other == "wall" else first.other or "something"
    speed = "" if fastest is None else f", at most {number_format.decimal(fastest)} m/s"
    return f"{first.agent or 'Somebody'} hit {other} {len(found)} times{speed}"
