"""Sonars at full size, against closed forms: `python -m tests.server.world.sonar_trials --pings 20000 --csv FILE`.

A row is a check: what was expected, what was found, the bound of the difference, and the number of pings. Shares are
bound by four standard deviations, distances by their rounding and one step of the jitter. The kept result is
`sonar_trials.csv` beside this file.
"""

from __future__ import annotations

import csv
import math
import random
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from intellwheels_schemas.messages import Proximity
from intellwheels_schemas.sonar_devices import DEVICES, THIN_DISTANCE, THIN_WIDTH, SonarDevice
from tests.server.world.sonars import heard, many, readings, solid, sonar
from tests.server.worlds import box_wall, cart, run, world
from tests.trial_command import trial_parser

KEPT = Path(__file__).parent / "sonar_trials.csv"
_AT_ONCE = 64


class Check(NamedTuple):
    """A line of the result.

    Attributes:
        check: What is checked.
        case: Of which device, and where.
        expected: By the closed form.
        found: In the simulation.
        bound: Largest difference that is no fault.
        pings: How many pings it took.
    """

    check: str
    case: str
    expected: float
    found: float
    bound: float
    pings: int

    @property
    def holds(self) -> bool:
        """Whether what was found is what was expected."""
        return abs(self.found - self.expected) <= self.bound


def _pings(count: int, distance: float, fields: dict[str, Any]) -> list[float | str]:
    """Return at least so many readings of a wall at a distance ahead of the body."""
    state = world(
        {"a": cart(proximity=many(_AT_ONCE, **fields))}, [box_wall(distance, -40.0, distance + 1.0, 40.0)], period=0.1
    )
    found: list[float | str] = []
    while len(found) < count:
        state, _ = run(state, 1)
        found += readings(state)
    return found


def _fields(name: str, device: SonarDevice) -> dict[str, Any]:
    return {
        "device": name, "cone_deg": device.cone_deg, "min_range": device.min_range, "max_range": device.max_range,
    }  # fmt: skip


def _share(check: str, case: str, expected: float, hits: int, pings: int) -> Check:
    bound = 4.0 * math.sqrt(expected * (1.0 - expected) / pings)
    return Check(check, case, expected, hits / pings, bound, pings)


def incidence(pings: int) -> Iterator[Check]:
    """Compare the share of direct returns with the declared probability, degree by degree."""
    for name, device in DEVICES.items():
        for degrees in range(math.ceil(device.limit_deg) + 2):
            found = _pings(pings, 1.0, {**_fields(name, device), "direction_deg": float(degrees)})
            falling = (device.limit_deg - degrees) / (device.limit_deg - device.sure_deg)
            expected = min(max(falling, 0.0), 1.0)
            yield _share(
                "direct return", f"{name} {degrees} deg", expected, sum(one != "none" for one in found), len(found)
            )


def jitter(pings: int) -> Iterator[Check]:
    """Compare the shares of the wavefronts, and the standard deviation, with the declared ones."""
    for name, device in DEVICES.items():
        step = 346.0 / device.frequency
        errors = [float(one) - 1.0 for one in _pings(pings, 1.0, _fields(name, device))]
        for steps, share in ((-1, 0.25), (0, 0.5), (1, 0.25)):
            hits = sum(abs(error - steps * step) < 2e-6 for error in errors)
            yield _share("wavefront", f"{name} {steps:+d}", share, hits, len(errors))
        deviation = math.sqrt(sum(error * error for error in errors) / len(errors))
        expected = step * math.sqrt(0.5)
        yield Check(
            "deviation of the jitter, m",
            name,
            expected,
            deviation,
            2.0 * expected / math.sqrt(len(errors)),
            len(errors),
        )


def thin(_pings: int) -> Iterator[Check]:
    """Compare the distance up to which a thing is heard with that of a cylinder."""
    for millimetres in (1.0, 2.0, 3.2, 5.0, 10.0, 25.0, 50.0, 80.0):
        width = 0.001 * millimetres
        near, far, count = 0.1, 9.9, 0
        while far - near > 1e-4:
            middle, count = 0.5 * (near + far), count + 1
            post = box_wall(middle, -0.5 * width, middle + width, 0.5 * width)
            is_heard = heard(world({"a": cart(proximity=(sonar(max_range=10.0),))}, [post], period=0.1)) != "none"
            near, far = (middle, far) if is_heard else (near, middle)
        expected = THIN_DISTANCE * (width / THIN_WIDTH) ** (1.0 / 3.0)
        yield Check("farthest thing, m", f"{millimetres:g} mm", expected, near, 2e-4, count)


def edges(pings: int) -> Iterator[Check]:
    """Compare the distance up to which the edge of a wedge is heard with the theory of diffraction, at random."""
    draw, wrong = random.Random(3), 0
    count = max(1, pings // 400)
    for _ in range(count):
        inside, lean = math.radians(draw.uniform(60.0, 150.0)), draw.uniform(-0.5, 0.5)
        outside = 2.0 * math.pi - inside
        # Between the normals of the two faces.
        phi = 0.5 * outside + lean * (outside - math.pi)
        n = outside / math.pi
        factor = 1.0 / (math.cos(math.pi / n) - 1.0) + 1.0 / (math.cos(math.pi / n) - math.cos(2.0 * phi / n))
        width = 0.00865 * (math.sin(math.pi / n) * factor / (math.pi * n)) ** 2
        limit = THIN_DISTANCE * (width / THIN_WIDTH) ** (1.0 / 3.0)
        for distance in (limit - 1e-3, limit + 1e-3):
            if not 0.55 < distance < 9.0:
                continue
            ends = [math.pi - phi, math.pi - phi + outside]  # of the faces, as they are seen from the edge
            wedge = solid((distance, 0.0), *((distance + 9.0 * math.cos(at), 9.0 * math.sin(at)) for at in ends))
            told = heard(world({"a": cart(proximity=(sonar(cone_deg=1.0, max_range=10.0),))}, [wedge], period=0.1))
            wrong += (told != "none") != (distance < limit)
    yield Check("edges that differ from diffraction", "random wedges", 0.0, wrong, 0.0, count)


def pillars(pings: int) -> Iterator[Check]:
    """Count the round pillars that a sonar with one before it, at random, does not hear at their nearest point."""
    draw, wrong = random.Random(4), 0
    count = max(1, pings // 400)
    for _ in range(count):
        sides, radius, turn = draw.randrange(12, 40), draw.uniform(0.1, 0.4), draw.uniform(0.0, 1.0)
        away = draw.uniform(1.5, 4.5)
        corners = [
            (
                away + radius * math.cos(turn + 2.0 * math.pi * k / sides),
                radius * math.sin(turn + 2.0 * math.pi * k / sides),
            )
            for k in range(sides)
        ]
        told = heard(world({"a": cart(proximity=(sonar(max_range=6.0),))}, [solid(*corners)]))
        # The nearest point of the polygon is nearer than its nearest corner by no more than it stands out.
        nearest = min(math.hypot(*corner) for corner in corners)
        least = away - radius - 0.00866
        wrong += isinstance(told, str) or not least <= told <= nearest + 0.00866
    yield Check("round pillars that are not heard", "random pillars", 0.0, wrong, 0.0, count)


def bounces(pings: int) -> Iterator[Check]:
    """Compare double bounces by a slanted wall with the distance from the image, at random."""
    draw, wrong, made = random.Random(1), 0, 0
    count = max(1, pings // 100)
    while made < count:
        turn = math.radians(draw.choice((-1.0, 1.0)) * draw.uniform(25.0, 60.0))
        first, second = draw.uniform(1.0, 2.5), draw.uniform(0.8, 2.0)
        along = (-math.sin(turn), math.cos(turn))
        corners = [(first + k * along[0], k * along[1]) for k in (-0.5, 0.5)]
        mirror = solid(*corners, *((x + math.cos(turn), y + math.sin(turn)) for x, y in reversed(corners)))
        way = (-math.cos(2.0 * turn), -math.sin(2.0 * turn))
        middle = (first + second * way[0], second * way[1])
        ends = [(middle[0] - k * way[1], middle[1] + k * way[0]) for k in (-0.3, 0.3)]
        if min(math.hypot(x, y) for x, y in (*ends, *corners, middle)) < 0.8:
            continue  # it would overlap the body
        made += 1
        wall = solid(*ends, *((x + 0.1 * way[0], y + 0.1 * way[1]) for x, y in reversed(ends)))
        told = heard(world({"a": cart(proximity=(sonar(cone_deg=8.0),))}, [mirror, wall]))
        wrong += isinstance(told, str) or abs(told - first - second) > 0.00865 + 1e-6
    yield Check("double bounces that differ from the image", "random walls", 0.0, wrong, 0.0, count)


def crosstalk(pings: int) -> Iterator[Check]:
    """Compare what is read of the pings of another with half of the way and of the lag, at random."""
    draw, wrong = random.Random(2), 0
    count = max(1, pings // 100)
    for _ in range(count):
        apart, group = draw.uniform(1.5, 4.5), draw.randrange(10)
        own, other = draw.uniform(0.0, 0.005), draw.uniform(0.0, 0.005)

        def at(**fields: Any) -> Proximity:
            return sonar(x=0.5, every=10, latency=7, **fields)

        robots = {
            "a": cart(proximity=(at(crosstalk=1.0, ping_delay=own, second_ping_delay=own),)),
            "b": cart(
                apart + 1.0, heading=math.pi, proximity=(at(group=group, ping_delay=other, second_ping_delay=other),)
            ),
        }
        state, _ = run(world(robots, period=0.005), 17)
        (told,) = readings(state)
        # The other pings once before and once after, 50 ms apart; its front is as far as its sonar.
        lags = [0.005 * (group + turn) + other - own for turn in (-10, 0)]
        ways = [0.5 * (apart + 346.0 * lag) for lag in lags]
        expected = min([apart, *(way for way in ways if 0.0 < way <= 5.0)])
        wrong += isinstance(told, str) or abs(told - expected) > 0.00865 + 1e-6
    yield Check("crosstalk that differs from its timing", "random pairs", 0.0, wrong, 0.0, count)


def checks(pings: int) -> list[Check]:
    """Return all checks, with so many pings for each share."""
    return [one for part in (incidence, jitter, thin, edges, pillars, bounces, crosstalk) for one in part(pings)]


def read(path: Path) -> list[Check]:
    """Return the checks of a file."""
    with path.open(encoding="utf-8") as text:
        return [
            Check(
                line["check"], line["case"], float(line["expected"]), float(line["found"]), float(line["bound"]),
                int(line["pings"]),
            )
            for line in csv.DictReader(text)
        ]  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return 1 if a check fails."""
    parser = trial_parser("tests.server.world.sonar_trials", __doc__, csv=KEPT)
    parser.add_argument(
        "--pings", type=int, default=20_000, metavar="N",
        help="number of pings from which a share is computed (default: 20000)",
    )  # fmt: skip
    given = parser.parse_args(arguments)
    found = checks(given.pings)
    with given.csv.open("w", newline="", encoding="utf-8") as text:
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(Check._fields)
        writer.writerows([*one[:2], *(f"{number:.6g}" for number in one[2:5]), one.pings] for one in found)
    failed = [one for one in found if not one.holds]
    sys.stdout.writelines(f"{one}\n" for one in failed)
    sys.stdout.write(f"checks={len(found)} failed={len(failed)}\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
