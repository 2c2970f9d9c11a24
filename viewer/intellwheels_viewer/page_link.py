"""A link to a view: the query of the page's address holds its camera, its selection and the tick. Pure."""

from __future__ import annotations

import math
from typing import Final, NamedTuple, cast, get_args
from urllib.parse import parse_qs, urlencode

from intellwheels_schemas.names import is_name
from intellwheels_viewer.cameras import Mode

Point = tuple[float, float, float]

FAR: Final = 1e5
"""Greatest distance of a camera from the origin, in metres."""


class PageLink(NamedTuple):
    """A view.

    Attributes:
        mode: The camera's mode; None if the link does not say.
        agent: The selected body, or None.
        tick: The tick that was shown, or None.
        eye, to: The position of the camera and the point that it looks at, in metres; None if the link does not say.
    """

    mode: Mode | None = None
    agent: str | None = None
    tick: int | None = None
    eye: Point | None = None
    to: Point | None = None


def query_of(link: PageLink) -> str:
    """Return the query of a link, with its question mark."""
    said: dict[str, str] = {}
    if link.mode is not None:
        said["camera"] = link.mode
    if link.agent is not None:
        said["agent"] = link.agent
    if link.tick is not None:
        said["tick"] = str(link.tick)
    if link.eye is not None and link.to is not None:
        said["eye"], said["to"] = (",".join(f"{value:.3f}" for value in point) for point in (link.eye, link.to))
    return "?" + urlencode(said, safe=",")


def link_of(query: str) -> tuple[PageLink, list[str]]:
    """Return the view of a query, and a sentence for each part of it that cannot be used."""
    said = {name: values[-1] for name, values in parse_qs(query.removeprefix("?")).items()}
    wrong: list[str] = []
    mode, agent, tick = said.get("camera"), said.get("agent"), said.get("tick")
    if mode is not None and mode not in get_args(Mode):
        wrong.append(f"camera: expected one of {', '.join(get_args(Mode))}, got {mode[:40]!r}")
        mode = None
    if agent is not None and not is_name(agent):
        wrong.append(f"agent: expected the name of a body, got {agent[:40]!r}")
        agent = None
    if tick is not None and not (tick.isascii() and tick.isdigit() and len(tick) < 12):
        wrong.append(f"tick: expected a whole number, got {tick[:40]!r}")
        tick = None
    points = []
    for name in ("eye", "to"):
        point = None if name not in said else _point(said[name])
        if name in said and point is None:
            wrong.append(f"{name}: expected three numbers of metres, got {said[name][:40]!r}")
        points.append(point)
    eye, to = points
    if eye is None or to is None or math.dist(eye, to) < 1e-3:
        eye = to = None
    return PageLink(cast("Mode | None", mode), agent, None if tick is None else int(tick), eye, to), wrong


def _point(text: str) -> Point | None:
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        return None
    if len(found) != 3 or not all(math.isfinite(value) and abs(value) <= FAR for value in found):
        return None
    return found
