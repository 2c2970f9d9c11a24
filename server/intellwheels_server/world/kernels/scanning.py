"""What every lidar of every body scans in one tick: exact ranges along rays, then the device's errors.

One call does all of them. A ray ends where it first enters a part or a wall piece whose z range holds its
height; nothing of its own body is seen. A sensor's draws are two a ray, of its own key.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    END_EDGE,
    FIRST_EDGE,
    HEADING,
    NORMAL_X,
    NORMAL_Y,
    Floats,
    Ints,
    X,
    Y,
)
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.noise import normal, uniform
from intellwheels_server.world.kernels.sight import ray_to_polygon
from intellwheels_server.world.kernels.surroundings import (
    CENTRE_X,
    CENTRE_Y,
    COS,
    EXTENT_X,
    EXTENT_Y,
    HIGH,
    LANES,
    LONG,
    LOW,
    SIN,
    SLACK,
    WIDE,
    gather,
    grid_of,
    place_boxes,
)  # fmt: skip
from intellwheels_server.world.kernels.timetable import BODY, KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.wedge import ray_to_box

# Columns of a scanner block, float64[sensors, 12]: pose in the world of one that is fixed there, place in the frame of
# its body or of that pose, height, range, standard deviation at least and as a share, least cosine of the angle
# between a ray and the normal of what it meets, share of rays that fail.
FIXED_X, FIXED_Y, FIXED_HEADING, EYE_X, EYE_Y, EYE_Z = 0, 1, 2, 3, 4, 5
NEAREST, FARTHEST, SIGMA, SIGMA_SHARE, LEAST_COS, DROPOUT = 6, 7, 8, 9, 10, 11

# Columns of a reel block, int64[sensors, 3]: 1 for one fixed in the world, first row of its rays, one past the last.
FIXED, FIRST_RAY, END_RAY = 0, 1, 2

# A sample: the time it was taken at, s, then for each ray the range, m, or one of these.
NONE, NEAR, FAULT = -1.0, -2.0, -3.0


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
    scanners: Floats,
    reels: Ints,
    directions: Floats,
    timetable: Ints,
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
        scanners: float64[sensors, 12].
        reels: int64[sensors, 3].
        directions: float64[rays, 2], unit vectors of the rays of all sensors, in the frame they are mounted in.
        timetable: int64[sensors, 8].
        samples: float64[...], written.
    """
    any_due = False
    for sensor in range(reels.shape[0]):
        if due_slot(timetable, sensor, tick, 1) >= 0:
            any_due = True
    if not any_due:
        return
    boxes, extents = place_boxes(pose, parts, part_start)
    low_x, low_y, size, columns, rows, cell_start, cell_bodies = grid_of(extents)
    widest_x = extents[:, 2].max()
    widest_y = extents[:, 3].max()
    solids = np.empty((pieces.shape[0], 10))
    around = np.empty((10, boxes.shape[0] + pieces.shape[0] + LANES))
    polygons = np.empty(pieces.shape[0], np.int64)
    gathered_for = np.full(pieces.shape[0], -1, np.int64)

    for sensor in range(reels.shape[0]):
        first_ray = reels[sensor, FIRST_RAY]
        count = reels[sensor, END_RAY] - first_ray
        slot = due_slot(timetable, sensor, tick, 1 + count)
        if slot < 0:
            continue
        owner = timetable[sensor, BODY]
        x, y, heading = pose[X, owner], pose[Y, owner], pose[HEADING, owner]
        if reels[sensor, FIXED] != 0:
            x, y, heading = scanners[sensor, FIXED_X], scanners[sensor, FIXED_Y], scanners[sensor, FIXED_HEADING]
        s, c = sincos(heading)
        x, y = (
            x + (c * scanners[sensor, EYE_X] - s * scanners[sensor, EYE_Y]),
            y + (s * scanners[sensor, EYE_X] + c * scanners[sensor, EYE_Y]),
        )
        z = scanners[sensor, EYE_Z]
        farthest = scanners[sensor, FARTHEST]
        reach = farthest + SLACK
        _, near, polygon_count = gather(
            x, y, reach, owner, sensor, part_start, boxes, extents, low_x, low_y, size, columns, rows, cell_start,
            cell_bodies, widest_x, widest_y, pieces, links, edges, cells, frame, solids, gathered_for, around, polygons,
        )  # fmt: skip
        rays = np.empty((2, count))
        for ray in range(count):
            a, b = directions[first_ray + ray, 0], directions[first_ray + ray, 1]
            rays[0, ray] = c * a - s * b
            rays[1, ray] = s * a + c * b
        ranges = np.full(count, np.inf)
        met = np.full(count, -1, np.int64)
        met_edge = np.full(count, -1, np.int64)
        _sweep_boxes(around, near, x, y, z, farthest, rays, ranges, met)
        for at in range(polygon_count):
            piece = polygons[at]
            if not solids[piece, LOW] <= z < solids[piece, HIGH]:
                continue
            first, end = links[piece, FIRST_EDGE], links[piece, END_EDGE]
            for ray in range(count):
                way, edge = ray_to_polygon(edges, first, end, x, y, rays[0, ray], rays[1, ray])
                if way < ranges[ray]:
                    ranges[ray] = way
                    met_edge[ray] = edge

        samples[slot] = tick * period
        key0, key1 = np.uint64(timetable[sensor, KEY0]), np.uint64(timetable[sensor, KEY1])
        nearest = scanners[sensor, NEAREST]
        least_cos = scanners[sensor, LEAST_COS]
        for ray in range(count):
            way = ranges[ray]
            if way > farthest:
                told = NONE
            elif way < nearest or way == 0.0:
                told = NEAR
            elif least_cos > 0.0 and least_cos > _incidence_cos(
                around, edges, met[ray], met_edge[ray], x, y, rays[0, ray], rays[1, ray], way
            ):
                told = NONE
            else:
                told = way
                sigma = max(scanners[sensor, SIGMA], scanners[sensor, SIGMA_SHARE] * way)
                if sigma > 0.0:
                    told = min(max(way + sigma * normal(key0, key1, tick, 2 * ray), nearest), farthest)
            dropout = scanners[sensor, DROPOUT]
            if dropout > 0.0 and uniform(key0, key1, tick, 2 * ray + 1) < dropout:
                told = FAULT
            samples[slot + 1 + ray] = told
