"""Labels above the bodies: name, what the agent says, and the speed of selected bodies.

Labels are the most expensive drawing. Above `MANY` bodies only the bodies that the caller asks for have one, and
labels are updated five times a second. The page shows a label as plain text, so nothing that an agent says can run.
Where they stand depends on the camera, see `label_layout`, so each browser has its own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Final

import viser

from intellwheels_schemas.messages import Body, Entity
from intellwheels_schemas.rules import is_mobile, parts_of
from intellwheels_viewer.drawings.body_look import extent
from intellwheels_viewer.drawings.label_layout import SCALES, Picture, Placed, Wish, placed
from intellwheels_viewer.drivers import reality_of
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
STAND_IN: Final = "\u25cf stand-in"
"""What stands behind the name of a real chair, and of one whose hardware is simulated."""
ABOVE: Final = 0.12
"""Metres between a body's top and its label."""
_FEET: Final = 0.5
"""Share of a chair's height that it has at its front, where the feet are."""
_NUMBER: Final = re.compile(r"[-+]?[0-9]+(\.[0-9]+)?")


def cut(text: str) -> str:
    """Return a text on one line of at most `LONGEST` characters."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else line[: LONGEST - 1].rstrip() + "…"


def is_data(text: str) -> bool:
    """Return whether a message is for programs: it has two numbers or more, and at least as many as other words."""
    words = text.split()
    numbers = sum(_NUMBER.fullmatch(word) is not None for word in words)
    return numbers >= 2 and 2 * numbers >= len(words)


def name_of(entity: Entity, *, with_speed: bool = True) -> str:
    """Return the name, and the speed if the body moves and it is wanted."""
    if not with_speed or abs(entity.speed) < STILL:
        return entity.name
    return f"{entity.name}  {entity.speed:.2f} m/s"


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
) -> dict[str, Wish]:
    """Return the labels by agent: the name, and above it the newest message of the agent or of a user to the agent.

    Args:
        bodies: Documents by agent.
        entities: States.
        utterances: What was said, newest last. The newest of each agent is shown, however many bodies there are. What
            is for programs, see `is_data`, is shown of wanted agents only.
        now: The simulated time, in seconds.
        wanted: Agents that have a label however many bodies there are.
    """
    recent = [each for each in utterances if 0.0 <= now - each.time < SPOKEN and cut(each.text)]
    spoken = {
        each.speaker: f"\u201c{cut(each.text)}\u201d"
        for each in recent
        if each.speaker != USER and (each.speaker in wanted or not is_data(each.text))
    }
    told = {each.to: f"User: \u201c{cut(each.text)}\u201d" for each in recent if each.speaker == USER}
    shown = named(bodies, entities, {*wanted, *spoken, *(agent for agent in told if agent is not None)})
    return {
        entity.name: _tag(
            bodies[entity.name],
            entity,
            [text for text in (told.get(entity.name) or told.get(None), spoken.get(entity.name)) if text is not None],
            wanted=entity.name in wanted,
        )
        for entity in shown
    }


def unlabelled(bodies: Mapping[str, Body], entities: Sequence[Entity], tagged: Collection[str]) -> list[Wish]:
    """Return the bodies without a label, which the labels of others should not cover; none if there are many."""
    if len(entities) > MANY:
        return []
    return [_wish(bodies[e.name], e, "") for e in entities if e.name in bodies and e.name not in tagged]


def _tag(body: Body, entity: Entity, bubbles: Sequence[str], *, wanted: bool) -> Wish:
    name = name_of(entity, with_speed=wanted)
    mark = {"real": f"  {REAL}", "stand-in": f"  {STAND_IN}", "simulated": ""}[reality_of(body.robot)]
    return _wish(body, entity, "\n".join([*bubbles, name + mark]), alone=wanted or bool(bubbles))


def _wish(body: Body, entity: Entity, text: str, *, alone: bool = False) -> Wish:
    hull = extent(parts_of(body.robot))
    ahead, left = (hull.rear + hull.front) / 2, (hull.right + hull.left) / 2
    cos, sin = math.cos(entity.heading), math.sin(entity.heading)
    return Wish(
        entity.name,
        text,
        entity.x + ahead * cos - left * sin,
        entity.y + ahead * sin + left * cos,
        hull.top + ABOVE,
        body.robot.kind,
        alone=alone,
        heading=entity.heading,
        half=(hull.length / 2, hull.width / 2),
        front=_FEET if body.robot.kind == "wheelchair" else 1.0,
    )


class Labels:
    """The labels in a scene: a node for each agent, which is kept while hidden.

    Args:
        scene: The scene of a browser, or that of all.
        name: The node above the labels.
    """

    def __init__(self, scene: viser.SceneApi, name: str = "/labels") -> None:
        self._scene, self._name = scene, name
        self._nodes: dict[str, viser.LabelHandle] = {}
        self._shown: dict[str, Placed] = {}

    def show(self, wishes: Mapping[str, Wish], picture: Picture | None, others: Sequence[Wish] = ()) -> None:
        """Show the labels by agent, see `tags`, as they fit a picture; without a picture each above its body.

        Args:
            wishes: The labels.
            picture: The camera.
            others: Bodies without a label, see `unlabelled`.
        """
        if picture is None:
            found = [
                Placed(
                    (wish.name,),
                    wish.text,
                    (wish.x, wish.y + max(wish.half), wish.z),
                    SCALES[-1][1],
                    (0.0, 0.0, 0.0, 0.0),
                )
                for wish in wishes.values()
            ]
        else:
            found = placed([*wishes.values(), *others], picture)
        shown = {one.names[0]: one for one in found}
        for name in self._shown.keys() - shown.keys():
            self._nodes[name].visible = False
        for name, one in shown.items():
            node = self._nodes.get(name)
            if node is None:
                self._nodes[name] = self._scene.add_label(
                    f"{self._name}/{name}",
                    one.text,
                    position=one.position,
                    font_screen_scale=one.scale,
                    anchor="bottom-center",
                )
                continue
            before = self._shown.get(name)
            if before is None:
                node.visible = True
            # Comparing is cheaper than assigning an equal value in viser.
            if before is None or before.text != one.text:
                node.text = one.text
            if before is None or before.scale != one.scale:
                node.font_screen_scale = one.scale
            if before is None or before.position != one.position:
                node.position = one.position
        self._shown = shown
