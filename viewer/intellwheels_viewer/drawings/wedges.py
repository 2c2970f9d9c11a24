"""What the distance sensors see: a fan as far as the reading, with a solid arc where the reading is.

Five states that differ in shape as well as in hue: near, middle and far have an arc, "nothing seen" is a pale fan
without one, "failed" a dashed outline without a fan. A sensor that is mounted on `start` stands where its body joined.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
import viser

from intellwheels_schemas.messages import Body, Entity, Lidar, Measures, Proximity, ProximityReading
from intellwheels_viewer import palette
from intellwheels_viewer.drawings import layers
from intellwheels_viewer.drawings.batch import Batch, quaternions
from intellwheels_viewer.drawings.solids import Array, Solid, band, sheet

Rows: TypeAlias = npt.NDArray[np.float64]
State: TypeAlias = Literal["near", "middle", "far", "nothing", "failed"]

NEAR: Final = 0.5
"""Below so many metres a reading is near: a chair at 1 m/s has half a second."""
MIDDLE: Final = 1.5
"""Below so many metres it is in the middle."""
ARC: Final = 0.03
"""Thickness of the arc, in metres."""

COLOURS: Final[Mapping[State, palette.RGB]] = {
    "near": palette.NEAR,
    "middle": palette.MIDDLE,
    "far": palette.FAR,
    "nothing": palette.NOTHING,
    "failed": palette.FAILED,
}
OPACITIES: Final[Mapping[State, float]] = {"near": 0.42, "middle": 0.38, "far": 0.36, "nothing": 0.30, "failed": 0.0}
_WORDS: Final[Mapping[State, str]] = {
    "near": f"near, under {NEAR:g} m",
    "middle": f"middle, under {MIDDLE:g} m",
    "far": "far",
    "nothing": "nothing seen",
    "failed": "sensor failed",
}
_PIECE: Final = math.radians(10.0)
# Transparent fans at one height flicker; so many heights are told apart.
_LIFTS: Final = 64
_LIFT: Final = 0.0002


class Wedge(NamedTuple):
    """One sensor's reading on the floor.

    Attributes:
        x, y: Where the sensor is, in metres.
        direction: Of the middle of its cone, in radians.
        cone: The full angle, in radians.
        reach: As far as it is drawn, in metres.
        state: Which of the five.
    """

    x: float
    y: float
    direction: float
    cone: float
    reach: float
    state: State


def state_of(reading: ProximityReading) -> State:
    """Return which of the five a reading is; what is nearer than the sensor can measure is near."""
    if reading.status == "fault":
        return "failed"
    if reading.status == "near":
        return "near"
    if reading.status == "none" or reading.value is None:
        return "nothing"
    if reading.value < NEAR:
        return "near"
    return "middle" if reading.value < MIDDLE else "far"


def mounted(sensor: Proximity | Lidar, body: Body, entity: Entity) -> tuple[float, float, float]:
    """Return where a sensor is and its direction, in the world: from its body's pose, or from where that joined."""
    start = body.robot.position
    frame = start if sensor.mount == "start" and start is not None else entity
    cos, sin = math.cos(frame.heading), math.sin(frame.heading)
    return (
        frame.x + sensor.x * cos - sensor.y * sin,
        frame.y + sensor.x * sin + sensor.y * cos,
        frame.heading + math.radians(sensor.direction_deg),
    )


def wedge(sensor: Proximity, reading: ProximityReading, body: Body, entity: Entity) -> Wedge:
    """Return what is drawn of a reading."""
    return _wedge(sensor, reading, *mounted(sensor, body, entity))


def _wedge(sensor: Proximity, reading: ProximityReading, x: float, y: float, direction: float) -> Wedge:
    state = state_of(reading)
    if state in ("nothing", "failed"):
        reach = sensor.max_range
    else:
        reach = sensor.min_range if reading.value is None else reading.value
    return Wedge(x, y, direction, math.radians(sensor.cone_deg), max(reach, ARC), state)


def wedges(
    bodies: Mapping[str, Body], entities: Iterable[Entity], measures: Mapping[str, Measures], agents: Collection[str]
) -> list[Wedge]:
    """Return the wedges of some agents, in the order of the state; sensors without a reading have none."""
    made = []
    for entity in entities:
        body, seen = bodies.get(entity.name), measures.get(entity.name)
        if entity.name not in agents or body is None or seen is None or seen.sensors is None:
            continue
        readings = {reading.id: reading for reading in seen.sensors.proximity}
        cos, sin = math.cos(entity.heading), math.sin(entity.heading)  # once for all sensors of a body
        for sensor in body.robot.proximity:
            reading = readings.get(sensor.id)
            if reading is None:
                continue
            if sensor.mount == "start":
                made.append(wedge(sensor, reading, body, entity))
                continue
            x = entity.x + sensor.x * cos - sensor.y * sin
            y = entity.y + sensor.x * sin + sensor.y * cos
            made.append(_wedge(sensor, reading, x, y, entity.heading + math.radians(sensor.direction_deg)))
    return made


def fan(cone: float) -> Solid:
    """Return a flat fan of radius 1 around x, `cone` radians wide."""
    return band(0.0, 1.0, layers.WEDGE, -cone / 2, cone / 2, max(2, math.ceil(cone / (_PIECE / 2))))


@dataclass(frozen=True)
class Bars:
    """N flat bars: middles (N, 3), headings (N,), sizes (N, 3) along and across, colours (N, 3) sRGB bytes."""

    positions: Array
    headings: Array
    sizes: Array
    colours: Array


def bars(shown: Sequence[Wedge]) -> Bars:
    """Return the arcs of what was seen, `ARC` thick with the reading at their outer edge, and the dashes of failures.

    An arc is a bar for each ten degrees: at 4 m a bar's middle is 1.5 cm nearer than its ends.
    """
    rows: list[Rows] = [np.zeros((0, 8))]
    arcs: dict[int, list[Wedge]] = {}
    for each in shown:
        if each.state == "failed":
            rows.append(_dashes(each))
        elif each.state != "nothing":
            arcs.setdefault(max(1, math.ceil(each.cone / _PIECE - 1e-9)), []).append(each)
    rows += [_arcs(group, pieces) for pieces, group in arcs.items()]
    table = np.concatenate(rows)
    flat = np.zeros((len(table), 3), np.float32)
    flat[:, :2], flat[:, 2] = table[:, :2], layers.ARC
    sizes = np.ones((len(table), 3), np.float32)
    sizes[:, :2] = table[:, 3:5]
    return Bars(flat, table[:, 2].astype(np.float32), sizes, table[:, 5:].astype(np.float32))


def _arcs(group: Sequence[Wedge], pieces: int) -> Rows:
    """Return the bars (N x pieces, 8) of arcs: x, y, heading, length, width, colour."""
    x, y, direction, cone, reach = (
        column[:, None] for column in np.array([(w.x, w.y, w.direction, w.cone, w.reach) for w in group]).T
    )
    turn = cone / pieces
    angle = direction - cone / 2 + turn * (np.arange(pieces) + 0.5)
    middle = reach - ARC / 2
    rows = np.empty((*angle.shape, 8))
    rows[..., 0], rows[..., 1] = x + middle * np.cos(angle), y + middle * np.sin(angle)
    rows[..., 2] = angle + math.pi / 2
    rows[..., 3], rows[..., 4] = 2 * reach * np.tan(turn / 2), ARC
    rows[..., 5:] = np.array([COLOURS[w.state] for w in group], np.float64)[:, None, :]
    return rows.reshape(-1, 8)


def _dashes(each: Wedge) -> Rows:
    """Return a dashed outline: dashes of 12 cm and gaps of 8 along both sides and the arc."""
    rows: list[tuple[float, ...]] = []
    for side in (-each.cone / 2, each.cone / 2):
        angle = each.direction + side
        for dash in range(1, math.floor(each.reach / 0.2)):
            at = 0.2 * dash + 0.06
            rows.append((each.x + at * math.cos(angle), each.y + at * math.sin(angle), angle, 0.12))
    count = max(2, math.ceil(each.reach * each.cone / 0.2))
    for dash in range(count):
        angle = each.direction - each.cone / 2 + each.cone * (dash + 0.5) / count
        x, y = each.x + each.reach * math.cos(angle), each.y + each.reach * math.sin(angle)
        rows.append((x, y, angle + math.pi / 2, 0.6 * each.reach * each.cone / count))
    return np.array([(*row, 0.02, *COLOURS["failed"]) for row in rows])


def legend() -> str:
    """Return the five states as HTML for a panel: a drawing and words for each, the near one first."""
    rows = "".join(
        f'<tr data-state="{state}"><td style="width:46px;padding:1px 8px 1px 0">{_icon(state)}</td>'
        f'<td style="padding:1px 0">{words}</td></tr>'
        for state, words in _WORDS.items()
    )
    return f'<table style="border-collapse:collapse;font-size:13px;line-height:1.4">{rows}</table>'


def _icon(state: State) -> str:
    colour = palette.hexadecimal(COLOURS[state])
    reach = {"near": 16.0, "middle": 26.0}.get(state, 38.0)
    x, y = 2 + reach * math.cos(math.radians(17)), reach * math.sin(math.radians(17))
    path = f"M2 11 L{x:.1f} {11 - y:.1f} A{reach:g} {reach:g} 0 0 1 {x:.1f} {11 + y:.1f} Z"
    if state == "failed":
        shape = f'<path d="{path}" fill="none" stroke="currentColor" stroke-width="1.5" stroke-dasharray="4 3"/>'
    else:
        shape = f'<path d="{path}" fill="{colour}" fill-opacity="0.45"/>'
        if state != "nothing":
            arc = f"M{x:.1f} {11 - y:.1f} A{reach:g} {reach:g} 0 0 1 {x:.1f} {11 + y:.1f}"
            shape += f'<path d="{arc}" fill="none" stroke="{colour}" stroke-width="3"/>'
    return f'<svg width="44" height="22" viewBox="0 0 44 22" style="display:block">{shape}</svg>'


class Wedges:
    """The wedges in a scene: a batch of fans for each cone angle, and one of all bars."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._fans: dict[float, Batch] = {}
        self._visible = True
        square = sheet([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)], 0.0)
        self._bars = Batch(scene, "/wedges/bars", square)

    def show(
        self,
        bodies: Mapping[str, Body],
        entities: Iterable[Entity],
        measures: Mapping[str, Measures],
        agents: Collection[str],
        arcs: Collection[str] | None = None,
    ) -> None:
        """Show the wedges of some agents.

        Args:
            bodies: Documents by agent.
            entities: States.
            measures: By agent; those of agents whose measures nobody watches are not there.
            agents: Whose wedges are shown; a wedge is 35 bytes a tick and its arc 43 for each ten degrees.
            arcs: Of those, whose readings have arcs; None for all. Failures are dashed for everybody.
        """
        shown = wedges(bodies, entities, measures, agents)
        groups: dict[float, list[Wedge]] = {cone: [] for cone in self._fans}
        for each in shown:
            if each.state != "failed":
                groups.setdefault(round(each.cone, 4), []).append(each)
        for cone, group in groups.items():
            self._fan(cone, group)
        if arcs is None:
            lines = bars(shown)
        else:
            edged = wedges(bodies, [entity for entity in entities if entity.name in arcs], measures, agents)
            lines = bars(
                [*(each for each in shown if each.state == "failed"), *(e for e in edged if e.state != "failed")]
            )
        self._bars.show(lines.positions, quaternions(lines.headings), lines.colours, scales=lines.sizes)

    def _fan(self, cone: float, group: Sequence[Wedge]) -> None:
        if cone not in self._fans:
            name = f"/wedges/fan-{math.degrees(cone):.4g}".replace(".", "-")
            self._fans[cone] = Batch(self._scene, name, fan(cone), opacity=1.0, side="double")
        lifts = [_LIFT * (index % _LIFTS) for index in range(len(group))]
        self._fans[cone].show(
            [(each.x, each.y, lift) for each, lift in zip(group, lifts, strict=True)],
            quaternions([each.direction for each in group]),
            [COLOURS[each.state] for each in group],
            scales=[(each.reach, each.reach, 1.0) for each in group],
            opacities=[OPACITIES[each.state] for each in group],
        )
