"""The scans of all lidars of all bodies in one tick: exact ranges along rays, then the errors of the device.

One call serves all of them. A ray ends where it first enters a part or a wall piece whose z range contains its
height. A lidar does not see its own body. Each ray takes two random numbers, drawn with the key of the sensor.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import END_EDGE, FIRST_EDGE, NORMAL_X, NORMAL_Y, Floats, Ints, Walls
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.grid_search import Place
from intellwheels_server.world.kernels.line_of_sight import ray_to_polygon
from intellwheels_server.world.kernels.noise import normal, uniform
from intellwheels_server.world.kernels.sample_schedule import BODY, KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.spatial_query import (
    CENTRE_X,
    CENTRE_Y,
    COS,
    EXTENT_X,
    EXTENT_Y,
    HIGH,
    LONG,
    LOW,
    SIN,
    SLACK,
    WIDE,
    Found,
    gather_bodies,
    gather_walls,
    place_bodies,
    room_for,
)
from intellwheels_server.world.kernels.wedge_distance import ray_to_box

# Columns of a lidar block, float64[sensors, 12]: pose of its mount if fixed in the world; position in the frame of
# its mount, and height; range; smallest standard deviation, and the same as a share; smallest cosine of the angle
# between a ray and the normal of the surface that it meets; share of rays that fail.
LIDAR_FIXED_X, LIDAR_FIXED_Y, LIDAR_FIXED_HEADING, LIDAR_X, LIDAR_Y, LIDAR_Z = 0, 1, 2, 3, 4, 5
LIDAR_NEAREST, LIDAR_FARTHEST, LIDAR_SIGMA, LIDAR_SIGMA_SHARE, LIDAR_LEAST_COS, LIDAR_DROPOUT = 6, 7, 8, 9, 10, 11

# Columns of a scan block, int64[sensors, 3]: 1 for one fixed in the world, first row of its rays, one past the last.
SCAN_FIXED, FIRST_RAY, END_RAY = 0, 1, 2

# A sample: the time it was taken at, s, then for each ray the range, m, or one of these.
RANGE_NONE, RANGE_NEAR, RANGE_FAULT = -1.0, -2.0, -3.0


@njit(cache=True, error_model="numpy")
def _sweep_boxes(
    around: Floats, near: int, x: float, y: float, z: float, farthest: float, rays: Floats, ranges: Floats, met: Ints
) -> None:
    """Shorten ranges to where rays (unit vectors in the world, rows x and y) enter boxes; note which box."""
    limit = farthest * farthest + SLACK
    for at in range(near):
        gap_x = max(abs(around[CENTRE_X, at] - x) - around[EXTENT_X, at], 0.0)
        gap_y = max(abs(around[CENTRE_Y, at] - y) - around[EXTENT_Y, at], 0.0)
        if gap_x * gap_x + gap_y * gap_y > limit or not around[LOW, at] <= z < around[HIGH, at]:
            continue
        c = around[COS, at]
        s = around[SIN, at]
        dx = x - around[CENTRE_X, at]
        dy = y - around[CENTRE_Y, at]
        u = c * dx + s * dy
        v = c * dy - s * dx
        half_length = around[LONG, at]
        half_width = around[WIDE, at]
        for ray in range(ranges.shape[0]):
            way = ray_to_box(
                u,
                v,
                c * rays[0, ray] + s * rays[1, ray],
                c * rays[1, ray] - s * rays[0, ray],
                half_length,
                half_width,
            )
            shorter = way < ranges[ray]
            ranges[ray] = max(way, 0.0) if shorter else ranges[ray]
            met[ray] = at if shorter else met[ray]


@njit(cache=True, error_model="numpy")
def _incidence_cos(
    around: Floats, edges: Floats, met: int, edge: int, x: float, y: float, dx: float, dy: float, way: float
) -> float:
    """Return the cosine of the angle between a ray and the normal of the face it enters."""
    if edge >= 0:
        return float(abs(edges[edge, NORMAL_X] * dx + edges[edge, NORMAL_Y] * dy))
    c = around[COS, met]
    s = around[SIN, met]
    px = x + way * dx - around[CENTRE_X, met]
    py = y + way * dy - around[CENTRE_Y, met]
    from_end = abs(abs(c * px + s * py) - around[LONG, met])
    from_side = abs(abs(c * py - s * px) - around[WIDE, met])
    return float(abs(c * dx + s * dy) if from_end < from_side else abs(c * dy - s * dx))


@njit(cache=True, error_model="numpy")
def _sweep(
    around: Floats, polygons: Ints, solids: Floats, links: Ints, edges: Floats, found: Found, x: float, y: float,
    z: float, farthest: float, rays: Floats, ranges: Floats, met: Ints, met_edge: Ints,
) -> None:  # fmt: skip
    """Shorten ranges to where rays enter the gathered things; note which box or which edge of a wall piece."""
    _sweep_boxes(around, found.boxes, x, y, z, farthest, rays, ranges, met)
    for at in range(found.polygons):
        piece = polygons[at]
        if not solids[piece, LOW] <= z < solids[piece, HIGH]:
            continue
        first, end = links[piece, FIRST_EDGE], links[piece, END_EDGE]
        for ray in range(ranges.shape[0]):
            way, edge = ray_to_polygon(edges, first, end, x, y, rays[0, ray], rays[1, ray])
            if way < ranges[ray]:
                ranges[ray] = way
                met_edge[ray] = edge


@njit(cache=True, error_model="numpy")
def _measure(
    around: Floats, edges: Floats, x: float, y: float, rays: Floats, ranges: Floats, met: Ints, met_edge: Ints,
    lidars: Floats, schedule: Ints, sensor: int, tick: int, slot: int, samples: Floats,
) -> None:  # fmt: skip
    """Store the ranges of a lidar with its errors, at index `slot` of the samples."""
    key0, key1 = np.uint64(schedule[sensor, KEY0]), np.uint64(schedule[sensor, KEY1])
    nearest, farthest = lidars[sensor, LIDAR_NEAREST], lidars[sensor, LIDAR_FARTHEST]
    least_cos, dropout = lidars[sensor, LIDAR_LEAST_COS], lidars[sensor, LIDAR_DROPOUT]
    for ray in range(ranges.shape[0]):
        way = ranges[ray]
        if way > farthest:
            value = RANGE_NONE
        elif way < nearest or way == 0.0:
            value = RANGE_NEAR
        elif least_cos > 0.0 and least_cos > _incidence_cos(
            around, edges, met[ray], met_edge[ray], x, y, rays[0, ray], rays[1, ray], way
        ):
            value = RANGE_NONE
        else:
            value = way
            sigma = max(lidars[sensor, LIDAR_SIGMA], lidars[sensor, LIDAR_SIGMA_SHARE] * way)
            if sigma > 0.0:
                value = min(max(way + sigma * normal(key0, key1, tick, 2 * ray), nearest), farthest)
        if dropout > 0.0 and uniform(key0, key1, tick, 2 * ray + 1) < dropout:
            value = RANGE_FAULT
        samples[slot + ray] = value


@njit(cache=True, error_model="numpy")
def scan(
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
    lidars: Floats,
    scans: Ints,
    directions: Floats,
    schedule: Ints,
    samples: Floats,
) -> None:
    """Store the samples that all lidars take at a tick.

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
        lidars: float64[sensors, 12], columns `LIDAR_FIXED_X` to `LIDAR_DROPOUT`.
        scans: int64[sensors, 3], columns `SCAN_FIXED` to `END_RAY`.
        directions: float64[rays, 2], unit vectors of the rays of all sensors, in the frame they are mounted in.
        schedule: int64[sensors, 8].
        samples: float64[...], written.
    """
    any_due = False
    for sensor in range(scans.shape[0]):
        if due_slot(schedule, sensor, tick, 1) >= 0:
            any_due = True
    if not any_due:
        return
    placed, walls = place_bodies(pose, parts, part_start), Walls(pieces, links, edges, cells, frame)
    nearby = room_for(placed, walls)
    _, boxes, extents, cell_start, cell_bodies, grid = placed
    around, polygons, solids, filled, indices, found_for = nearby
    for sensor in range(scans.shape[0]):
        first_ray = scans[sensor, FIRST_RAY]
        count = scans[sensor, END_RAY] - first_ray
        slot = due_slot(schedule, sensor, tick, 1 + count)
        if slot < 0:
            continue
        owner = schedule[sensor, BODY]
        x, y, heading = pose[rows.X, owner], pose[rows.Y, owner], pose[rows.HEADING, owner]
        if scans[sensor, SCAN_FIXED] != 0:
            x, y = lidars[sensor, LIDAR_FIXED_X], lidars[sensor, LIDAR_FIXED_Y]
            heading = lidars[sensor, LIDAR_FIXED_HEADING]
        s, c = sincos(heading)
        x, y = (
            x + (c * lidars[sensor, LIDAR_X] - s * lidars[sensor, LIDAR_Y]),
            y + (s * lidars[sensor, LIDAR_X] + c * lidars[sensor, LIDAR_Y]),
        )
        farthest = lidars[sensor, LIDAR_FARTHEST]
        place = Place(x, y, farthest + SLACK, owner, sensor)
        of_bodies = gather_bodies(place, part_start, boxes, extents, cell_start, cell_bodies, grid, around, indices)
        near, polygon_count = gather_walls(
            place, pieces, links, edges, cells, frame, of_bodies, around, polygons, solids, filled, indices, found_for
        )
        found = Found(of_bodies, near, polygon_count)
        rays = np.empty((2, count))
        for ray in range(count):
            a, b = directions[first_ray + ray, 0], directions[first_ray + ray, 1]
            rays[0, ray] = c * a - s * b
            rays[1, ray] = s * a + c * b
        ranges = np.full(count, np.inf)
        met, met_edge = np.full(count, -1, np.int64), np.full(count, -1, np.int64)
        _sweep(
            around, polygons, solids, links, edges, found, x, y, lidars[sensor, LIDAR_Z], farthest, rays, ranges, met,
            met_edge,
        )  # fmt: skip
        samples[slot] = tick * period
        _measure(around, edges, x, y, rays, ranges, met, met_edge, lidars, schedule, sensor, tick, slot + 1, samples)
