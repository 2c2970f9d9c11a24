"""Run chairs with the mind `avoid` on the included maps with many seeds: what they touch, and whether one freezes.

    python -m tests.agents.avoid_trials --seeds 100 --csv FILE

A seed draws the robots and the starts of the chairs. Each map is run with one chair, and then with many: with fifteen
on the ward, and on the other maps with as many as there are places where a chair can turn and is clear of the others.
Each row of the CSV is one chair in one run. A contact counts if both parts that touch are at the height of the sensors.
A chair is frozen for as long as it moves less than 0.1 m and turns less than 0.3 rad in all. Exit code 1: a chair
touched something, or was frozen for more than 30 s.
"""

from __future__ import annotations

import csv
import math
import os
import random
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from itertools import pairwise
from pathlib import Path

from intellwheels_maps import floor, names, robot
from intellwheels_maps.turning import TurningCheck
from intellwheels_schemas.messages import Event, Map, Place
from intellwheels_schemas.rules import parts_of
from tests.agents.arena import Arena
from tests.trial_command import add_runs, trial_parser

ROBOTS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")
HEIGHT = 0.4
"""Height of the sensors of the included chairs, m."""
APART = 1.85
"""Two chairs that start so far from each other can both turn, m: twice the largest radius."""
MOST = 15
FROZEN = 30.0
"""Seconds after which a chair that does not move counts as frozen; chosen."""


@dataclass
class Row:
    """What one chair did."""

    ground: str
    chairs: int
    seed: int
    chair: str
    robot: str
    place: str
    contacts: int = 0
    other_contacts: int = 0
    frozen: float = 0.0
    frozen_at: str = ""
    travelled: float = 0.0
    tick_ms: float = 0.0


def starts(ground: str) -> list[str]:
    """Return places of a map at which chairs start clear of one another and can turn."""
    document = floor(ground)
    check = TurningCheck(document)
    found: list[Place] = []
    for place in document.grid.position if document.grid else ():
        fits = not place.kinds or "wheelchair" in place.kinds
        turns = all(check.narrowness(robot(name), place.x, place.y) is None for name in ROBOTS)
        if fits and turns and all(math.dist((place.x, place.y), (one.x, one.y)) > APART for one in found):
            found.append(place)
    return [place.name for place in found]


def trial(ground: str, chairs: int, seed: int, seconds: float) -> list[Row]:
    """Return what so many chairs did in a run."""
    draw = random.Random(f"avoid {ground} {chairs} {seed}")
    arena = Arena(ground, str(seed))
    rows = []
    for number, place in enumerate(draw.sample(starts(ground), chairs)):
        row = Row(ground, chairs, seed, f"chair{number + 1}", draw.choice(ROBOTS), place)
        arena.join(row.chair, "avoid", row.robot, place)
        rows.append(row)
    began = time.process_time()
    arena.run(seconds)
    spent = (time.process_time() - began) / (arena.state.tick * chairs)
    robots = {row.chair: row.robot for row in rows}
    for row in rows:
        path = arena.paths[row.chair]
        own = [event for event in arena.contacts() if row.chair in (event.agent, event.other)]
        row.contacts = sum(at_sensor_height(event, arena.setup.floor, robots) for event in own)
        row.other_contacts = len(own) - row.contacts
        row.travelled = round(sum(math.dist(a[:2], b[:2]) for a, b in pairwise(path)), 2)
        ticks, (x, y, heading) = longest_stand(path)
        row.frozen, row.frozen_at = round(ticks * arena.setup.period, 2), f"{x:.2f} {y:.2f} {math.degrees(heading):.0f}"
        row.tick_ms = round(1e3 * spent, 3)
    return rows


def at_sensor_height(event: Event, ground: Map, robots: Mapping[str, str]) -> bool:
    """Return whether both parts of a contact are at the height of the sensors; `robots` by the name of the body."""
    bodies = {name: robot(body) for name, body in robots.items()}

    def there(name: str | None, part: int | None) -> bool:
        if name is None or part is None:
            return True
        if name in bodies:
            one = parts_of(bodies[name])[part]
            return one.bottom <= HEIGHT < one.top
        solids = [*((wall.bottom, wall.height) for wall in ground.wall), *((o.bottom, o.top) for o in ground.obstacle)]
        bottom, top = solids[part]
        return bottom <= HEIGHT < top

    return there(event.agent, event.part) and there(event.other, event.other_part)


def longest_frozen(path: Sequence[tuple[float, float, float]]) -> int:
    """Return the most ticks for which a body stayed within 0.1 m of a pose and within 0.3 rad of its heading."""
    return longest_stand(path)[0]


def longest_stand(path: Sequence[tuple[float, float, float]]) -> tuple[int, tuple[float, float, float]]:
    """Return the same ticks, and the pose at which they began."""
    longest, where = 0, path[0]
    anchor, since = path[0], 0
    for tick, pose in enumerate(path):
        if math.dist(pose[:2], anchor[:2]) > 0.1 or abs(math.remainder(pose[2] - anchor[2], math.tau)) > 0.3:
            anchor, since = pose, tick
        if tick - since > longest:
            longest, where = tick - since, anchor
    return longest, where


def scenes(grounds: Sequence[str]) -> Iterator[tuple[str, int]]:
    """Return the maps with their numbers of chairs: one, and many."""
    for ground in grounds:
        many = min(MOST, len(starts(ground)))
        for chairs in sorted({1, many} - {0}):
            yield ground, chairs


def main(words: Sequence[str] | None = None) -> int:
    """Run the trials and return the exit code: 1 if a chair touched something or froze."""
    parser = trial_parser("tests.agents.avoid_trials", __doc__)
    add_runs(parser, "--seeds", 100, "runs of each map and number of chairs")
    parser.add_argument(
        "--seconds", type=float, default=300.0, metavar="S", help="simulated seconds of a run (default: 300)"
    )
    parser.add_argument(
        "--maps", nargs="+", default=names("floors"), metavar="MAP", help="maps (default: all that are included)"
    )
    parser.add_argument(
        "--chairs", type=int, metavar="N", help="only runs with this number of chairs (default: one, and many)"
    )
    given = parser.parse_args(words)
    bad = 0
    with (given.csv or Path(os.devnull)).open("w", newline="") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Row)], lineterminator="\n")
        writer.writeheader()
        for ground, chairs in scenes(given.maps):
            if given.chairs in (None, chairs):
                rows = []
                for seed in range(given.first, given.first + given.seeds):
                    found = trial(ground, chairs, seed, given.seconds)
                    rows += found
                    writer.writerows(asdict(row) for row in found)
                    file.flush()
                bad += report(rows)
    return 1 if bad else 0


def report(rows: Sequence[Row]) -> int:
    """Print what the chairs of a scene did in all runs, and return how many touched something or froze."""
    bad = [row for row in rows if row.contacts or row.frozen > FROZEN]
    print(
        f"{rows[0].ground} chairs={rows[0].chairs} rows={len(rows)} contacts={sum(row.contacts for row in rows)} "
        f"above-or-below={sum(row.other_contacts for row in rows)} frozen={max(row.frozen for row in rows)} "
        f"least-travelled={min(row.travelled for row in rows)} ms={max(row.tick_ms for row in rows)}",
        flush=True,
    )
    for row in bad:
        print(f"  {row}", flush=True)
    return len(bad)


if __name__ == "__main__":
    sys.exit(main())
