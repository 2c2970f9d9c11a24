"""Measures a run: a trace in, numbers and time series out. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import msgspec
import numpy as np

from intellwheels_experiments.batch import metrics
from intellwheels_experiments.batch.clearance import clearance, half_width, shortest_path
from intellwheels_experiments.batch.metrics import Floats
from intellwheels_experiments.batch.trace_reader import Trace, commanded, reported
from intellwheels_schemas.file_records import TraceBody
from intellwheels_schemas.messages import Event, Map, Robot, Scene

MANUAL: Final = "manual"
"""The mode of a mind that plays the user itself: its powers are the user's command."""


class RunMeasures(msgspec.Struct, frozen=True, kw_only=True):
    """The measures of a run; None where a measure does not apply. A contact that lasts counts once.

    Attributes:
        success: Whether it reached its place and touched nothing.
        reached: Whether it was at its place at the end.
        collided: Whether it touched something at its true pose or, for a chair in a laboratory, a body that exists in
            the simulation only.
        contacts_physical: Number of contacts with real things.
        contacts_virtual: Number of contacts with simulated things.
        clearance: Smallest distance from anything, in m.
        time: Simulated time to the end, in s.
        path: Length of the true path, in m.
        shortest: Length of the shortest path, in m.
        spl: Success weighted by path length, in [0, 1].
        ldlj: Log dimensionless jerk of the speed while it moved.
        sparc: Spectral arc length of the speed while it moved.
        effort: Length of the joystick's path, in full deflections.
        agreement: Agreement of the motion with the user's command, in [0, 1].
        interventions: How often it began to deviate from the user's command, or was taken from its mind.
        odometry_error: Distance between the reported and the true position at the end, in m.
        heading_error: Absolute difference between the reported and the true heading at the end, in rad.
        hash: The hash of the last state.
    """

    success: bool
    reached: bool
    collided: bool
    contacts_physical: int
    contacts_virtual: int
    clearance: float | None
    time: float
    path: float
    shortest: float | None
    spl: float | None
    ldlj: float | None
    sparc: float | None
    effort: float | None
    agreement: float | None
    interventions: int
    odometry_error: float | None
    heading_error: float | None
    hash: str


@dataclass(frozen=True)
class RunSeries:
    """A run over time: arrays with one entry per tick. A pose is x and y in m and the heading in rad.

    Attributes:
        times: Simulated times, float64[n], in s.
        true: True poses, float64[n, 3].
        reported: The poses that odometry or the bridge reported, float64[n, 3]; None without either.
        commanded: The poses that would follow from the motor powers alone, float64[n, 3].
        clearance: Distance from the nearest thing, float64[n], in m.
        speed: float64[n], in m/s.
        contacts: The contact events.
        robot: The body as it joined.
        others: The poses of the other bodies that moved, by name: float64[n, 3].
    """

    times: Floats
    true: Floats
    reported: Floats | None
    commanded: Floats
    clearance: Floats
    speed: Floats
    contacts: tuple[Event, ...]
    robot: Robot
    others: dict[str, Floats]


def measure_run(
    trace: Trace, scene: Scene, floor: Map, subject: str, *, real: bool, mirror: Trace | None = None
) -> tuple[RunMeasures, RunSeries]:
    """Return the measures of a run and its time series.

    Args:
        trace: The trace of the world in which the chair truly was.
        scene: The scene.
        floor: Its map.
        subject: The agent that is measured.
        real: Whether the things that it touches in that world count as real.
        mirror: For a chair in a laboratory, the trace of the world that mirrored it at its reported poses.
    """
    states, robot = trace.shown(subject), trace.robots[subject]
    series = _series(trace, floor, subject, states, robot, mirror)
    x, y, _ = series.true.T
    reach = next((one for one in scene.end.reach if one.agent == subject), None) if scene.end else None
    place = (
        next((one for one in floor.grid.position if reach and one.name == reach.place), None) if floor.grid else None
    )
    reached, shortest = True, math.nan
    if reach is not None and place is not None:
        reached = math.hypot(x[-1] - place.x, y[-1] - place.y) <= reach.within + 1e-9
        start = float(x[0]), float(y[0])
        shortest = max(0.0, shortest_path(floor, start, (place.x, place.y), half_width(robot)) - reach.within)
    contacts, length = len(series.contacts), metrics.path_length(x, y)
    mirrored = _mirrored_contacts(series, mirror, subject)
    # The mirror adds the contacts with simulated bodies. Its walls are in the laboratory too.
    touched = contacts + sum(contact.other != "wall" for contact in mirrored)
    success = reached and touched == 0
    turn_rate = np.array([state.turn_rate for state in states])
    movement = series.speed[metrics.moving(series.speed, turn_rate)]
    wanted, done = _command_and_motion(states)
    taken = sum(event.code == "taken" and event.agent == subject for event in trace.events)
    # The mirror may not have had the time to show the last tick.
    last = -1 if mirror is None else -2
    error = series.reported[last] - series.true[last] if series.reported is not None else np.full(3, math.nan)
    return (
        RunMeasures(
            success=success,
            reached=reached,
            collided=touched > 0,
            contacts_physical=contacts if real else 0,
            contacts_virtual=len(mirrored) if real else contacts,
            clearance=_finite(float(series.clearance.min())),
            time=float(series.times[-1]),
            path=length,
            shortest=_finite(shortest),
            spl=_finite(metrics.success_weighted_by_path_length(success, shortest, length)),
            ldlj=_finite(metrics.log_dimensionless_jerk(movement, trace.heading.period)),
            sparc=_finite(metrics.spectral_arc_length(movement, trace.heading.period)),
            effort=metrics.user_effort(*wanted.T) if wanted is not None else None,
            agreement=_finite(metrics.agreement(wanted, done)) if wanted is not None else None,
            interventions=taken + (metrics.interventions(wanted, done) if wanted is not None else 0),
            odometry_error=_finite(float(np.hypot(error[0], error[1]))),
            heading_error=abs(math.remainder(float(error[2]), math.tau)) if math.isfinite(error[2]) else None,
            hash=trace.moments[-1].hash,
        ),
        series,
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _series(
    trace: Trace, floor: Map, subject: str, states: list[TraceBody], robot: Robot, mirror: Trace | None
) -> RunSeries:
    true = trace.poses(subject)
    others = {name: (other, trace.poses(name)) for name, other in trace.robots.items() if name != subject}
    return RunSeries(
        times=trace.times,
        true=true,
        reported=reported(states, robot) if mirror is None else _mirrored_poses(mirror, subject, len(states)),
        commanded=commanded(states, robot, trace.heading.period),
        clearance=clearance(true, robot, floor, others),
        speed=np.array([state.speed for state in states]),
        contacts=_contacts(trace, subject),
        robot=robot,
        others={name: poses for name, (_, poses) in others.items() if np.nanmax(np.ptp(poses, axis=0)) > 0.0},
    )


def _mirrored_poses(mirror: Trace, subject: str, ticks: int) -> Floats:
    """Return where a chair was mirrored at each tick of its laboratory, float64[ticks, 3].

    The laboratory may end before the mirror shows the last tick. So the pose of the tick before is repeated for it.
    """
    poses = mirror.poses(subject)[: max(1, ticks - 1)]
    return np.concatenate([poses, np.repeat(poses[-1:], ticks - len(poses), axis=0)])


def _mirrored_contacts(series: RunSeries, mirror: Trace | None, subject: str) -> tuple[Event, ...]:
    """Return the contacts of a chair in its mirror, for a chair in a laboratory."""
    if mirror is None:
        return ()
    return tuple(contact for contact in _contacts(mirror, subject) if contact.tick < len(series.times) - 1)


def _contacts(trace: Trace, subject: str) -> tuple[Event, ...]:
    return tuple(event for event in trace.events if event.code == "contact" and subject in (event.agent, event.other))


def _command_and_motion(states: list[TraceBody]) -> tuple[Floats | None, Floats]:
    """Return the user's command, None without a user, and what the motors got: float64[n, 2], forward and turn."""
    power = np.array([state.power for state in states[1:]], dtype=np.float64).reshape(-1, 2)
    done = np.column_stack([power.mean(axis=1), (power[:, 1] - power[:, 0]) / 2.0])
    if any(state.user is not None for state in states):
        return np.array([state.user or (0.0, 0.0) for state in states[1:]], dtype=np.float64).reshape(-1, 2), done
    if any(state.mode == MANUAL for state in states):
        return done, done
    return None, done
