"""What the drawings need of a body's document, found once: documents change when somebody joins, states every tick."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from intellwheels_schemas.messages import Body, Robot
from intellwheels_schemas.rules import has_motors, parts_of
from intellwheels_viewer.drawings.body_look import Extent, extent
from intellwheels_viewer.drawings.looks import Shape, shape_of


@dataclass(frozen=True)
class BodyDocument:
    """A body's form.

    Attributes:
        look: A number that bodies share when they look the same.
        robot: The document.
        hull: The box around its parts.
        goes: Whether it goes about by itself.
    """

    look: int
    robot: Robot
    hull: Extent
    goes: bool


class BodyDocuments:
    """The forms of bodies by agent, for as long as the agent's document is the same object."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, bool], tuple[Body, BodyDocument]] = {}
        self._looks: dict[Shape, int] = {}

    def of(self, bodies: Mapping[str, Body], *, crowd: bool) -> dict[str, BodyDocument]:
        """Return the form of each body; those that left are forgotten."""
        known: dict[tuple[str, bool], tuple[Body, BodyDocument]] = {}
        for name, body in bodies.items():
            key = (name, crowd)
            before = self._known.get(key)
            known[key] = before if before is not None and before[0] is body else (body, self._form(body.robot, crowd))
        self._known = known
        return {name: form for (name, _), (_, form) in known.items()}

    def _form(self, robot: Robot, crowd: bool) -> BodyDocument:
        look = self._looks.setdefault(shape_of(robot, crowd=crowd), len(self._looks))
        return BodyDocument(look, robot, extent(parts_of(robot)), has_motors(robot) and not robot.anchored)
