"""Trials of people against published figures, in this process, with a row of a CSV for each run:

    python -m tests.agents.person_trials door --seeds 40 --csv tests/agents/person_trials.csv     (the kept result)
    python -m tests.agents.person_trials                                                (the full size)
    python -m tests.agents.person_trials door --people 10 --width 0.9 --seeds 8
    python -m tests.agents.person_trials corridor --corridor-seeds 3

A door is in a wall of 0.1 m between two rooms. People start at random places before it, with random headings, and walk
to a point behind it. A run of the door ends when all have passed, or after 60 s. The flow is the number of people less
one, divided by the time from the first to the last passage and by the width. Corridors are endless (`corridor.py`).

Published: 1.3 to 1.9 /s/m at a door of 0.9 m (T. Kretz, A. Gruenebohm, M. Schreckenberg, Experimental study of
pedestrian flow through a bottleneck, J. Stat. Mech. 2006; A. Seyfried et al., New insights into pedestrian flow through
bottlenecks, Transportation Science 43, 2009). Speeds: U. Weidmann, Transporttechnik der Fussgaenger, ETH Zurich, 1993.
"""

from __future__ import annotations

import argparse
import csv
import math
import random
import statistics
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass

from intellwheels_agents.mind import Bridge, Mind
from intellwheels_schemas.messages import Actions, Corner, Map, Measures, Position, Wall
from tests.agents.arena import Arena
from tests.agents.minds.corridor import Corridor, weidmann
from tests.trial_command import add_runs, trial_parser

TIMEOUT = 60.0
"""Length of a run at a door, s."""
ROOM = 3.0
"""Half of the width of the rooms, m."""
STRETCH = {"MotorNoise": "0.05"}


@dataclass
class Row:
    """What one run gave.

    Attributes:
        trial: What was tried.
        people: Number of people.
        width: Width of the door or corridor, m.
        density: People per square metre.
        seed: Of the world and of the starts.
        passed: How many passed the door.
        seconds: Until the last one had passed, or the length of the run.
        flow: People per second and metre of width.
        speed: Mean speed along the corridor, m/s.
        weidmann: The same, as a share of Weidmann's at this density.
        order: Order parameter of the lanes, 0 (mixed) to 1.
        contacts: Contacts of people with people or walls.
        median_ms: Median time of a mind for a tick, ms of CPU.
    """

    trial: str
    people: int
    width: float
    density: float | None
    seed: int
    passed: int | None = None
    seconds: float | None = None
    flow: float | None = None
    speed: float | None = None
    weidmann: float | None = None
    order: float | None = None
    contacts: int = 0
    median_ms: float = 0.0


class Timed:
    """A mind whose time is measured."""

    def __init__(self, mind: Mind | Bridge, spent: list[float]) -> None:
        self._mind, self._spent = mind, spent

    def decide(self, measured: Measures) -> Actions:
        began = time.process_time()
        answer = self._mind.decide(measured)
        self._spent.append(time.process_time() - began)
        assert isinstance(answer, Actions)
        return answer


def timed(arena: Arena) -> list[float]:
    """Return the list that from now on gets the time of each tick of each mind, s."""
    spent: list[float] = []
    for player in arena.players.values():
        player.mind = Timed(player.mind, spent)
    return spent


def two_rooms(width: float) -> Map:
    """Return two rooms with an open door of a width (m) at the origin, in the wall between them."""
    far, half = 8.0, width / 2.0
    outline = [(-far, -ROOM), (far, -ROOM), (far, ROOM), (-far, ROOM), (-far, -ROOM)]
    lines = [outline, [(0.0, -ROOM), (0.0, -half)], [(0.0, half), (0.0, ROOM)]]
    walls = [Wall(corner=tuple(Corner(x=x, y=y) for x, y in line), height=2.5, thickness=0.1) for line in lines]
    return Map(format="iw.v1", name="rooms", wall=tuple(walls))


def random_starts(draw: random.Random, people: int) -> list[Position]:
    """Return places before the door that are at least 0.7 m apart."""
    found: list[Position] = []
    deep = 1.0 + 0.35 * people
    while len(found) < people:
        x, y = -draw.uniform(0.6, 0.6 + deep), draw.uniform(-1.8, 1.8)
        if all(math.dist((x, y), (other.x, other.y)) > 0.7 for other in found):
            found.append(Position(x=x, y=y, heading=draw.uniform(-math.pi, math.pi)))
    return found


def side_by_side(draw: random.Random) -> list[Position]:
    """Return the places of two people who stand side by side before the door and look at it."""
    x, apart = -draw.uniform(0.8, 2.0), draw.uniform(0.6, 0.8)
    return [Position(x=x, y=y, heading=0.0) for y in (-apart / 2.0, apart / 2.0)]


def at_door(trial: str, people: int, width: float, seed: int, *, through: bool = False) -> Row:
    """Return what people did at a door; with `through`, the middle of the door is a goal on the way."""
    draw = random.Random(f"{trial} {people} {seed}")
    starts = side_by_side(draw) if trial == "side by side" else random_starts(draw, people)
    arena = Arena(two_rooms(width), str(seed))
    for i, start in enumerate(starts):
        y = 0.8 * (i - (people - 1) / 2.0) if people <= 4 else draw.uniform(-2.0, 2.0)
        points = f"0 0 7 {y:.2f}" if through else f"7 {y:.2f}"
        arena.join(f"walker{i}", "person", "person", None, {"points": points, **STRETCH}, start)
    spent = timed(arena)
    passed: dict[str, float] = {}

    def all_passed(arena: Arena) -> bool:
        for name, path in arena.paths.items():
            if name not in passed and path[-1][0] > 0.0:
                passed[name] = arena.state.time
        return len(passed) == people

    took = arena.run(TIMEOUT, all_passed)
    times = sorted(passed.values())
    flow = (people - 1) / (times[-1] - times[0]) / width if len(times) == people > 1 else None
    return Row(
        trial, people, width, None, seed, len(passed), round(took, 2), rounded(flow), contacts=len(arena.contacts()),
        median_ms=milliseconds(spent),
    )  # fmt: skip


def in_corridor(density: float, width: float, seed: int, *, both_ways: bool, settle: float, seconds: float) -> Row:
    """Return how a crowd walked in an endless corridor, from random starts."""
    length = 8.0 if both_ways else 6.0
    crowd = Corridor(density, length, width, seed, random_starts=True, both_ways=both_ways)
    spent = timed(crowd.arena)
    speed = crowd.flow(settle, seconds) / density
    return Row(
        "both ways" if both_ways else "one way", crowd.count, width, density, seed, seconds=seconds,
        flow=rounded(speed * density), speed=rounded(speed), weidmann=rounded(speed / weidmann(density)),
        order=rounded(crowd.order) if both_ways else None, contacts=len(crowd.arena.contacts()),
        median_ms=milliseconds(spent),
    )  # fmt: skip


def rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 3)


def milliseconds(spent: list[float]) -> float:
    return round(1e3 * statistics.median(spent), 3)


def trials(given: argparse.Namespace) -> Iterator[Row]:
    """Yield the rows of the chosen trials."""
    seeds = range(given.first, given.first + given.seeds)
    if given.trial in ("all", "door"):
        for width in given.width:
            for seed in seeds:
                if 2 in given.people:
                    yield at_door("side by side", 2, width, seed)
            for people in given.people:
                for seed in seeds:
                    yield at_door("door", people, width, seed, through=given.through)
    if given.trial in ("all", "corridor"):
        for seed in range(given.first, given.first + given.corridor_seeds):
            for density in given.density:
                yield in_corridor(density, 2.0, seed, both_ways=False, settle=10.0, seconds=given.seconds)
            if given.both_ways:
                yield in_corridor(1.0, 3.0, seed, both_ways=True, settle=10.0, seconds=given.seconds)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = trial_parser("tests.agents.person_trials", __doc__)
    parser.add_argument(
        "trial", nargs="?", choices=("all", "door", "corridor"), default="all", help="what to try (default: all)"
    )
    parser.add_argument(
        "--people", type=int, nargs="+", default=[2, 4, 10], metavar="N",
        help="numbers of people at a door (default: 2 4 10)",
    )  # fmt: skip
    parser.add_argument(
        "--width", type=float, nargs="+", default=[0.8, 0.9, 1.0], metavar="M",
        help="widths of the door in metres (default: 0.8 0.9 1)",
    )  # fmt: skip
    add_runs(parser, "--seeds", 200, "runs of each door and number of people")
    parser.add_argument(
        "--corridor-seeds", type=int, default=5, metavar="N", help="number of runs of each corridor (default: 5)"
    )
    parser.add_argument(
        "--density", type=float, nargs="*", default=[1.0, 2.0], metavar="D",
        help="people per square metre of corridors in which all walk one way; none leaves these out (default: 1 2)",
    )  # fmt: skip
    parser.add_argument(
        "--no-both-ways", dest="both_ways", action="store_false",
        help="leave out the corridor in which half of the people walk the other way (default: with it)",
    )  # fmt: skip
    parser.add_argument(
        "--seconds", type=float, default=30.0, metavar="S", help="measured time of a corridor, s (default: 30)"
    )
    parser.add_argument(
        "--through", action="store_true",
        help="make the middle of the door a goal on the way (default: only the points behind it are goals)",
    )  # fmt: skip
    given = parser.parse_args(arguments)
    rows: list[Row] = []
    for row in trials(given):
        rows.append(row)
        if given.seeds <= 20 or row.passed not in (None, row.people):
            print(row, flush=True)
    summarise(rows)
    if given.csv:
        with given.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(asdict(rows[0])))
            writer.writeheader()
            writer.writerows(asdict(row) for row in rows)


def summarise(rows: list[Row]) -> None:
    """Print a line for each kind of run."""
    for kind in dict.fromkeys((row.trial, row.people, row.width, row.density) for row in rows):
        these = [row for row in rows if (row.trial, row.people, row.width, row.density) == kind]
        ended = sum(row.passed == row.people for row in these)
        words = [f"{len(these)} runs"] if kind[3] else [f"{ended} of {len(these)} runs ended"]
        for name in ("seconds", "flow", "speed", "weidmann", "order"):
            values = [value for row in these if (value := getattr(row, name)) is not None]
            if values:
                words.append(f"{name} {min(values):.2f} {statistics.median(values):.2f} {max(values):.2f}")
        words.append(f"contacts {sum(row.contacts for row in these)}")
        words.append(f"{statistics.median(row.median_ms for row in these):.2f} ms")
        print(*kind, *words, sep="  ")


if __name__ == "__main__":
    main()
