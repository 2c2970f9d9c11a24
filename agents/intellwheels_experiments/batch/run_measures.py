"""A run measured: from what was true and what was believed to a row of numbers. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import msgspec
import numpy as np

from intellwheels_experiments.batch import metrics
from intellwheels_experiments.batch.clearance import clearance, half_width, shortest_way
from intellwheels_experiments.batch.metrics import Floats
from intellwheels_experiments.batch.trace_reader import Trace, commanded, reported
from intellwheels_schemas.file_records import TraceBody
from intellwheels_schemas.messages import Event, Map, Robot, Scene

MANUAL: Final = "manual"
"""The mode of a mind that is its own user: what it gives is what is wanted."""


class Measured(msgspec.Struct, frozen=True, kw_only=True):
    """The numbers of a run; None where there is none.

    Attributes:
        success: It reached its place and touched nothing.
        reached: It was within its place at the end.
        collided: It touched something where it truly was, or, of a chair in a laboratory, a body that is in the
            simulation alone.
        contacts_physical: Episodes of contact with what is really there.
        contacts_virtual: Episodes of contact with what a simulation alone has there.
        clearance: Least distance from anything, m.
        time: Simulated time to the end, s.
        path: Length of the true path, m.
        shortest: Length of the shortest way, m.
        spl: Success weighted by path length.
        ldlj: Log dimensionless jerk of the speed while it moved.
        sparc: Spectral arc length of the same.
        effort: Way of the user's stick, in full deflections.
        agreement: Of what was done with what the user wanted.
        interventions: Times at which it did other than its user wanted, or was taken from its mind.
        odometry_error: Between reported and true place at the end, m.
        heading_error: Between reported and true heading at the end, rad, not negative.
        hash: Of the last state.
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
class Course:
    """A run along its time, arrays over its ticks.

    Attributes:
        times: s.
        true: float64[n, 3], x, y, heading.
        reported: The same as its own wheels tell, or None.
        commanded: The same as the powers alone lead.
        clearance: m.
        speed: m/s.
        contacts: The events.
        robot: The body as it joined.
        others: The other bodies that moved, by name: float64[n, 3].
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


def measured(
    trace: Trace, scene: Scene, floor: Map, subject: str, *, real: bool, image: Trace | None = None
) -> tuple[Measured, Course]:
    """Return the numbers of a run, and the run along its time.

    Args:
        trace: The world that its chair is truly in.
        scene: What was run.
        floor: Its floor.
        subject: Whose run it is.
        real: Whether what it touches there is really there.
        image: The world that shows the chair where it is reported, of a chair in a laboratory.
    """
    shown, robot = trace.shown(subject), trace.robots[subject]
    course = _course(trace, floor, subject, shown, robot, image)
    x, y, _ = course.true.T
    reach = next((one for one in scene.end.reach if one.agent == subject), None) if scene.end else None
    place = (
        next((one for one in floor.grid.position if reach and one.name == reach.place), None) if floor.grid else None
    )
    reached, shortest = True, math.nan
    if reach is not None and place is not None:
        reached = math.hypot(x[-1] - place.x, y[-1] - place.y) <= reach.within + 1e-9
        start = float(x[0]), float(y[0])
        shortest = max(0.0, shortest_way(floor, start, (place.x, place.y), half_width(robot)) - reach.within)
    contacts, length = len(course.contacts), metrics.path_length(x, y)
    seen = _seen(course, image, subject)
    # What stands in the simulation alone is touched there; its walls are in the laboratory too.
    touched = contacts + sum(one.other != "wall" for one in seen)
    success = reached and touched == 0
    rate = np.array([one.turn_rate for one in shown])
    movement = course.speed[metrics.moving(course.speed, rate)]
    wanted, done = _wish(shown)
    taken = sum(event.code == "taken" and event.agent == subject for event in trace.events)
    # The image of the last tick may not have been made any more.
    last = -1 if image is None else -2
    off = course.reported[last] - course.true[last] if course.reported is not None else np.full(3, math.nan)
    return (
        Measured(
            success=success,
            reached=reached,
            collided=touched > 0,
            contacts_physical=contacts if real else 0,
            contacts_virtual=len(seen) if real else contacts,
            clearance=_finite(float(course.clearance.min())),
            time=float(course.times[-1]),
            path=length,
            shortest=_finite(shortest),
            spl=_finite(metrics.success_weighted_by_path_length(success, shortest, length)),
            ldlj=_finite(metrics.log_dimensionless_jerk(movement, trace.heading.period)),
            sparc=_finite(metrics.spectral_arc_length(movement, trace.heading.period)),
            effort=metrics.user_effort(*wanted.T) if wanted is not None else None,
            agreement=_finite(metrics.agreement(wanted, done)) if wanted is not None else None,
            interventions=taken + (metrics.interventions(wanted, done) if wanted is not None else 0),
            odometry_error=_finite(float(np.hypot(off[0], off[1]))),
            heading_error=abs(math.remainder(float(off[2]), math.tau)) if math.isfinite(off[2]) else None,
            hash=trace.moments[-1].hash,
        ),
        course,
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _course(
    trace: Trace, floor: Map, subject: str, shown: list[TraceBody], robot: Robot, image: Trace | None
) -> Course:
    true = trace.poses(subject)
    others = {name: (other, trace.poses(name)) for name, other in trace.robots.items() if name != subject}
    return Course(
        times=trace.times,
        true=true,
        reported=reported(shown, robot) if image is None else _image(image, subject, len(shown)),
        commanded=commanded(shown, robot, trace.heading.period),
        clearance=clearance(true, robot, floor, others),
        speed=np.array([one.speed for one in shown]),
        contacts=_contacts(trace, subject),
        robot=robot,
        others={name: poses for name, (_, poses) in others.items() if np.nanmax(np.ptp(poses, axis=0)) > 0.0},
    )


def _image(image: Trace, subject: str, ticks: int) -> Floats:
    """Return where a chair was shown at each tick of its laboratory.

    The laboratory's last tick needs no more of the image than the tick before, so that is all there surely is: it
    stands for the last one too.
    """
    poses = image.poses(subject)[: max(1, ticks - 1)]
    return np.concatenate([poses, np.repeat(poses[-1:], ticks - len(poses), axis=0)])


def _seen(course: Course, image: Trace | None, subject: str) -> tuple[Event, ...]:
    """Return the contacts of a chair's image, of a chair in a laboratory."""
    if image is None:
        return ()
    return tuple(one for one in _contacts(image, subject) if one.tick < len(course.times) - 1)


def _contacts(trace: Trace, subject: str) -> tuple[Event, ...]:
    return tuple(one for one in trace.events if one.code == "contact" and subject in (one.agent, one.other))


def _wish(shown: list[TraceBody]) -> tuple[Floats | None, Floats]:
    """Return what the user wanted, None without a user, and what the motors got: float64[n, 2], forward and turn."""
    power = np.array([one.power for one in shown[1:]], dtype=np.float64).reshape(-1, 2)
    done = np.column_stack([power.mean(axis=1), (power[:, 1] - power[:, 0]) / 2.0])
    if any(one.user is not None for one in shown):
        return np.array([one.user or (0.0, 0.0) for one in shown[1:]], dtype=np.float64).reshape(-1, 2), done
    if any(one.mode == MANUAL for one in shown):
        return done, done
    return None, done
