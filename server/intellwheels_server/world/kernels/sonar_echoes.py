"""Measurements of all sonars of all bodies in one tick: the nearest echo that returns, not the nearest thing.

A smooth wall reflects sound like a mirror: it is heard where the beam meets it at right angles. A wall that is not
heard there can still send the sound on, to something from which it returns by a longer way: see `sonar_bounces`. The
convex corners of walls echo too: see `sonar_corners`. Posts and bodies are rough, so they are heard from every side:
see `sonar_rough`. A thing that is too thin to be heard at its distance hides nothing. Other things hide what is behind
them, even if their own echo is lost.

Sonars may take the pings of others for their own echoes: see `sonar_crosstalk`. So only sonars have readings that
depend on the sensors of other bodies.

Source:
    Walls as mirrors: Kuc and Siegel (1987), Physically based simulation model for acoustic sensor robot navigation,
    IEEE Transactions on Pattern Analysis 9(6). The figures of a ping: `sonar_beam`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import face_columns
from intellwheels_server.world.kernels.arrays import Floats, Ints, Walls
from intellwheels_server.world.kernels.grid_search import Place
from intellwheels_server.world.kernels.noise import uniform
from intellwheels_server.world.kernels.proximity_wedges import (
    BEAM_FARTHEST,
    BEAM_NEAREST,
    BEAM_X,
    BEAM_Y,
    GROUP_BEGIN,
    GROUP_END,
    GROUP_OWNER,
    MOUNT_REACH,
    SAMPLE_WIDTH,
    STATUS_FAULT,
    STATUS_NEAR,
    STATUS_NONE,
    STATUS_OK,
    Beam,
    beam_at,
    mount_pose,
)
from intellwheels_server.world.kernels.sample_schedule import KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.sonar_beam import CROSSTALK, DROPOUT, DROPOUT_DRAW, STEP, THIN, jitter, wall_beam
from intellwheels_server.world.kernels.sonar_bounces import nearest_bounce
from intellwheels_server.world.kernels.sonar_corners import corner_width
from intellwheels_server.world.kernels.sonar_crosstalk import Sonars, hear_others, reach_of_others
from intellwheels_server.world.kernels.sonar_rough import add_view, is_in_wall, nearest_in_sight
from intellwheels_server.world.kernels.sonar_scene import Counts, Scene, gather_scene, scene_room
from intellwheels_server.world.kernels.sonar_sight import blocked
from intellwheels_server.world.kernels.sonar_surfaces import is_long_in_scene
from intellwheels_server.world.kernels.spatial_query import SLACK, place_bodies


@njit(cache=True, error_model="numpy")
def _nearest_smooth(
    beam: Beam, wall_cos: float, thin: float, wave: float, best: float, scene: Scene, counts: Counts
) -> float:
    """Return the distance of the nearest face or convex corner that the ping meets at right angles, m, at most `best`.

    Args:
        beam: The sonar in the world.
        wall_cos: Cosine of the angle off the axis up to which the ping hears walls.
        thin: What is narrower than this times the cube of its distance is not heard, 1/m2.
        wave: Wavelength, m.
        best: The distance of the nearest echo so far, m.
        scene: What is around the sonar.
        counts: How much of it there is.
    """
    x, y, z, direction_x, direction_y, _, _, _ = beam
    faces = scene.faces
    for face in range(counts.front):
        nx, ny = faces[face, face_columns.NX], faces[face, face_columns.NY]
        px, py = faces[face, face_columns.X] - x, faces[face, face_columns.Y] - y
        height = nx * px + ny * py
        if not 0.0 < -height < best or not faces[face, face_columns.LOW] <= z < faces[face, face_columns.HIGH]:
            continue
        along, length = ny * px - nx * py, faces[face, face_columns.LENGTH]
        if -SLACK <= along <= length + SLACK:
            if (
                -(nx * direction_x + ny * direction_y) >= wall_cos
                and is_long_in_scene(face, thin * height * height * -height, z, scene, counts)
                and not blocked(x, y, z, height * nx, height * ny, 0.0, thin, -1, scene, counts)
            ):
                best = -height
            continue
        # The face begins or ends beside the nearest point of its plane: its corner is nearer than all of it.
        if along > length:
            px, py = px - length * ny, py + length * nx
        square = px * px + py * py
        distance = math.sqrt(square)
        if distance >= best or direction_x * px + direction_y * py < wall_cos * distance:
            continue
        width = corner_width(
            x + px, y + py, z, -px, -py, wave, scene.near, scene.ranks, counts.near, scene.pieces, scene.links,
            scene.edges, scene.cells, scene.frame,
        )  # fmt: skip
        if width <= 0.0 or width < thin * distance * square:
            continue
        if not blocked(x, y, z, px, py, 0.0, thin, -1, scene, counts):
            best = distance
    return best


@njit(cache=True, error_model="numpy")
def _nearest_rough(beam: Beam, thin: float, best: float, scene: Scene, counts: Counts) -> float:
    """Return the distance of the nearest body or post in the cone, m, at most `best`; 0 inside one."""
    x, y, z, ahead_x, ahead_y, half_cos, half_sin, _ = beam
    right_x, right_y = ahead_x * half_cos + ahead_y * half_sin, ahead_y * half_cos - ahead_x * half_sin
    left_x, left_y = ahead_x * half_cos - ahead_y * half_sin, ahead_y * half_cos + ahead_x * half_sin
    for at in range(counts.boxes + counts.posts):
        thing = at if at < counts.boxes else counts.boxes + scene.posts[at - counts.boxes]
        if half_cos > 0.0:
            views = add_view(scene.views, 0, right_x, right_y, left_x, left_y)
        else:  # a cone of half a turn or more is looked at half by half
            views = add_view(scene.views, 0, right_x, right_y, ahead_x, ahead_y)
            views = add_view(scene.views, views, ahead_x, ahead_y, left_x, left_y)
        best = nearest_in_sight(thing, x, y, z, 0.0, 0.0, 0.0, views, thin, best, scene, counts)
    return best


@njit(cache=True, error_model="numpy")
def _store(
    tick: int, beams: Floats, figures: Floats, schedule: Ints, slots: Ints, heard: Floats, samples: Floats
) -> None:
    """Store the distances of the sonars that pinged, with their jitter, or the status if there is none."""
    for sonar in range(slots.shape[0]):
        slot, way = slots[sonar], heard[sonar]
        if slot < 0:
            continue
        nearest, farthest = beams[sonar, BEAM_NEAREST], beams[sonar, BEAM_FARTHEST]
        samples[slot + 1] = 0.0
        if figures[sonar, DROPOUT] > 0.0 and figures[sonar, DROPOUT] > uniform(
            np.uint64(schedule[sonar, KEY0]), np.uint64(schedule[sonar, KEY1]), tick, DROPOUT_DRAW
        ):
            samples[slot] = STATUS_FAULT
        elif way > farthest:
            samples[slot] = STATUS_NONE
        elif way < nearest or way == 0.0:
            samples[slot] = STATUS_NEAR
        else:
            samples[slot] = STATUS_OK
            samples[slot + 1] = min(max(way + jitter(figures, schedule, sonar, tick), nearest), farthest)


@njit(cache=True, error_model="numpy")
def _own_echo(
    beam: Beam, figures: Floats, schedule: Ints, sonar: int, tick: int, scene: Scene, counts: Counts
) -> float:
    """Return the distance of the nearest echo of a sonar's own ping, m; 0 inside something, inf for none."""
    if is_in_wall(beam.x, beam.y, beam.z, scene, counts):
        return 0.0
    thin, wave = figures[sonar, THIN], figures[sonar, STEP]
    wall_cos, wall_sin = wall_beam(figures, schedule, sonar, tick)
    # Slightly more than the range, so that a thing at the range itself is heard.
    limit = beam.farthest * (1.0 + SLACK)
    best = _nearest_smooth(beam, wall_cos, thin, wave, limit, scene, counts)
    best = _nearest_rough(beam, thin, best, scene, counts)
    if best > 0.0:
        best = nearest_bounce(beam, wall_cos, wall_sin, thin, wave, best, scene, counts)
    return best if best < limit else np.inf


@njit(cache=True, error_model="numpy")
def sense_sonars(
    tick: int,
    period: float,
    pose: Floats,
    parts: Floats,
    part_start: Ints,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    mounts: Floats,
    groups: Ints,
    beams: Floats,
    figures: Floats,
    schedule: Ints,
    samples: Floats,
) -> None:
    """Store the samples that all sonars take at a tick.

    Args:
        tick: The tick.
        period: Simulated time of a tick, s.
        pose: Pose block of the bodies, float64[>= 3, n].
        parts: Part block of the bodies.
        part_start: int64[n + 1], the first part of each body and the end.
        pieces: Of the walls.
        links: Of the walls.
        edges: Of the walls.
        cells: Of the walls.
        frame: Of the walls.
        mounts: float64[mounts, 4], as `proximity_wedges.sense_proximity` takes them, as the next two.
        groups: int64[mounts, 4].
        beams: float64[sonars, 9].
        figures: float64[sonars, 8], columns of `sonar_beam`.
        schedule: int64[sonars, 8].
        samples: float64[...], written: status and distance in metres.
    """
    count = beams.shape[0]
    slots = np.empty(count, np.int64)
    any_due = prone = False
    for sonar in range(count):
        slots[sonar] = due_slot(schedule, sonar, tick, SAMPLE_WIDTH)
        if slots[sonar] >= 0:
            any_due = True
            prone |= figures[sonar, CROSSTALK] > 0.0
    if not any_due:
        return
    placed = place_bodies(pose, parts, part_start)
    scene = scene_room(placed, Walls(pieces, links, edges, cells, frame))
    heard = np.full(count, np.inf)
    owners = np.empty(count, np.int64)
    poses = np.empty((count, 4))
    for mount in range(groups.shape[0]):
        x, y, c, s = mount_pose(mounts, groups, pose, mount)
        for sonar in range(groups[mount, GROUP_BEGIN], groups[mount, GROUP_END]):
            beam = beam_at(beams, sonar, x, y, c, s)
            owners[sonar] = groups[mount, GROUP_OWNER]
            poses[sonar, 0], poses[sonar, 1] = beam.x, beam.y
            poses[sonar, 2], poses[sonar, 3] = beam.direction_x, beam.direction_y
    # For finding the sonars near one of them.
    order = np.argsort(poses[:, 0], kind="mergesort") if prone else np.empty(0, np.int64)
    sonars = Sonars(
        beams, figures, schedule, owners, poses, order, poses[order, 0], 2.0 * beams[:, BEAM_FARTHEST].max()
    )
    for mount in range(groups.shape[0]):
        begin, end = groups[mount, GROUP_BEGIN], groups[mount, GROUP_END]
        any_due, spread = False, 0.0
        for sonar in range(begin, end):
            any_due |= slots[sonar] >= 0
            spread = max(spread, abs(beams[sonar, BEAM_X]) + abs(beams[sonar, BEAM_Y]))
        if not any_due:
            continue
        x, y, c, s = mount_pose(mounts, groups, pose, mount)
        reach, owner = mounts[mount, MOUNT_REACH] + SLACK, groups[mount, GROUP_OWNER]
        counts = gather_scene(Place(x, y, reach, owner, mount), spread, placed, scene)
        wanted = 0.0
        for sonar in range(begin, end):
            if slots[sonar] < 0:
                continue
            beam = beam_at(beams, sonar, x, y, c, s)
            heard[sonar] = _own_echo(beam, figures, schedule, sonar, tick, scene, counts)
            if heard[sonar] > 0.0 and figures[sonar, CROSSTALK] > 0.0:
                wanted = max(wanted, spread + reach_of_others(tick, period, sonar, heard[sonar], sonars))
        if wanted == 0.0:
            continue
        if wanted > reach:  # a ping may come from farther away than an echo
            place = Place(x, y, wanted + SLACK, owner, groups.shape[0] + mount)
            counts = gather_scene(place, spread, placed, scene)
        for sonar in range(begin, end):
            if slots[sonar] >= 0 and heard[sonar] > 0.0 and figures[sonar, CROSSTALK] > 0.0:
                heard[sonar] = hear_others(tick, period, sonar, heard[sonar], sonars, scene, counts)
    _store(tick, beams, figures, schedule, slots, heard, samples)
