"""A small plan of the map with all bodies.

It is two drawings with the same view box. The map is sent once; the bodies lie over it and are sent at the rate of
the panels. The drawings have no text, which would shrink with the panel: the scale is written below.
"""

from __future__ import annotations

import html
import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final, NamedTuple

import viser

from intellwheels_maps.check import wall_pieces
from intellwheels_schemas.messages import Entity, Map
from intellwheels_viewer.drivers import driver_of
from intellwheels_viewer.panels.callbacks import Pick
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.marks import Mark
from intellwheels_viewer.panels.plan_footprints import Point, footprint, outline, placed
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET
from intellwheels_viewer.snapshot import TRAIL, Sample, Snapshot

CROWD: Final = 60
"""Above this many bodies each is drawn as an outline."""
_TRAIL_STEP: Final = 0.5  # s: closer points cannot be told apart in a small drawing
_MARGIN: Final = 0.3  # m around the walls
_WIDEST: Final = 2.6  # greatest width over height of the view box
_HIGHEST: Final = 1.15  # smallest width over height, as the panel has more than the plan
_ACROSS: Final = 260.0  # px: about the width of the plan, for lengths given in pixels
_BARS: Final = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)


class Frame(NamedTuple):
    """The part of the map that is drawn, in metres. The y axis of SVG points down, so y is written negated."""

    west: float
    north: float
    across: float
    down: float

    @property
    def box(self) -> str:
        """The view box."""
        return f"{_n(self.west)} {_n(-self.north)} {_n(self.across)} {_n(self.down)}"

    @property
    def pixel(self) -> float:
        """The size of about a pixel, in metres."""
        return self.across / _ACROSS


def frame(floor: Map) -> Frame:
    """Return the view box around a map's walls, obstacles and zones, within the limits of its proportions."""
    rings = [one.corner for one in floor.wall]
    rings += [one.corner for one in floor.obstacle]
    rings += [one.corner for one in floor.zone]
    points = [(corner.x, corner.y) for ring in rings for corner in ring] or [(-5.0, -5.0), (5.0, 5.0)]
    xs, ys = [x for x, _ in points], [y for _, y in points]
    across, down = max(xs) - min(xs) + 2 * _MARGIN, max(ys) - min(ys) + 2 * _MARGIN
    wide, high = max(across, down * _HIGHEST), max(down, across / _WIDEST)
    return Frame((min(xs) + max(xs) - wide) / 2, (min(ys) + max(ys) + high) / 2, wide, high)


def floor_svg(floor: Map) -> str:
    """Return the drawing of the map and its scale."""
    view = frame(floor)
    zones = "".join(_polygon([(c.x, c.y) for c in zone.corner]) for zone in floor.zone)
    things = "".join(_polygon([(c.x, c.y) for c in one.corner]) for one in floor.obstacle)
    walls = "".join(_polygon(piece) for wall in floor.wall for piece in wall_pieces(wall))
    # A thin wall could vanish between two pixels.
    line = f'stroke="var(--iw-wall)" stroke-width="{_n(view.pixel * 0.8)}" stroke-linejoin="round"'
    return (
        f'<div class="iw-plan" data-testid="plan-floor"><svg viewBox="{view.box}">'
        f'<rect x="{_n(view.west)}" y="{_n(-view.north)}" width="{_n(view.across)}" height="{_n(view.down)}" '
        f'rx="{_n(view.pixel * 4)}" fill="var(--iw-floor)"/><g fill="var(--iw-ink)" fill-opacity=".05">{zones}</g>'
        f'<g fill="var(--iw-thing)">{things}</g><g fill="var(--iw-wall)" {line}>{walls}</g></svg>{_scale(view)}</div>'
    )


def bodies_svg(snapshot: Snapshot, choices: Choices, handler: str = "") -> str:
    """Return the drawing of all bodies with their trails, and a ring around the selected one.

    With more than `CROWD` bodies only the selected one is drawn in full; the others are outlines.
    """
    if snapshot.floor is None:
        return ""
    view = frame(snapshot.floor)
    known = {name: Mark(*look) for name, look in choices.looks.items()}
    # The selected one is drawn last, above the others.
    order = sorted(snapshot.entities, key=lambda entity: (entity.name == choices.selected, entity.name in known))
    crowd = order if len(order) > CROWD else []
    drawn = [entity for entity in order if not crowd or entity.name == choices.selected]
    trails = (
        _trail(snapshot.history.get(one.name, ()), snapshot.time, known[one.name], view)
        for one in drawn
        if one.name in known
    )
    bodies = (_body(snapshot, entity, known.get(entity.name), view, choices.selected) for entity in drawn)
    return (
        f'<div class="iw-plan over" data-testid="plan" {handler}><svg viewBox="{view.box}">'
        f"{_crowd(snapshot, crowd, known)}{''.join(trails)}{''.join(bodies)}</svg></div>"
    )


def _crowd(snapshot: Snapshot, entities: Sequence[Entity], known: Mapping[str, Mark]) -> str:
    """Return one path for each colour, so a thousand bodies take tens of kilobytes instead of hundreds."""
    paths: dict[str, list[str]] = {}
    for entity in entities:
        body = snapshot.bodies.get(entity.name)
        if body is not None:
            fill = known[entity.name].css if entity.name in known else "var(--iw-thing)"
            corners = outline(footprint(body.robot), entity.x, entity.y, entity.heading)
            paths.setdefault(fill, []).append(f"M{_points(corners)}z")
    return "".join(f'<path d="{"".join(parts)}" fill="{fill}"/>' for fill, parts in paths.items())


def _body(snapshot: Snapshot, entity: Entity, mark: Mark | None, view: Frame, selected: str | None) -> str:
    body = snapshot.bodies.get(entity.name)
    if body is None:
        return ""
    shape = footprint(body.robot)
    corners = outline(shape, entity.x, entity.y, entity.heading)
    touching = entity.contact or entity.collision
    edge = "var(--iw-red)" if touching else "var(--iw-ink)"
    width = view.pixel * (2.2 if touching else 0.8)
    fill = mark.css if mark else "var(--iw-thing)"
    drawn = (
        f'<polygon points="{_points(corners)}" fill="{fill}" stroke="{edge}" stroke-width="{_n(width)}" '
        f'stroke-linejoin="round"/>'
    )
    if mark is not None and body.robot.top_speed > 0:
        tip = shape.front - 0.12 * (shape.front - shape.rear)
        back, side = tip - 0.4 * (shape.front - shape.rear), 0.3 * (shape.left - shape.right)
        arrow = placed(((tip, 0.0), (back, side), (back, -side)), entity.x, entity.y, entity.heading)
        drawn += f'<polygon points="{_points(arrow)}" fill="{mark.ink}"/>'
    if entity.name == selected:
        drawn = _ring(entity, max(0.9, 9 * view.pixel), view) + drawn
    name, faded = html.escape(entity.name), ' opacity=".4"' if entity.state == "stale" else ""
    words = f"{name}: {driver_of(entity, body, snapshot.measures.get(entity.name))}"
    return f'<g data-agent="{name}"{faded} style="pointer-events:all"><title>{words}</title>{drawn}</g>'


def _ring(entity: Entity, radius: float, view: Frame) -> str:
    # A dark edge around the yellow ring, visible on a light and on a dark background.
    at = f'cx="{_n(entity.x)}" cy="{_n(-entity.y)}" r="{_n(radius)}" fill="none"'
    return (
        f'<circle {at} stroke="#4a4200" stroke-width="{_n(view.pixel * 4)}"/>'
        f'<circle {at} class="iw-ring" stroke="#f5e400" stroke-width="{_n(view.pixel * 2.6)}"/>'
    )


def _trail(samples: Sequence[Sample], now: float, mark: Mark, view: Frame) -> str:
    points = []
    # Times are multiples of the step, so that a corner of the line does not move while it grows.
    beat = math.floor(max(now - TRAIL, samples[0].time) / _TRAIL_STEP) + 1 if samples else 0
    while samples and beat * _TRAIL_STEP <= samples[-1].time:
        sample = samples[bisect_left(samples, beat * _TRAIL_STEP, key=lambda one: one.time)]
        points.append((sample.x, sample.y))
        beat += 1
    if points:
        points.append((samples[-1].x, samples[-1].y))
    if len(points) < 2:
        return ""
    line = f'<polyline points="{_points(points)}" fill="none" stroke-linecap="round" stroke-linejoin="round" '
    # A thin edge in the text colour keeps black visible on dark and white on light.
    return (
        f'{line}stroke="var(--iw-ink)" stroke-opacity=".3" stroke-width="{_n(view.pixel * 2.6)}"/>'
        f'{line}stroke="{mark.css}" stroke-width="{_n(view.pixel * 1.6)}"/>'
    )


def _scale(view: Frame) -> str:
    length = max((bar for bar in _BARS if bar <= view.across / 4), default=_BARS[0])
    return (
        f'<div class="iw-caption" style="display:flex;align-items:end;gap:6px;padding:3px 0 6px">'
        f'<div class="iw-bar" style="width:{length / view.across:.2%};margin-bottom:5px"></div>{length:g} m</div>'
    )


def _polygon(points: Sequence[Point]) -> str:
    return f'<polygon points="{_points(points)}"/>'


def _points(points: Iterable[Point]) -> str:
    return " ".join(f"{_n(x)},{_n(-y)}" for x, y in points)


def _n(value: float) -> str:
    """Return a length in metres with two decimals, less than a pixel of any plan."""
    return f"{value:.2f}".rstrip("0").rstrip(".")


class PlanPanel:
    """The plan. A click on a body selects it.

    Args:
        gui: Makes the elements, in the open container.
        on_select: Called with the name of a body in the run.
    """

    def __init__(self, gui: viser.GuiApi, on_select: Callable[[str], None]) -> None:
        gui.add_html(STYLE_SHEET)
        self._bodies = gui.add_html("")
        self._floor = gui.add_html("")
        self._drawn: Map | None = None
        self._known: frozenset[str] = frozenset()
        self._on_select = on_select
        self._pick = Pick(gui, self._picked)

    def show(self, snapshot: Snapshot, choices: Choices, *, visible: bool = True) -> None:
        """Show the bodies of a snapshot; nothing without a map."""
        visible = visible and snapshot.floor is not None
        self._bodies.visible = self._floor.visible = visible
        if not visible or snapshot.floor is None:
            return
        self._known = frozenset(entity.name for entity in snapshot.entities)
        self._bodies.content = bodies_svg(snapshot, choices, self._pick.attribute)
        if snapshot.floor is not self._drawn:
            self._floor.content, self._drawn = floor_svg(snapshot.floor), snapshot.floor

    def _picked(self, name: str) -> None:
        if name in self._known:
            self._on_select(name)
