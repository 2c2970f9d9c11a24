"""Events as sentences. A table: a code, and its sentence with the event's own words in it. Plain text, not yet HTML."""

from __future__ import annotations

from typing import Final

from intellwheels_schemas.messages import Event, EventCode
from intellwheels_viewer.panels import number_format

SENTENCES: Final[dict[EventCode, str]] = {
    "joined": "{agent} joined{role}",
    "left": "{agent} left{role}",
    "lost": "{agent} was lost{role}: its connection went",
    "returned": "{agent} came back in time",
    "contact": "{agent} hit {other}{speed}",
    "parted": "{agent} is clear of {other}",
    "stale": "{agent} is stale: its pose is too old",
    "fresh": "{agent} reports its pose again",
    "late": "{agent} missed a deadline",
    "rested": "{agent} rests: it missed three deadlines",
    "back": "{agent} answers again",
    "timeout": "{agent} got no command in time: power 0",
    "taken": "An operator took {agent} over",
    "released": "{agent} was given back",
    "spawned": "An operator placed {agent}",
    "deleted": "An operator removed {agent}",
    "teleported": "An operator moved {agent}",
    "paused": "Paused",
    "resumed": "Resumed",
    "speed": "Speed {factor} \u00d7",
    "reset": "The run began anew",
    "loaded": "Another floor: {text}",
    "ended": "The run ended",
}


def sentence(event: Event) -> str:
    """Return what happened, without its time."""
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
    return said if told else f"{said}: {event.text}"
