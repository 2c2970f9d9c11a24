"""The robot of the Ciber-Rato simulator as a robot of the contract. Pure.

It is a disc of diameter 1 with two wheels. In a cycle of 50 ms a wheel travels what its motor gives, at most 0.15, and
the robot turns by the difference of both over the diameter. The motor gives half of what is wanted and half of what it
gave before, times a normal random number.

A body of the contract has boxes: 15 of them fill the disc, with their corners on its edge, so that a robot fits where
the disc fits. Between the corners up to 24 mm are missing.

Three things differ. A robot that meets an obstacle slides along it; there it only turned. An obstacle sensor measures
the nearest point in its cone; there it was the nearest of three rays and of all corners, up to 1/cos(15 degrees) times
as far. The speed of a wheel lags without steps within a cycle: a wheel that starts falls behind by 0.44 (1/ln 2 - 1) of
its travel in a cycle.

Source:
    The public tools of the simulator (github.com/iris-ua/ciberRatoTools): its robot, motor and sensors, and the noise
    of its default parameters.
"""

from __future__ import annotations

import math
from typing import Final

from intellwheels_agents.ciber_gateway.client_messages import Registration
from intellwheels_agents.ciber_gateway.lab_frame import KIND, Lab
from intellwheels_schemas.messages import GPS, Beacon, Compass, Ground, Part, Proximity, Robot

RADIUS: Final = 0.5
"""Radius of the robot, m."""
MOST_POWER: Final = 0.15
"""Largest power of a motor: travel of a wheel in a cycle, m."""
CYCLE: Final = 0.05
"""Length of a cycle, s."""
TOP_SPEED: Final = 3.3
"""Speed of a wheel at power 1, m/s. It is 10 % above that of the largest power, so that the noise is not cut there."""
TOP: Final = 0.5
"""Height of the robot, m; the simulator has none."""
SENSOR_HEIGHT: Final = 0.25
"""Height of the obstacle sensors, m."""
CONE_DEG: Final = 60.0
"""Opening of an obstacle sensor, degrees."""
FARTHEST: Final = 20.0
"""Range of an obstacle sensor, m. Farther away its value rounds to 0."""
MOST_BEACONS: Final = 32
"""Most beacons that a robot has sensors for."""
BOXES: Final = 15
GROUNDS: Final = 8
"""Ground sensors on the edge. A robot is in a target if its whole disc is."""


def ciber_robot(registration: Registration, lab: Lab, *, gps: bool, beacons: bool, beacon_height: float) -> Robot:
    """Return the robot that an agent registers.

    Args:
        registration: The directions of its obstacle sensors.
        lab: The beacons.
        gps: Whether it has a GPS.
        beacons: Whether it has sensors for beacons.
        beacon_height: Height of the beacons, m. Walls that are at least as high hide them.
    """
    places = lab.beacons[:MOST_BEACONS] if beacons else ()
    return Robot(
        kind=KIND,
        top_speed=TOP_SPEED,
        acceleration_curve=0.5,
        track=2.0 * RADIUS,
        wheel_diameter=0.4,
        motor_noise=0.015,
        part=_disc(),
        proximity=tuple(_obstacle_sensor(index, angle) for index, angle in enumerate(registration.angles)),
        compass=(Compass(id="compass", noise_deg=2.0, step_deg=1.0),),
        gps=(GPS(id="gps", noise=0.5, step=0.1),) if gps else (),
        beacon=tuple(_beacon_sensor(index, place.name, beacon_height) for index, place in enumerate(places)),
        ground=tuple(_ground_sensor(index) for index in range(GROUNDS)) if lab.targets else (),
    )


def _obstacle_sensor(index: int, angle: float) -> Proximity:
    angle = math.remainder(angle, 360.0)
    direction = math.radians(angle)
    return Proximity(
        id=f"ir{index}", x=RADIUS * math.cos(direction), y=RADIUS * math.sin(direction), z=SENSOR_HEIGHT,
        direction_deg=angle, cone_deg=CONE_DEG, min_range=0.0, max_range=FARTHEST,
    )  # fmt: skip


def _beacon_sensor(index: int, place: str, height: float) -> Beacon:
    return Beacon(id=f"beacon{index}", place=place, z=height, max_range=1000.0, noise_deg=2.0, step_deg=1.0)


def _ground_sensor(index: int) -> Ground:
    angle = 2.0 * math.pi * index / GROUNDS
    return Ground(id=f"ground{index}", x=RADIUS * math.cos(angle), y=RADIUS * math.sin(angle))


def _disc() -> tuple[Part, ...]:
    """Return boxes with their corners on the edge of the disc."""
    angles = [math.pi / 2 * (index + 1) / (BOXES + 1) for index in range(BOXES)]
    return tuple(
        Part(
            x=0.0, y=0.0, length=2.0 * RADIUS * math.cos(angle), width=2.0 * RADIUS * math.sin(angle),
            bottom=0.0, top=TOP,
        )
        for angle in angles
    )  # fmt: skip
