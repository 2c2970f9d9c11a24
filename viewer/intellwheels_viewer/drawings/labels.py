"""Labels above the bodies: name, speed, and what the agent says.

Labels are the most expensive drawing. Above `MANY` bodies only the bodies that the caller asks for have one, and
labels are updated five times a second. The page shows a label as plain text, so nothing that an agent says can run.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import viser

from intellwheels_schemas.messages import Body, Entity
from intellwheels_schemas.rules import is_mobile, parts_of
from intellwheels_viewer.drawings.body_look import extent
from intellwheels_viewer.snapshot import USER, Utterance

MANY: Final = 30
"""Above this many bodies only wanted ones have labels."""
LONGEST: Final = 40
"""Maximum length of a speech bubble in characters; a longer text ends with an ellipsis."""
SPOKEN: Final = 3.0
"""Duration of a speech bubble, in simulated seconds."""
STILL: Final = 0.005
"""Metres per second below which a speed is not shown."""

REAL: Final = "\u25cf real"
"""What stands behind the name of a real chair."""
ABOVE: Final = 0.12
"""Metres between a body's top and its label."""
ASIDE: Final = 0.6
"""Offset of a label to the north in body widths, so that it does not cover the body in the plan."""


@dataclass(frozen=True)
class Tag:
    """A label: its text and the position of its lower edge, in metres."""

    text: str
    x: float
    y: float
    z: float


def cut(text: str) -> str:
    """Return a text on one line of at most `LONGEST` characters."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else line[: LONGEST - 1].rstrip() + "…"


def name_of(entity: Entity) -> str:
    """Return the name, and the speed if the body moves."""
    return entity.name if abs(entity.speed) < STILL else f"{entity.name}  {entity.speed:.2f} m/s"


def named(bodies: Mapping[str, Body], entities: Sequence[Entity], wanted: Collection[str]) -> list[Entity]:
    """Return the bodies with labels: the wanted ones and, if there are few bodies, all mobile ones."""
    few = len(entities) <= MANY
    return [
        entity
        for entity in entities
        if entity.name in bodies and (entity.name in wanted or (few and is_mobile(bodies[entity.name].robot)))
    ]


def tags(
    bodies: Mapping[str, Body],
    entities: Sequence[Entity],
    utterances: Iterable[Utterance],
    now: float,
    wanted: Collection[str],
) -> dict[str, Tag]:
    """Return the labels by agent: the name, and above it the newest message of the agent or of a user to the agent.

    Args:
        bodies: Documents by agent.
        entities: States.
        utterances: What was said, newest last. The newest of each agent is shown, however many bodies there are.
        now: The simulated time, in seconds.
        wanted: Agents that have a label however many bodies there are.
    """
    recent = [each for each in utterances if 0.0 <= now - each.time < SPOKEN and cut(each.text)]
    spoken = {each.speaker: f"\u201c{cut(each.text)}\u201d" for each in recent if each.speaker != USER}
    told = {each.to: f"User: \u201c{cut(each.text)}\u201d" for each in recent if each.speaker == USER}
    shown = named(bodies, entities, {*wanted, *spoken, *(agent for agent in told if agent is not None)})
    return {
        entity.name: _tag(
            bodies[entity.name],
            entity,
            [text for text in (told.get(entity.name) or told.get(None), spoken.get(entity.name)) if text is not None],
        )
        for entity in shown
    }


def _tag(body: Body, entity: Entity, bubbles: Sequence[str]) -> Tag:
    hull = extent(parts_of(body.robot))
    name = f"{name_of(entity)}  {REAL}" if body.robot.type == "real" else name_of(entity)
    return Tag("\n".join([*bubbles, name]), entity.x, entity.y + ASIDE * hull.width, hull.top + ABOVE)


class Labels:
    """The labels in a scene: a node for each agent, which is kept while hidden."""

    def __init__(self, scene: viser.SceneApi, name: str = "/labels") -> None:
        self._scene, self._name = scene, name
        self._nodes: dict[str, viser.LabelHandle] = {}
        self._shown: dict[str, Tag] = {}

    def show(
        self,
        bodies: Mapping[str, Body],
        entities: Sequence[Entity],
        utterances: Iterable[Utterance],
        now: float,
        wanted: Collection[str] = frozenset(),
    ) -> None:
        """Show the labels; the arguments are those of `tags`."""
        shown = tags(bodies, entities, utterances, now, wanted)
        for name in self._shown.keys() - shown.keys():
            self._nodes[name].visible = False
        for name, tag in shown.items():
            place = (tag.x, tag.y, tag.z)
            node = self._nodes.get(name)
            if node is None:
                self._nodes[name] = self._scene.add_label(
                    f"{self._name}/{name}", tag.text, position=place, font_screen_scale=0.85, anchor="bottom-center"
                )
                continue
            before = self._shown.get(name)
            if before is None:
                node.visible = True
            # Comparing is cheaper than assigning an equal value in viser.
            if before is None or before.text != tag.text:
                node.text = tag.text
            if before is None or (before.x, before.y, before.z) != place:
                node.position = place
        self._shown = shown
