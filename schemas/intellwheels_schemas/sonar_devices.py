"""Sonars that exist, by their published figures. A figure without a source is marked as chosen.

Sources:
    FAQ: Devantech, Ultrasonic Rangers FAQ: beams at -6 dB, 346 m/s, 8.65 mm at 40 kHz, jitter by wavefronts.
    Maker: the technical documentation of the device.
    Cao and Borenstein (2002), Experimental characterization of Polaroid ultrasonic sensors in single and phased array
    configuration, SPIE AeroSense: flat walls echo up to 42 degrees, through side lobes.
    LoPresti, Sharma, Simpson and Mostowy (2011), Performance testing of collision-avoidance system for power
    wheelchairs, JRRD 48(5), 529-544: obstacles of 3.2 mm are detected at 1.6 m.
    Experimental modelling of time-of-flight sonar (1998), Robotics and Autonomous Systems 24, 33-42: the probability
    that a wall returns an echo directly falls with the angle of incidence. Its table was not at hand.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

SURE_SHARE: Final = 0.6
"""Share of the angle of the last echoes up to which echoes are sure, where no figure is published. Chosen, between the
15 of 42 degrees of the Polaroid sensor and the 7.5 of 9 degrees of the SRF235."""
THIN_WIDTH: Final = 0.0032
"""Width of the thinnest thing that is heard at `THIN_DISTANCE`, m. Source: LoPresti et al. (2011)."""
THIN_DISTANCE: Final = 1.6
"""The distance of that thing, m."""
FREQUENCY: Final = 40e3
"""Frequency of a sonar that is no listed device, Hz. Source: FAQ."""
PING_PERIOD: Final = 0.05
"""Time from a ping to the next one of a sonar that is no listed device, s: the shortest of the listed periods."""


SPEED_OF_SOUND: Final = 346.0
"""Speed of sound in air at 24 degrees, m/s. Source: FAQ."""


class SonarDevice(NamedTuple):
    """The figures of a device.

    Attributes:
        cone_deg: Full opening angle of the beam, degrees.
        min_range: Shortest distance, m.
        max_range: Longest distance, m.
        ping_period: Shortest time from a ping to the next one, s.
        frequency: Hz; the jitter has steps of a wavelength.
        sure_deg: Angle between the axis and the normal of a wall up to which the wall always echoes, degrees.
        limit_deg: Angle beyond which it never does, degrees.
        source: Where the figures come from.
    """

    cone_deg: float
    min_range: float
    max_range: float
    ping_period: float
    frequency: float
    sure_deg: float
    limit_deg: float
    source: str


def _listed(
    cone_deg: float, min_range: float, max_range: float, ping_period: float, source: str, frequency: float = FREQUENCY
) -> SonarDevice:
    """Return a device for which no angles of walls are published: the last echoes are at the edge of its beam."""
    limit = 0.5 * cone_deg
    return SonarDevice(
        cone_deg, min_range, max_range, ping_period, frequency, SURE_SHARE * limit, limit,
        f"{source}; the last echoes of walls at the edge of the beam and sure ones up to {SURE_SHARE:g} of it: chosen",
    )  # fmt: skip


DEVICES: Final[dict[str, SonarDevice]] = {
    "srf04": _listed(55.0, 0.03, 3.0, 0.05, "FAQ (beam), maker (range; no echo after 36 ms); period: chosen"),
    "srf08": _listed(55.0, 0.03, 6.0, 0.065, "FAQ (beam), maker (range, 65 ms)"),
    "srf10": _listed(72.0, 0.06, 6.0, 0.065, "FAQ (beam), maker (range, 65 ms)"),
    "srf485": _listed(30.0, 0.6, 5.0, 0.065, "FAQ (beam), maker (range); period and frequency: chosen"),
    "srf235": SonarDevice(
        15.0, 0.1, 1.2, 0.05, 235e3, 7.5, 9.0, "maker (beam, range, no echo of a wall beyond 9 degrees); period: chosen"
    ),
    "hc-sr04": _listed(15.0, 0.02, 4.0, 0.06, "maker (angle, range, 60 ms)"),
    "polaroid-6500": SonarDevice(
        30.0, 0.15, 10.7, 0.065, 49.4e3, 15.0, 42.0,
        "maker (range, frequency), Cao and Borenstein (beam, last echoes); period: chosen, sound goes 21.4 m in 62 ms",
    ),
}  # fmt: skip
"""The devices by name, as `Proximity.Device` names them."""


def reading_time(max_range: float, *delays: float) -> float:
    """Return the time from the tick of a sample of a sonar until all echoes within its range are back, s.

    Args:
        max_range: Its range, m.
        delays: From the tick to its pings, s.
    """
    return max(delays, default=0.0) + 2.0 * max_range / SPEED_OF_SOUND


def sample_time(device: str | None, max_range: float, delay: float, second_delay: float) -> float:
    """Return the shortest time from sample to sample of a sonar, s.

    Between two pings there is at least the longer of the period of the device and the time of the last echo. If the
    delays differ, every other ping follows sooner on the one before.

    Args:
        device: The name of its device, None if it is no listed one.
        max_range: Its range, m.
        delay: From the tick to the first, third, ... ping, s.
        second_delay: From the tick to the second, fourth, ... ping, s.
    """
    period = PING_PERIOD if device is None else DEVICES[device].ping_period
    return max(period, reading_time(max_range)) + abs(second_delay - delay)


def ticks_for(seconds: float, period: float) -> int:
    """Return the smallest number of ticks of a period, s, that last at least a time, s."""
    return math.ceil(seconds / period - 1e-9)
