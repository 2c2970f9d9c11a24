"""The figures of a sonar, and what they make of one ping: how far off its axis it hears a wall, how its echo jitters.

An echo of a wall comes from the point where the beam meets it at right angles. Its probability is 1 up to the angle
`SURE` between this direction and the axis, and falls linearly to 0 at the angle `LIMIT`. A ping draws one number u for
all walls: it hears those within the angle at which the probability is u. So it draws a beam.

A thing returns an echo if its width is at least `THIN` times the cube of its distance: a cylinder of radius a sends
back a pressure that is proportional to sqrt(a) / r^1.5 at the distance r.

The threshold of a receiver is passed by the first, the second or the third wavefront of an echo. So a distance jitters
in steps of a wavelength. The device is calibrated to the second (chosen). It is the second in half of the pings, and
the first or the third in a quarter each (chosen).

Source:
    `intellwheels_schemas.sonar_devices` has the figures and their sources.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.elementary import PI, sincos
from intellwheels_server.world.kernels.noise import uniform
from intellwheels_server.world.kernels.sample_schedule import EVERY, JOINED, KEY0, KEY1

# Columns of a figure block, float64[sonars, 8]: share of samples that fail; share of the pings of others that are taken
# for an echo; angles of sure echoes and of the last echoes of walls, rad; least width over cube of distance, 1/m2;
# step of the jitter, m; delay of the first, third, ... ping after its tick and of the second, fourth, ..., s.
DROPOUT, CROSSTALK, SURE, LIMIT, THIN, STEP, DELAY, SECOND_DELAY = 0, 1, 2, 3, 4, 5, 6, 7
FIGURE_COLUMNS = 8

# Draws of a sonar and tick; `sonar_crosstalk` draws by the keys of others.
DROPOUT_DRAW, BEAM_DRAW, JITTER_DRAW = 0, 2, 3


@njit(cache=True, error_model="numpy")
def wall_beam(figures: Floats, schedule: Ints, sonar: int, tick: int) -> tuple[float, float]:
    """Return cosine and sine of the angle off the axis up to which a ping hears walls; (-1, 0) hears all around."""
    sure, limit = figures[sonar, SURE], figures[sonar, LIMIT]
    half = limit
    if sure < limit:
        key0, key1 = np.uint64(schedule[sonar, KEY0]), np.uint64(schedule[sonar, KEY1])
        half -= uniform(key0, key1, tick, BEAM_DRAW) * (limit - sure)
    if half >= PI:
        return -1.0, 0.0
    s, c = sincos(half)
    return c, s


@njit(cache=True, error_model="numpy")
def jitter(figures: Floats, schedule: Ints, sonar: int, tick: int) -> float:
    """Return by how much a ping's distance is too long, m: a step too short, exact, or a step too long."""
    key0, key1 = np.uint64(schedule[sonar, KEY0]), np.uint64(schedule[sonar, KEY1])
    draw = uniform(key0, key1, tick, JITTER_DRAW)
    if draw < 0.25:
        return -float(figures[sonar, STEP])
    return float(figures[sonar, STEP]) if draw > 0.75 else 0.0


@njit(cache=True, error_model="numpy")
def ping_delay(figures: Floats, schedule: Ints, sonar: int, tick: int) -> float:
    """Return how long after a tick a sonar pings, s; -1 if it does not ping."""
    age = tick - schedule[sonar, JOINED]
    if age < 0 or age % schedule[sonar, EVERY] != 0:
        return -1.0
    if age // schedule[sonar, EVERY] % 2 == 0:
        return float(figures[sonar, DELAY])
    return float(figures[sonar, SECOND_DELAY])
