"""Events as sentences: a table of templates by event code. The result is plain text, not HTML."""

from __future__ import annotations

import re
from typing import Final

from intellwheels_schemas.messages import Event, EventCode
from intellwheels_viewer.panels import number_format

SENTENCES: Final[dict[EventCode, str]] = {
    "joined": "{agent} joined{role}",
    "left": "{agent} left{role}",
    "lost": "{agent} was lost{role}: its connection broke",
    "returned": "{agent} reconnected in time",
    "contact": "{agent} hit {other}{speed}",
    "parted": "{agent} is clear of {other}",
    "stale": "{agent} is stale: no recent pose",
    "fresh": "{agent} is reporting its pose again",
    "late": "{agent} missed a deadline",
    "rested": "{agent} is resting: it missed three deadlines",
    "back": "{agent} is answering again",
    "timeout": "{agent} got no command in time, power is 0",
    "taken": "A user took over {agent}",
    "released": "The user released {agent}",
    "spawned": "A user placed {agent}",
    "deleted": "A user removed {agent}",
    "teleported": "A user moved {agent}",
    "paused": "Paused",
    "resumed": "Resumed",
    "speed": "Speed {factor} \u00d7",
    "reset": "A new run started",
    "loaded": "Map loaded: {text}",
    "ended": "The run ended",
}


_HASH: Final = re.compile(r",? hash [0-9a-f]{8,}")
"""The hash of a state, at the end of the reason of an end. A person cannot read it; `iw-run` prints it."""


def sentence(event: Event) -> str:
    """Return an event as a sentence, without its time."""
    template = SENTENCES[event.code]
    said = template.format(
        agent=event.agent or "Somebody",
        other="a wall" if event.other == "wall" else event.other or "something",
        speed="" if event.speed is None else f" at {number_format.decimal(abs(event.speed))} m/s",
        factor=number_format.factor(event.speed or 1.0),
        text=event.text or "unnamed",
        role=" as a mind" if event.text == "mind" else "",
    )
    told = event.text is None or "{text}" in template or "{role}" in template
    return said if told else f"{said}: {_HASH.sub('', event.text or '')}"
