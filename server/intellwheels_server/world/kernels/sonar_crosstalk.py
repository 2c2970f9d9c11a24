"""Crosstalk of sonars: the ping of another arrives while a sonar listens, and it takes the ping for its own echo.

The sound of the other comes straight, if the two face each other, or by one wall that both have in their beams. What
counts is when it arrives: a sonar that pings dt after another reads half of the way of the sound, less half of the way
that sound travels in dt. So a sonar that pings in another tick disturbs if its sound is still under way, and delays
that differ from ping to ping make the readings differ, by which a driver can tell them from echoes (EERUF).

A ping is heard over as long a way as its own echo: twice the range of the sonar that made it (chosen). Sonars at one
point never disturb each other: the sound of either comes back to both by the same way.

Source:
    Borenstein and Koren (1992), Noise rejection for ultrasonic sensors in mobile robot applications, IEEE ICRA;
    United States patent 5,239,515 (1993), Error-eliminating rapid ultrasonic firing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_schemas.sonar_devices import SPEED_OF_SOUND
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.noise import uniform
from intellwheels_server.world.kernels.proximity_wedges import BEAM_FARTHEST, BEAM_HALF_COS, BEAM_HALF_SIN, BEAM_Z
from intellwheels_server.world.kernels.sample_schedule import KEY0, KEY1
from intellwheels_server.world.kernels.sonar_beam import (
    CROSSTALK,
    DELAY,
    SECOND_DELAY,
    STEP,
    THIN,
    ping_delay,
)
from intellwheels_server.world.kernels.sonar_scene import (
    FACE_HIGH,
    FACE_LENGTH,
    FACE_LOW,
    FACE_NX,
    FACE_NY,
    FACE_X,
    FACE_Y,
    SKIN,
    Counts,
    Scene,
    blocked,
)

# Sonars hear each other if their wavelengths differ by no more than this share; chosen.
BAND = 0.05


class Sonars(NamedTuple):
    """All sonars at a tick.

    Attributes:
        beams: float64[sonars, 9], columns of `proximity_wedges`.
        figures: float64[sonars, 8], columns of `sonar_beam`.
        schedule: int64[sonars, 8].
        owners: int64[sonars], the body of each.
        poses: float64[sonars, 4], position, m, and unit vector of the direction, in the world.
        order: int64[sonars], sonars by their x; empty if none is prone to crosstalk.
        ordered_x: float64[sonars], their x, ascending.
    """

    beams: Floats
    figures: Floats
    schedule: Ints
    owners: Ints
    poses: Floats
    order: Ints
    ordered_x: Floats


@njit(cache=True, error_model="numpy")
def _hears(beams: Floats, poses: Floats, sonar: int, to_x: float, to_y: float) -> bool:
    """Return whether a direction, from a sonar, is in its cone."""
    ahead = poses[sonar, 2] * to_x + poses[sonar, 3] * to_y
    aside = poses[sonar, 2] * to_y - poses[sonar, 3] * to_x
    return bool(beams[sonar, BEAM_HALF_SIN] * ahead >= beams[sonar, BEAM_HALF_COS] * abs(aside))


@njit(cache=True, error_model="numpy")
def _earliest(
    tick: int, period: float, own_delay: float, way: float, heard: float, other: int, figures: Floats, schedule: Ints,
    farthest: float,
) -> float:  # fmt: skip
    """Return the shortest distance that a sonar reads of the pings of another, m, at most `heard`.

    Args:
        tick: When the sonar pings.
        period: Simulated time of a tick, s.
        own_delay: How long after the tick it pings, s.
        way: Length of the way from the other to the sonar, m.
        heard: The distance that it reads without this, m.
        other: The other sonar.
        figures: Of all sonars.
        schedule: Of all sonars.
        farthest: Range of the sonar, m.
    """
    # Ticks in which a ping can be made that arrives while the sonar listens.
    soonest = min(figures[other, DELAY], figures[other, SECOND_DELAY])
    last = max(figures[other, DELAY], figures[other, SECOND_DELAY])
    earliest = math.floor((own_delay - last - way / SPEED_OF_SOUND) / period)
    latest = math.ceil((own_delay - soonest + 2.0 * farthest / SPEED_OF_SOUND) / period)
    for ticks in range(earliest, latest + 1):
        delay = ping_delay(figures, schedule, other, tick + ticks)
        if delay < 0.0:
            continue
        told = 0.5 * (way + SPEED_OF_SOUND * (ticks * period + delay - own_delay))
        if 0.0 < told <= farthest:
            heard = min(heard, told)
    return heard


@njit(cache=True, error_model="numpy")
def _may_disturb(
    tick: int, period: float, own_delay: float, shortest: float, longest: float, limit: float, other: int,
    figures: Floats, schedule: Ints,
) -> bool:  # fmt: skip
    """Return whether pings of another on ways between two lengths can be told at less than a limit, m."""
    soonest = min(figures[other, DELAY], figures[other, SECOND_DELAY])
    last = max(figures[other, DELAY], figures[other, SECOND_DELAY])
    earliest = math.floor((own_delay - last - longest / SPEED_OF_SOUND) / period)
    latest = math.ceil((own_delay - soonest + 2.0 * limit / SPEED_OF_SOUND) / period)
    for ticks in range(earliest, latest + 1):
        delay = ping_delay(figures, schedule, other, tick + ticks)
        lag = SPEED_OF_SOUND * (ticks * period + delay - own_delay)
        if delay >= 0.0 and longest + lag > 0.0 and shortest + lag <= 2.0 * limit:
            return True
    return False


@njit(cache=True, error_model="numpy", inline="always")
def hear_others(
    tick: int,
    period: float,
    sonar: int,
    heard: float,
    sonars: Sonars,
    scene: Scene,
    counts: Counts,
    pieces: Floats,
    links: Ints,
    edges: Floats,
) -> float:
    """Return the distance that a sonar reads, m: its own echo, or the ping of another if that seems nearer.

    Args:
        tick: The tick.
        period: Simulated time of a tick, s.
        sonar: One that is prone to crosstalk and pings at this tick.
        heard: The distance of its own echo, m, inf for none.
        sonars: All sonars.
        scene: What is around its mount.
        counts: How much of it there is.
        pieces: Of the walls, as the next two.
        links: Of the walls.
        edges: Of the walls.
    """
    beams, figures, schedule, owners, poses, order, ordered_x = sonars
    boxes, box_owners, near, _, faces, _ = scene
    x, y, z = poses[sonar, 0], poses[sonar, 1], beams[sonar, BEAM_Z]
    farthest, thin = beams[sonar, BEAM_FARTHEST], figures[sonar, THIN]
    own_delay = ping_delay(figures, schedule, sonar, tick)
    for at in range(np.searchsorted(ordered_x, x - farthest), order.shape[0]):
        other = order[at]
        dx, dy = poses[other, 0] - x, poses[other, 1] - y
        if dx > farthest:
            break
        square = dx * dx + dy * dy
        if other == sonar or square <= SKIN * SKIN or square > farthest * farthest:
            continue
        if abs(figures[other, STEP] - figures[sonar, STEP]) > BAND * figures[sonar, STEP]:
            continue
        # The key of the other as the index of the draw: each ping has a draw of its own, whoever else is there.
        if figures[sonar, CROSSTALK] < 1.0 and figures[sonar, CROSSTALK] <= uniform(
            np.uint64(schedule[sonar, KEY0]), np.uint64(schedule[sonar, KEY1]), tick, schedule[other, KEY0]
        ):
            continue
        loudest = 2.0 * beams[other, BEAM_FARTHEST]
        way = math.sqrt(square)
        if not _may_disturb(
            tick, period, own_delay, way, loudest, min(heard, farthest), other, figures, schedule
        ):  # fmt: skip
            continue
        if way <= loudest and _hears(beams, poses, sonar, dx, dy) and _hears(beams, poses, other, -dx, -dy):
            told = _earliest(tick, period, own_delay, way, heard, other, figures, schedule, farthest)
            if told < heard and not blocked(
                x, y, z, dx, dy, 0.0, thin, owners[other], boxes, box_owners, counts.boxes, near, counts.near, pieces,
                links, edges,
            ):  # fmt: skip
                heard = told
        # By a wall: the other's image in a face, seen through the face.
        for face in range(counts.front):
            if not faces[face, FACE_LOW] <= z < faces[face, FACE_HIGH]:
                continue
            nx, ny = faces[face, FACE_NX], faces[face, FACE_NY]
            px, py = faces[face, FACE_X] - x, faces[face, FACE_Y] - y
            height, depth = nx * px + ny * py, nx * (px - dx) + ny * (py - dy)
            if height > -SKIN or depth > -SKIN:
                continue
            to_x, to_y = dx + 2.0 * depth * nx, dy + 2.0 * depth * ny
            way = math.sqrt(to_x * to_x + to_y * to_y)
            if way > loudest:
                continue
            share = height / (height + depth)
            ax, ay = share * to_x, share * to_y
            along = nx * (ay - py) - ny * (ax - px)
            if not 0.0 <= along <= faces[face, FACE_LENGTH] or ax * ax + ay * ay > farthest * farthest:
                continue
            if not _hears(beams, poses, sonar, ax, ay) or not _hears(beams, poses, other, ax - dx, ay - dy):
                continue
            told = _earliest(tick, period, own_delay, way, heard, other, figures, schedule, farthest)
            if not told < heard:
                continue
            if blocked(
                x, y, z, ax, ay, 0.0, thin, owners[other], boxes, box_owners, counts.boxes, near, counts.near, pieces,
                links, edges,
            ) or blocked(
                x + dx, y + dy, z, ax - dx, ay - dy, 0.0, thin, owners[other], boxes, box_owners, counts.boxes, near,
                counts.near, pieces, links, edges,
            ):  # fmt: skip
                continue
            heard = told
    return heard
