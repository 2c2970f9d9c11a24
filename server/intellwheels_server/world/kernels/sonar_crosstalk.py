"""Crosstalk of sonars: the ping of another arrives while a sonar listens, and it takes the ping for its own echo.

The sound of the other comes straight, if the two face each other, or by one wall that both have in their beams. What
counts is when it arrives: a sonar that pings dt after another reads half of the way of the sound, less half of the way
that sound travels in dt. So a sonar that pings in another tick disturbs if its sound is still under way, and delays
that differ from ping to ping make the readings differ, by which a driver can tell them from echoes (EERUF).

A ping is heard over as long a way as its own echo: twice the range of the sonar that made it (chosen). So it may come
from farther away than the sonar that hears it can measure. A sonar listens from its shortest to its longest distance.
Sonars at one point never disturb each other: the sound of either comes back to both by the same way.

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
from intellwheels_server.world.kernels import face_columns
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.noise import uniform
from intellwheels_server.world.kernels.proximity_wedges import (
    BEAM_FARTHEST,
    BEAM_HALF_COS,
    BEAM_HALF_SIN,
    BEAM_NEAREST,
    BEAM_Z,
)
from intellwheels_server.world.kernels.sample_schedule import KEY0, KEY1
from intellwheels_server.world.kernels.sonar_beam import CROSSTALK, DELAY, SECOND_DELAY, STEP, THIN, ping_delay
from intellwheels_server.world.kernels.sonar_faces import segment_in_wedge
from intellwheels_server.world.kernels.sonar_scene import SKIN, Counts, Scene
from intellwheels_server.world.kernels.sonar_sight import blocked

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
        loudest: The longest way over which a ping of any of them is heard, m.
    """

    beams: Floats
    figures: Floats
    schedule: Ints
    owners: Ints
    poses: Floats
    order: Ints
    ordered_x: Floats
    loudest: float


@njit(cache=True, error_model="numpy")
def _hears(beams: Floats, poses: Floats, sonar: int, to_x: float, to_y: float) -> bool:
    """Return whether a direction, from a sonar, is in its cone."""
    ahead = poses[sonar, 2] * to_x + poses[sonar, 3] * to_y
    aside = poses[sonar, 2] * to_y - poses[sonar, 3] * to_x
    return bool(beams[sonar, BEAM_HALF_SIN] * ahead >= beams[sonar, BEAM_HALF_COS] * abs(aside))


@njit(cache=True, error_model="numpy")
def _first_lag(
    tick: int, period: float, sonar: int, other: int, longest: float, figures: Floats, schedule: Ints
) -> tuple[int, float]:  # fmt: skip
    """Return how many ticks before a ping of a sonar, or after, another makes the first one that can still arrive.

    Args:
        tick: When the sonar pings.
        period: Simulated time of a tick, s.
        sonar: The sonar.
        other: The other.
        longest: The longest way over which a ping is heard, m.
        figures: Of all sonars.
        schedule: Of all sonars.

    Returns:
        Ticks, and the delay of the sonar's own ping, s.
    """
    own_delay = ping_delay(figures, schedule, sonar, tick)
    last = max(figures[other, DELAY], figures[other, SECOND_DELAY])
    return math.floor((own_delay - last - longest / SPEED_OF_SOUND) / period), own_delay


@njit(cache=True, error_model="numpy")
def _earliest(
    tick: int, period: float, sonar: int, other: int, way: float, heard: float, beams: Floats, figures: Floats,
    schedule: Ints,
) -> float:  # fmt: skip
    """Return the shortest distance that a sonar reads of the pings of another, m, at most `heard`.

    Args:
        tick: When the sonar pings.
        period: Simulated time of a tick, s.
        sonar: The sonar.
        other: The other.
        way: Length of the way from the other to the sonar, m.
        heard: The distance that it reads without this, m.
        beams: Of all sonars, as the next two.
        figures: Of all sonars.
        schedule: Of all sonars.
    """
    nearest, farthest, share = beams[sonar, BEAM_NEAREST], beams[sonar, BEAM_FARTHEST], figures[sonar, CROSSTALK]
    key0, key1 = np.uint64(schedule[sonar, KEY0]), np.uint64(schedule[sonar, KEY1])
    earliest, own_delay = _first_lag(tick, period, sonar, other, way, figures, schedule)
    soonest = min(figures[other, DELAY], figures[other, SECOND_DELAY])
    latest = math.ceil((own_delay - soonest + 2.0 * farthest / SPEED_OF_SOUND) / period)
    for ticks in range(earliest, latest + 1):
        delay = ping_delay(figures, schedule, other, tick + ticks)
        if delay < 0.0:
            continue
        told = 0.5 * (way + SPEED_OF_SOUND * (ticks * period + delay - own_delay))
        if not nearest <= told <= farthest or not 0.0 < told < heard:
            continue
        # The key of the other and the tick of its ping as the index of the draw: each ping has a draw of its own,
        # whoever else is there.
        if share >= 1.0 or share > uniform(key0, key1, tick, schedule[other, KEY0] + ticks):
            heard = told
    return heard


@njit(cache=True, error_model="numpy")
def _longest_way(
    tick: int, period: float, sonar: int, other: int, limit: float, sonars: Sonars
) -> float:  # fmt: skip
    """Return the longest way of a ping of another that counts for less than a limit, m; 0 if none can.

    Args:
        tick: When the sonar pings.
        period: Simulated time of a tick, s.
        sonar: The sonar.
        other: The other.
        limit: The limit, m.
        sonars: All sonars.
    """
    beams, figures, schedule, poses = sonars.beams, sonars.figures, sonars.schedule, sonars.poses
    dx, dy = poses[other, 0] - poses[sonar, 0], poses[other, 1] - poses[sonar, 1]
    square = dx * dx + dy * dy
    loudest = 2.0 * beams[other, BEAM_FARTHEST]
    if other == sonar or square <= SKIN * SKIN or square > loudest * loudest:
        return 0.0
    if abs(figures[other, STEP] - figures[sonar, STEP]) > BAND * figures[sonar, STEP]:
        return 0.0
    shortest = math.sqrt(square)
    earliest, own_delay = _first_lag(tick, period, sonar, other, loudest, figures, schedule)
    soonest = min(figures[other, DELAY], figures[other, SECOND_DELAY])
    latest = math.ceil((own_delay - soonest + 2.0 * limit / SPEED_OF_SOUND) / period)
    longest = 0.0
    for ticks in range(earliest, latest + 1):
        delay = ping_delay(figures, schedule, other, tick + ticks)
        lag = SPEED_OF_SOUND * (ticks * period + delay - own_delay)
        if delay >= 0.0 and loudest + lag > 0.0 and shortest + lag <= 2.0 * limit:
            longest = max(longest, min(loudest, 2.0 * limit - lag))
    return longest


@njit(cache=True, error_model="numpy")
def reach_of_others(tick: int, period: float, sonar: int, heard: float, sonars: Sonars) -> float:
    """Return how far from a sonar the ways of the pings go that it may hear, m; 0 if it hears none.

    A way of a length between two points stays in an ellipse, so no point of it is farther from one of them than half of
    the length and half of the distance of the points.

    Args:
        tick: When it pings.
        period: Simulated time of a tick, s.
        sonar: The sonar.
        heard: The distance of its own echo, m, inf for none.
        sonars: All sonars.
    """
    poses, reach = sonars.poses, 0.0
    limit = min(heard, sonars.beams[sonar, BEAM_FARTHEST])
    for at in range(np.searchsorted(sonars.ordered_x, poses[sonar, 0] - sonars.loudest), sonars.order.shape[0]):
        other = sonars.order[at]
        dx, dy = poses[other, 0] - poses[sonar, 0], poses[other, 1] - poses[sonar, 1]
        if dx > sonars.loudest:
            break
        longest = _longest_way(tick, period, sonar, other, limit, sonars)
        if longest > 0.0:
            reach = max(reach, 0.5 * (longest + math.sqrt(dx * dx + dy * dy)))
    return reach


@njit(cache=True, error_model="numpy")
def _mirrors(sonar: int, reach: float, beams: Floats, poses: Floats, scene: Scene, counts: Counts) -> int:
    """Store the faces of which a sonar has a part in its cone and within reach in `close`; return how many."""
    faces, close = scene.faces, scene.close
    x, y, z = poses[sonar, 0], poses[sonar, 1], beams[sonar, BEAM_Z]
    half_cos, half_sin = beams[sonar, BEAM_HALF_COS], beams[sonar, BEAM_HALF_SIN]
    ahead_x, ahead_y = poses[sonar, 2], poses[sonar, 3]
    count = 0
    for face in range(counts.front):
        if not faces[face, face_columns.LOW] <= z < faces[face, face_columns.HIGH]:
            continue
        nx, ny, length = faces[face, face_columns.NX], faces[face, face_columns.NY], faces[face, face_columns.LENGTH]
        px, py = faces[face, face_columns.X] - x, faces[face, face_columns.Y] - y
        height = nx * px + ny * py
        if height > -SKIN or -height > reach:
            continue
        square, _, _ = segment_in_wedge(
            px, py, px - length * ny, py + length * nx, ahead_x, ahead_y, half_cos, half_sin
        )
        if square <= reach * reach:
            close[count] = face
            count += 1
    return count


@njit(cache=True, error_model="numpy")
def hear_others(
    tick: int, period: float, sonar: int, heard: float, sonars: Sonars, scene: Scene, counts: Counts
) -> float:  # fmt: skip
    """Return the distance that a sonar reads, m: its own echo, or the ping of another if that seems nearer.

    Args:
        tick: The tick.
        period: Simulated time of a tick, s.
        sonar: One that is prone to crosstalk and pings at this tick.
        heard: The distance of its own echo, m, inf for none.
        sonars: All sonars.
        scene: What is around its mount, as far as `reach_of_others`.
        counts: How much of it there is.
    """
    beams, figures, schedule, owners, poses, order, ordered_x, most = sonars
    faces, close = scene.faces, scene.close
    x, y, z, thin = poses[sonar, 0], poses[sonar, 1], beams[sonar, BEAM_Z], figures[sonar, THIN]
    limit = min(heard, beams[sonar, BEAM_FARTHEST])
    mirrors = -1
    for at in range(np.searchsorted(ordered_x, x - most), order.shape[0]):
        other = order[at]
        dx, dy = poses[other, 0] - x, poses[other, 1] - y
        if dx > most:
            break
        longest = _longest_way(tick, period, sonar, other, limit, sonars)
        if longest == 0.0:
            continue
        way = math.sqrt(dx * dx + dy * dy)
        if _hears(beams, poses, sonar, dx, dy) and _hears(beams, poses, other, -dx, -dy):
            told = _earliest(tick, period, sonar, other, way, heard, beams, figures, schedule)
            if told < heard and not blocked(x, y, z, dx, dy, 0.0, thin, owners[other], scene, counts):
                heard = told
        if mirrors < 0:  # only once, as most sonars hear no other
            mirrors = _mirrors(sonar, most, beams, poses, scene, counts)
        # By a wall: the other's image in a face, seen through the face.
        for at_mirror in range(mirrors):
            face = close[at_mirror]
            nx, ny = faces[face, face_columns.NX], faces[face, face_columns.NY]
            px, py = faces[face, face_columns.X] - x, faces[face, face_columns.Y] - y
            height, depth = nx * px + ny * py, nx * (px - dx) + ny * (py - dy)
            if depth > -SKIN:
                continue
            to_x, to_y = dx + 2.0 * depth * nx, dy + 2.0 * depth * ny
            square = to_x * to_x + to_y * to_y
            if square > longest * longest:
                continue
            share = height / (height + depth)
            ax, ay = share * to_x, share * to_y
            along = nx * (ay - py) - ny * (ax - px)
            if not 0.0 <= along <= faces[face, face_columns.LENGTH]:
                continue
            if not _hears(beams, poses, sonar, ax, ay) or not _hears(beams, poses, other, ax - dx, ay - dy):
                continue
            told = _earliest(tick, period, sonar, other, math.sqrt(square), heard, beams, figures, schedule)
            if not told < heard:
                continue
            if blocked(x, y, z, ax, ay, 0.0, thin, owners[other], scene, counts) or blocked(
                x + dx, y + dy, z, ax - dx, ay - dy, 0.0, thin, owners[other], scene, counts
            ):
                continue
            heard = told
    return heard
