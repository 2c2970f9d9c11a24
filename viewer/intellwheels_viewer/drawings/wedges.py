"""Readings of proximity sensors: a fan up to the measured range, with a solid arc at its end.

The five states differ in shape as well as in colour: near, middle and far have an arc, "nothing seen" is a pale fan
without one, and "failed" is a dashed outline without a fan. Sensors mounted on `start` stay where the body joined.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, get_args

import numpy as np
import numpy.typing as npt
import viser

from intellwheels_schemas.agent_colours import css
from intellwheels_schemas.messages import (
    Body,
    Entity,
    Lidar,
    Measures,
    Position,
    Proximity,
    ProximityReading,
    Status,
)
from intellwheels_viewer import palette
from intellwheels_viewer.drawings import floor_heights
from intellwheels_viewer.drawings.instance_batch import InstanceBatch, quaternions
from intellwheels_viewer.drawings.solids import Array, Solid, band, sheet
from intellwheels_viewer.range_bands import MIDDLE, NEAR

Rows: TypeAlias = npt.NDArray[np.float64]
Column: TypeAlias = npt.NDArray[np.float64]
Indices: TypeAlias = npt.NDArray[np.int8]
Flags: TypeAlias = npt.NDArray[np.bool_]
State: TypeAlias = Literal["near", "middle", "far", "nothing", "failed"]

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
STATES: Final[tuple[State, ...]] = get_args(State)
"""In this order: the states before `nothing` have a range, and `failed` is the last."""
_NOTHING, _FAILED = STATES.index("nothing"), STATES.index("failed")
_GIVEN: Final[Mapping[Status, int]] = {"ok": -1, "near": 0, "none": _NOTHING, "fault": _FAILED}
_TINTS: Final[Rows] = np.array([COLOURS[state] for state in STATES], np.float64)
_SHARES: Final[Column] = np.array([OPACITIES[state] for state in STATES], np.float64)
_PIECE: Final = math.radians(10.0)
# Transparent fans at the same height flicker, so fans use this many heights in turn.
_LIFTS: Final = 64
_LIFT: Final = 0.0002


@dataclass(frozen=True, slots=True)
class Cones:
    """The readings of N sensors on the floor, in the order of the state.

    Attributes:
        x, y: (N,) Position of each sensor, in metres.
        direction: (N,) Direction of the middle of its field of view, in radians.
        cone: (N,) Full field of view, in radians.
        reach: (N,) Drawn range, in metres.
        state: (N,) Index in `STATES`.
        edged: (N,) Whether it has an arc.
    """

    x: Column
    y: Column
    direction: Column
    cone: Column
    reach: Column
    state: Indices
    edged: Flags

    def where(self, chosen: Flags) -> Cones:
        """Return the sensors for which `chosen` is true."""
        return Cones(*(getattr(self, field)[chosen] for field in self.__slots__))


def mount_frame(sensor: Proximity | Lidar, body: Body, entity: Entity | None) -> Entity | Position | None:
    """Return the pose of what a sensor is mounted on; None if it is unknown, so the sensor cannot be drawn.

    A sensor with `Mount="start"` stays at the pose where its body joined, which is the `Position` of the body's
    document.
    """
    return body.robot.position if sensor.mount == "start" else entity


def mounted(sensor: Proximity | Lidar, frame: Entity | Position) -> tuple[float, float, float]:
    """Return the position of a sensor and its direction in the world frame, from the pose of what it is mounted on."""
    cos, sin = math.cos(frame.heading), math.sin(frame.heading)
    return (
        frame.x + sensor.x * cos - sensor.y * sin,
        frame.y + sensor.x * sin + sensor.y * cos,
        frame.heading + math.radians(sensor.direction_deg),
    )


class Mounts:
    """The mounts of the sensors of all bodies, computed once per document."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[Body, list[str], Rows]] = {}

    def of(self, name: str, body: Body) -> tuple[list[str], Rows]:
        """Return a body's distance sensors: their names, and a table (N, 7).

        Its columns: x, y, direction, cone, least and greatest range, and 1 if the position is in the world frame and
        not in the body frame.
        """
        known = self._known.get(name)
        if known is None or known[0] is not body:
            start = body.robot.position
            sensors = [one for one in body.robot.proximity if one.mount != "start" or start is not None]
            known = (body, [sensor.id for sensor in sensors], _mounts(sensors, body))
            self._known[name] = known
        return known[1], known[2]

    def keep(self, names: Collection[str]) -> None:
        """Forget all other bodies."""
        for name in self._known.keys() - set(names):
            del self._known[name]


def _mounts(sensors: Sequence[Proximity], body: Body) -> Rows:
    start = body.robot.position
    rows = np.zeros((len(sensors), 7))
    for row, sensor in zip(rows, sensors, strict=True):
        row[:] = (
            sensor.x,
            sensor.y,
            math.radians(sensor.direction_deg),
            math.radians(sensor.cone_deg),
            sensor.min_range,
            sensor.max_range,
            0.0,
        )
        if sensor.mount == "start" and start is not None:
            row[:3], row[6] = mounted(sensor, start), 1.0
    return rows


def cones(
    bodies: Mapping[str, Body],
    entities: Iterable[Entity],
    measures: Mapping[str, Measures],
    agents: Collection[str],
    arcs: Collection[str] | None = None,
    mounts: Mounts | None = None,
) -> Cones:
    """Return the readings of some agents' sensors, in the order of the state. Sensors without a reading are left out.

    Args:
        bodies: Documents by agent.
        entities: States.
        measures: Measures by agent.
        agents: The agents.
        arcs: The agents whose readings have arcs; None for all.
        mounts: Cached mounts; None to compute them.
    """
    mounts = Mounts() if mounts is None else mounts
    tables: list[Rows] = [np.zeros((0, 7))]
    poses: list[tuple[float, float, float, bool, int]] = []
    found: list[ProximityReading] = []
    for entity in entities:
        name = entity.name
        body, measured = bodies.get(name), measures.get(name)
        if name not in agents or body is None or measured is None or measured.sensors is None:
            continue
        names, table = mounts.of(name, body)
        readings: Sequence[ProximityReading] = measured.sensors.proximity
        if [reading.id for reading in readings] != names:
            by_id = {reading.id: reading for reading in readings}
            table = table[[each in by_id for each in names]]
            readings = [by_id[each] for each in names if each in by_id]
        tables.append(table)
        found.extend(readings)
        poses.append((entity.x, entity.y, entity.heading, arcs is None or name in arcs, len(table)))
    return _placed(np.concatenate(tables), np.array(poses).reshape(-1, 5), found)


def _placed(table: Rows, poses: Rows, readings: Sequence[ProximityReading]) -> Cones:
    x, y, heading, edged = np.repeat(poses[:, :4], poses[:, 4].astype(np.intp), axis=0).T
    side, fore, turn, cone, least, most, fixed = table.T[[1, 0, 2, 3, 4, 5, 6]]
    cos, sin = np.cos(heading), np.sin(heading)
    is_fixed = fixed > 0.0
    value = np.array([reading.value for reading in readings], np.float64)  # None becomes nan
    state = _states(value, [reading.status for reading in readings])
    reach = np.where(state >= _NOTHING, most, np.where(np.isnan(value), least, value))
    return Cones(
        np.where(is_fixed, fore, x + fore * cos - side * sin),
        np.where(is_fixed, side, y + fore * sin + side * cos),
        np.where(is_fixed, turn, heading + turn),
        cone,
        np.maximum(reach, ARC),
        state,
        edged > 0.0,
    )


def _states(value: Column, status: Sequence[Status]) -> Indices:
    """Return the index of each reading's state. An object nearer than the minimum range is near."""
    given = np.array([_GIVEN[each] for each in status], np.int8)
    measured = np.where(np.isnan(value), _NOTHING, np.digitize(value, (NEAR, MIDDLE)))
    return np.where(given >= 0, given, measured).astype(np.int8)


def fan(cone: float) -> Solid:
    """Return a flat fan of radius 1 around x, `cone` radians wide."""
    return band(0.0, 1.0, floor_heights.WEDGE, -cone / 2, cone / 2, max(2, math.ceil(cone / (_PIECE / 2))))


@dataclass(frozen=True)
class Bars:
    """N flat bars: middles (N, 3), headings (N,), sizes (N, 3) along and across, colours (N, 3) sRGB bytes."""

    positions: Array
    headings: Array
    sizes: Array
    colours: Array


def bars(shown: Cones) -> Bars:
    """Return the arcs of all readings, with the range at their outer edge, and the dashes of failed sensors.

    An arc has a bar for each ten degrees: at 4 m the middle of a bar is 1.5 cm nearer than its ends.
    """
    rows: list[Rows] = [np.zeros((0, 8))]
    failed = shown.where(shown.state == _FAILED)
    rows += [
        _dashes(*each) for each in zip(failed.x, failed.y, failed.direction, failed.cone, failed.reach, strict=True)
    ]
    edged = shown.where((shown.state < _NOTHING) & shown.edged)
    pieces = np.maximum(1, np.ceil(edged.cone / _PIECE - 1e-9)).astype(np.intp)
    rows += [_arcs(edged.where(pieces == count), count) for count in sorted({*pieces.tolist()})]
    table = np.concatenate(rows)
    flat = np.zeros((len(table), 3), np.float32)
    flat[:, :2], flat[:, 2] = table[:, :2], floor_heights.ARC
    sizes = np.ones((len(table), 3), np.float32)
    sizes[:, :2] = table[:, 3:5]
    return Bars(flat, table[:, 2].astype(np.float32), sizes, table[:, 5:].astype(np.float32))


def _arcs(group: Cones, pieces: int) -> Rows:
    """Return the bars (N x pieces, 8) of arcs: x, y, heading, length, width, colour."""
    turn = group.cone[:, None] / pieces
    reach = group.reach[:, None]
    angle = group.direction[:, None] - group.cone[:, None] / 2 + turn * (np.arange(pieces) + 0.5)
    middle = reach - ARC / 2
    rows = np.empty((*angle.shape, 8))
    rows[..., 0] = group.x[:, None] + middle * np.cos(angle)
    rows[..., 1] = group.y[:, None] + middle * np.sin(angle)
    rows[..., 2] = angle + math.pi / 2
    rows[..., 3], rows[..., 4] = 2 * reach * np.tan(turn / 2), ARC
    rows[..., 5:] = _TINTS[group.state][:, None, :]
    return rows.reshape(-1, 8)


def _dashes(x: float, y: float, direction: float, cone: float, reach: float) -> Rows:
    """Return a dashed outline: dashes of 12 cm with gaps of 8 cm along both sides and the arc."""
    rows: list[tuple[float, ...]] = []
    for side in (-cone / 2, cone / 2):
        angle = direction + side
        for dash in range(1, math.floor(reach / 0.2)):
            at = 0.2 * dash + 0.06
            rows.append((x + at * math.cos(angle), y + at * math.sin(angle), angle, 0.12))
    count = max(2, math.ceil(reach * cone / 0.2))
    for dash in range(count):
        angle = direction - cone / 2 + cone * (dash + 0.5) / count
        at_x, at_y = x + reach * math.cos(angle), y + reach * math.sin(angle)
        rows.append((at_x, at_y, angle + math.pi / 2, 0.6 * reach * cone / count))
    return np.array([(*row, 0.02, *COLOURS["failed"]) for row in rows])


def legend() -> str:
    """Return a legend of the five states as HTML: a symbol and a description for each."""
    rows = "".join(
        f'<tr data-state="{state}"><td style="width:46px;padding:1px 8px 1px 0;border:0;text-align:left">'
        f"{_icon(state)}</td>"
        f'<td style="padding:1px 0;border:0;text-align:left">{words}</td></tr>'
        for state, words in _WORDS.items()
    )
    return f'<table style="border-collapse:collapse;font-size:13px;line-height:1.4">{rows}</table>'


def _icon(state: State) -> str:
    colour = css(COLOURS[state])
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
    """The wedges in a scene: a batch of fans for each cone angle, and one of all bars.

    Args:
        scene: The scene of a browser, or that of all.
        name: The node above the wedges.
    """

    def __init__(self, scene: viser.SceneApi, name: str = "/wedges") -> None:
        self._scene, self._name = scene, name
        self._fans: dict[float, InstanceBatch] = {}
        self._mounts = Mounts()
        square = sheet([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)], 0.0)
        self._bars = InstanceBatch(scene, f"{name}/bars", square)

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
            measures: Measures by agent, for subscribed agents.
            agents: The agents whose wedges are shown. A wedge takes 35 bytes a tick, its arc 43 for each ten degrees.
            arcs: The agents whose readings have arcs; None for all. Failed sensors always have a dashed outline.
        """
        self._mounts.keep(bodies)
        shown = cones(bodies, entities, measures, agents, arcs, self._mounts)
        drawn = shown.where(shown.state != _FAILED)
        angles = np.round(np.degrees(drawn.cone), 3)
        for cone in sorted({*self._fans, *angles.tolist()}):
            self._fan(cone, drawn.where(angles == cone))
        lines = bars(shown)
        self._bars.show(lines.positions, quaternions(lines.headings), lines.colours, scales=lines.sizes)

    def _fan(self, cone: float, group: Cones) -> None:
        if cone not in self._fans:
            name = f"{self._name}/fan-{cone:.6g}".replace(".", "-")
            self._fans[cone] = InstanceBatch(self._scene, name, fan(math.radians(cone)), opacity=1.0, side="double")
        lifts = _LIFT * (np.arange(len(group.x)) % _LIFTS)
        self._fans[cone].show(
            np.column_stack([group.x, group.y, lifts]),
            quaternions(group.direction),
            _TINTS[group.state],
            scales=np.column_stack([group.reach, group.reach, np.ones(len(group.x))]),
            opacities=_SHARES[group.state],
        )
