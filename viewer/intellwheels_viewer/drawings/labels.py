"""Who is who, how fast, and what they say: a small name above each that goes, a bubble above the name.

Labels cost the most of all drawings: above `MANY` bodies only those named by the caller have one, and five times a
second is enough. A label is plain text to the page, so that nothing an agent says can run.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import viser

from intellwheels_schemas.messages import Body, Entity
from intellwheels_schemas.rules import has_motors, parts_of
from intellwheels_viewer.drawings.model import extent
from intellwheels_viewer.seen import Words

MANY: Final = 30
"""Above so many bodies only some have names."""
LONGEST: Final = 40
"""Characters of a bubble; what was cut ends in three points."""
SPOKEN: Final = 3.0
"""Seconds of simulated time that a bubble stays."""
STILL: Final = 0.005
"""Metres per second under which a speed is not written."""

_ABOVE: Final = 0.12
_BUBBLE: Final = 0.30


@dataclass(frozen=True)
class Tag:
    """A label: what it says and where its lower edge is, in metres."""

    text: str
    x: float
    y: float
    z: float


def cut(text: str) -> str:
    """Return a text on one line of at most `LONGEST` characters."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else line[: LONGEST - 1].rstrip() + "…"


def name_of(entity: Entity) -> str:
    """Return a name with the speed beside it; what stands has none."""
    return entity.name if abs(entity.speed) < STILL else f"{entity.name}  {entity.speed:.2f} m/s"


def named(bodies: Mapping[str, Body], entities: Sequence[Entity], wanted: Collection[str]) -> list[Entity]:
    """Return those with a name: the wanted, and while there are few all that go by themselves."""
    few = len(entities) <= MANY
    return [
        entity
        for entity in entities
        if entity.name in bodies and (entity.name in wanted or (few and _goes(bodies[entity.name])))
    ]


def _goes(body: Body) -> bool:
    return has_motors(body.robot) and not body.robot.anchored


def tags(
    bodies: Mapping[str, Body], entities: Sequence[Entity], words: Iterable[Words], now: float, wanted: Collection[str]
) -> tuple[dict[str, Tag], dict[str, Tag]]:
    """Return the names and the bubbles, by agent.

    Args:
        bodies: Documents by agent.
        entities: States.
        words: What was said, newest last; of each agent the newest is shown, also of those without a name.
        now: The simulated time, in seconds.
        wanted: Who has a name however many there are.
    """
    heights = {entity.name: _height(bodies.get(entity.name)) for entity in entities}
    names = {
        entity.name: Tag(name_of(entity), entity.x, entity.y, heights[entity.name])
        for entity in named(bodies, entities, wanted)
    }
    spoken = {each.speaker: each.text for each in words if 0.0 <= now - each.time < SPOKEN}
    bubbles = {
        entity.name: Tag(cut(spoken[entity.name]), entity.x, entity.y, heights[entity.name] + _BUBBLE)
        for entity in entities
        if spoken.get(entity.name, "").strip()
    }
    return names, bubbles


def _height(body: Body | None) -> float:
    return _ABOVE + (extent(parts_of(body.robot)).top if body is not None else 0.0)


class Labels:
    """The labels in a scene: a node for each name and bubble, kept when it is not shown."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._names: dict[str, viser.LabelHandle] = {}
        self._bubbles: dict[str, viser.LabelHandle] = {}

    def show(
        self,
        bodies: Mapping[str, Body],
        entities: Sequence[Entity],
        words: Iterable[Words],
        now: float,
        wanted: Collection[str] = frozenset(),
    ) -> None:
        """Show names and bubbles; the arguments are those of `tags`."""
        names, bubbles = tags(bodies, entities, words, now, wanted)
        self._assign("/labels/names", self._names, names, 0.8)
        self._assign("/labels/bubbles", self._bubbles, bubbles, 0.95)

    def _assign(self, path: str, nodes: dict[str, viser.LabelHandle], shown: Mapping[str, Tag], scale: float) -> None:
        for name in nodes.keys() - shown.keys():
            nodes[name].visible = False
        for name, tag in shown.items():
            place = (tag.x, tag.y, tag.z)
            if name not in nodes:
                nodes[name] = self._scene.add_label(
                    f"{path}/{name}", tag.text, position=place, font_screen_scale=scale, anchor="bottom-center"
                )
                continue
            node = nodes[name]
            node.text, node.position, node.visible = tag.text, place, True
