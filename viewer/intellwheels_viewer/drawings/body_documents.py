"""Data from body documents for drawings, computed once per document: states change every tick, documents rarely."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from intellwheels_schemas.messages import Body, Robot
from intellwheels_schemas.rules import is_mobile, parts_of
from intellwheels_viewer.drawings.body_look import Extent, extent
from intellwheels_viewer.drawings.looks import Shape, shape_of


@dataclass(frozen=True)
class BodyDocument:
    """The drawn properties of a body.

    Attributes:
        look: A number that equal looks share.
        robot: The document.
        hull: The box around its parts.
        is_mobile: Whether it can drive by itself.
        occupied: Whether somebody sits in it.
    """

    look: int
    robot: Robot
    hull: Extent
    is_mobile: bool
    occupied: bool


class BodyDocuments:
    """Cached documents by agent, valid while the agent's `Body` is the same object."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, bool], tuple[Body, BodyDocument]] = {}
        self._looks: dict[Shape, int] = {}

    def of(self, bodies: Mapping[str, Body], *, crowd: bool) -> dict[str, BodyDocument]:
        """Return the document of each body, and forget bodies that have left."""
        known: dict[tuple[str, bool], tuple[Body, BodyDocument]] = {}
        for name, body in bodies.items():
            key = (name, crowd)
            before = self._known.get(key)
            known[key] = before if before is not None and before[0] is body else (body, self._document(body, crowd))
        self._known = known
        return {name: document for (name, _), (_, document) in known.items()}

    def _document(self, body: Body, crowd: bool) -> BodyDocument:
        robot, occupied = body.robot, is_occupied(body)
        look = self._looks.setdefault(shape_of(robot, crowd=crowd, occupied=occupied), len(self._looks))
        return BodyDocument(look, robot, extent(parts_of(robot)), is_mobile(robot), occupied)


def is_occupied(body: Body) -> bool:
    """Return whether somebody sits in a body: it is a chair with a mind, or a real one."""
    driven = body.robot.type == "real" or any(role in ("mind", "both") for role in body.roles)
    return body.robot.kind == "wheelchair" and is_mobile(body.robot) and driven
